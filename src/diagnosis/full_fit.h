#pragma once
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "diagnosis/answers.h"
#include "diagnosis/posterior_search.h"

namespace mm {

/// One look at the session: what was fitted, what is asked, what was found.
struct Look {
  std::unique_ptr<ResidualSpace> space;
  Questions questions;
  Explanation found;
  std::shared_ptr<PosteriorAnswer> posterior;  // where the answer was drawn from it
  double tailDof = 0.0;
  Explanation likeliest;  // with those that do not clearly predict rows that were not seen
  /// These: the probability that they predict anything.
  std::map<std::string, double> doubted;
};

/// The model with everything that a look found, fitted to the session as a calibration would fit it. The
/// search goes by a linearised model; this is what a user gets who adds what it found, and it has the last
/// word on what a cause is worth.
class FullFit {
 public:
  /// @param model with what its networks have learned. @param options by which it was fitted without them.
  FullFit(const Session& session, const Model& model, const CalibrateOptions& options)
      : session_(session), model_(model), options_(options) {}

  /// The model's effects and those that were found, as the search goes on from them.
  struct Start {
    std::vector<EffectPtr> found;
    Eigen::VectorXd x;  // of the model's parameters, then theirs; SI
  };
  /// Where a fit of it begins: with the sizes of the linearised search.
  Start startOf(const Look& look) const;
  /// The model with more effects.
  Model with(const std::vector<EffectPtr>& more) const;
  /// Takes out what does nothing in the model: a cause whose size is within its expanded uncertainty, and a
  /// shape that becomes no more than part of a curve. What was behind it is looked for again.
  void dropWhatDoesNothing(Look& look, const CalibrationResult& fitted) const;
  /// Values and uncertainties of what was found, for the diagnosis.
  void takeSizes(const Look& look, const CalibrationResult& fitted, Diagnosis& out) const;

 private:
  bool dropOnce(Look& look, const CalibrationResult& fitted, int& bans) const;  // whether anything was
  Session withScatter(const Look& look) const;
  CalibrationResult fit(const Look& look, const CalibrationResult& fitted,
                        const std::vector<EffectPtr>& effects, const Eigen::VectorXd& start) const;

  const Session& session_;
  const Model& model_;
  const CalibrateOptions& options_;
};

}  // namespace mm
