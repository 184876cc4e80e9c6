#pragma once
#include <memory>
#include <optional>
#include <vector>

#include "estimation/fitter.h"
#include "estimation/network_learning.h"

namespace mm {

// The stages of a calibration, in the order in which `calibrate` runs them: each takes values and returns
// values, and none changes what another has returned.

/// What is fitted to what, before the first step.
struct Statement {
  std::shared_ptr<const Problem> problem;
  Noise noise;                      // to begin with
  Eigen::VectorXd sigma, weight;    // a data row: m or rad; 1, or 0 where the model has no value
  Eigen::VectorXd x;                // all unknowns, SI: the caller's values, or the model's own
  Identifiability identifiability;  // the gauge, and what the session does not determine
};

/// Values from which a descent finds the optimum.
struct StartValues {
  Eigen::VectorXd x;
  std::optional<GeneticSummary> genetic;
  bool cancelled = false;
};

/// What the values are worth.
struct Uncertainty {
  Eigen::VectorXd heldOut;                  // a data row, m or rad
  Eigen::MatrixXd covariance;               // SI, of all unknowns
  std::vector<Drift> drift;                 // what it allows for beside white noise
  double centresStd = 0.0, radiiStd = 0.0;  // m: and how the balls scatter about their file
  double dof = 0.0;                         // degrees of freedom
  double priorChi2 = 0.0;                   // sum of squares of the rows that are no data

  /// Degrees of freedom that other unknowns take; at least one stays. The covariance grows with it.
  void takeFreedoms(int taken);
};

/// "networks": the model with what its networks learned; as it is where none has to learn.
LearnedModel withNetworks(const Session& session, Model model, const CalibrateOptions& options,
                          const Eigen::VectorXd& given);

/// "statement": rows, unknowns, noise, and which unknowns are held.
/// @throw InputError as Problem. @throw NumericalError: fewer residuals than unknowns.
Statement stated(const Session& session, const LearnedModel& learned, const CalibrateOptions& options,
                 Datum datum);

/// "start": direction of a beam, nonlinear parameters, genetic algorithm; of what these found the best.
/// @param given whether the caller chose the values of the effects.
StartValues startValues(const Statement& statement, const CalibrateOptions& options, bool given);

/// "refine", "outliers", "noise": see fitter.h.
Fit fitted(const Statement& statement, const StartValues& start, const CalibrateOptions& options);

/// After the fit: nonlinear parameters may turn out not to be determined.
Identifiability lostAtTheFit(const Statement& statement, const Fit& fit);

/// "uncertainty": covariance under the noise that is found, memory included, and held-out residuals.
/// @param whiteNoise as if no row knew of its neighbours.
Uncertainty uncertaintyOf(const Problem& problem, const Fit& fit, const std::vector<char>& fixed,
                          bool whiteNoise);

/// Held-out residuals are those of networks that were learned without the rows that they are judged on.
/// @param shift of LearnedModel.
void addNetworkShift(const Problem& problem, const Eigen::VectorXd& x, const Eigen::MatrixXd& shift,
                     Eigen::VectorXd& heldOut);

/// Constants of the networks, which take degrees of freedom too: they are learned from the same residuals.
int networkUnknowns(const Model& model);

/// "repeatability": as declared, from repeats, or from what the fit leaves. The noise follows it.
struct RepeatabilityUsed {
  double value = 0.0;      // m (rad for angular sessions)
  std::string from;        // "declared", "repeated" or "estimated"
  Repeatability repeated;  // where it comes from repeats
  Noise noise;
};
RepeatabilityUsed repeatabilityOf(const Problem& problem, const Fit& fit,
                                  double dof);  ///< m or rad, and whence

/// "figures": RMS, held-out RMS and chi2 of a fit, at the noise of its rows `sigma` (m or rad).
ResidualFigures figuresOf(const Problem& problem, const Fit& fit, const Uncertainty& uncertainty,
                          const Eigen::VectorXd& sigma);

/// "before": the figures of the machine without effects, on the same rows with the same noise.
ResidualFigures nominalFigures(const Session& session, const Model& model, const CalibrateOptions& options,
                               const Fit& fit);

}  // namespace mm
