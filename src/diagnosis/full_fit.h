#pragma once
#include <memory>
#include <vector>

#include "diagnosis/answers.h"
#include "diagnosis/posterior_search.h"

namespace mm {

/// One look at the session: what was fitted, what is asked, what was found.
struct Look {
  std::unique_ptr<CalibrationResult> fitted;  // what is left by it is asked
  std::unique_ptr<ResidualSpace> space;
  Questions questions;
  Eigen::VectorXd variance;  // of the white noise, a row
  Explanation found;
  PosteriorAnswer posterior;
  double tailDof = 0.0;
};

/// The model with everything that a look found, fitted to the session as a calibration would fit it. The
/// posterior goes by a linearised model; this is what a user gets who adds what it found.
class FullFit {
 public:
  /// @param model with what its networks have learned. @param options by which it was fitted without them.
  FullFit(const Session& session, const Model& model, const CalibrateOptions& options)
      : session_(session), model_(model), options_(options) {}

  /// The model's effects and those that were found, as they were found.
  struct Start {
    std::vector<EffectPtr> found;
    Eigen::VectorXd x;               // of the model's parameters, then theirs; SI
    std::vector<char> undetermined;  // of those found, whose time constant the session does not tell
  };
  /// Where a fit of it begins: with the sizes of the linearised model.
  Start startOf(const Look& look, const Explanation& found) const;
  /// The model with more effects.
  Model with(const std::vector<EffectPtr>& more) const;
  /// Values and uncertainties of what was found, for the diagnosis. @param found with what comes with it.
  void takeSizes(const Look& look, const Explanation& found, const CalibrationResult& fitted,
                 Diagnosis& out) const;

 private:
  bool holdWhatRanOff(const Look& look, const Explanation& found, const CalibrationResult& full, Start& start,
                      Diagnosis& out) const;
  Session withScatter(const Look& look) const;
  CalibrationResult fit(const Look& look, const CalibrationResult& fitted,
                        const std::vector<EffectPtr>& effects, const Eigen::VectorXd& start) const;

  const Session& session_;
  const Model& model_;
  const CalibrateOptions& options_;
};

}  // namespace mm
