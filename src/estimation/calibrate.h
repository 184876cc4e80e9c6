#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "estimation/genetic_niching.h"
#include "estimation/genetic_staged_mutation.h"
#include "estimation/identifiability.h"
#include "estimation/problem.h"
#include "estimation/repeatability.h"

namespace mm {

enum class Method { kStagedMutation, kNiching, kLeastSquares };
/// @throw InputError naming the known methods.
Method methodOf(const std::string& name);
std::string nameOf(Method method);

struct CalibrateOptions {
  Method method = Method::kStagedMutation;
  std::uint64_t seed = 1;
  unsigned threads = 0;       // 0: all cores; the result does not depend on it
  double repeatability = -1;  // m, declared: overrides the artifact's; negative: not stated here
  bool rejectOutliers = true;
  bool whiteNoise = false;  // uncertainties as if no row knew of its neighbours, whatever the residuals show
  Eigen::VectorXd weights;  // a data row, with rejectOutliers false: 0 leaves it out; empty: all count
  bool holdEffects =
      false;  // the effects' parameters stay at `start`; only what belongs to the session is fitted
  StagedMutationSettings stagedMutation;  // seed and threads are those above
  NichingSettings niching;                // likewise
  /// Called with a stage ("networks", "genetic", "refine", "uncertainty") and its share done in 0 … 1.
  std::function<void(const std::string& stage, double share)> progress;
  std::function<bool()> cancelled;
};

struct GeneticSummary {
  std::string method, stop;
  double rms = 0.0;  // m (rad where the session is angular)
  std::size_t generations = 0, evaluations = 0;
  double seconds = 0.0;
  std::uint64_t seed = 0;
  std::vector<double> curve;  // best RMS a generation
};

struct Outlier {
  int row = 0;            // of the data rows
  double residual = 0.0;  // m or rad
};

/// Figures of a set of residuals, over the rows that are not outliers.
struct ResidualFigures {
  double rms = kNotMeasured, heldOutRms = kNotMeasured;                // m; NaN: none in m
  double rmsAngular = kNotMeasured, heldOutRmsAngular = kNotMeasured;  // rad
  double chi2PerDof = 0.0;
  int degreesOfFreedom = 0;
};

/// A drift along one direction that the residuals show beside their white noise.
struct Drift {
  std::string direction;      // a joint, x, y, z of workpiece, or approach
  double std = 0.0;           // m (rad)
  double timeConstant = 0.0;  // s
  bool smooth = false;        // its slope is continuous (Matern 3/2), as of a part that warms and cools
};

/// What a calibration found. Refers to the session given to `calibrate`.
struct CalibrationResult {
  std::shared_ptr<const Problem> problem;
  Eigen::VectorXd x;  // all unknowns, SI
  Eigen::MatrixXd
      covariance;            // SI, of all unknowns; zero rows where fixed; scaled by the residuals' variance
  std::vector<Drift> drift;  // what the covariance allows for beside white noise
  /// And how the balls scatter about the artifact file, where that says nothing of it: standard deviation of
  /// a coordinate of a centre, and of a radius, m; 0: not seen.
  double centresStd = 0.0, radiiStd = 0.0;
  Eigen::VectorXd residuals;      // a data row, m or rad
  Eigen::VectorXd sigma;          // a data row, m or rad: the noise taken for it
  Eigen::VectorXd weight;         // a data row: 0 for outliers
  Eigen::VectorXd heldOut;        // a data row, m or rad: residual under the fit to the other folds
  double repeatability = 0.0;     // m (rad for angular sessions), as used
  std::string repeatabilityFrom;  // "declared", "repeated" or "estimated"
  Repeatability repeated;  // where it comes from repeats: with its degrees of freedom; else its dof is 0
  ResidualFigures figures;
  ResidualFigures before;  // of the nominal machine (no effects), same rows
  Identifiability identifiability;
  std::optional<GeneticSummary> genetic;
  int iterations = 0;
  bool converged = false;
  bool cancelled = false;
  std::string stop;
  std::vector<Outlier> outliers;
  Method method = Method::kLeastSquares;
  std::uint64_t seed = 0;

  double std(int unknown) const;  ///< SI; 0 where it is held
};

/// Calibrates: gauge by convention, genetic algorithm, refinement, outliers, uncertainty: the stages of
/// calibration_stages.h.
/// @param session must outlive the result. @param start values of the effects' parameters to begin with
/// (empty: the effects' own). @throw InputError: the session cannot be used with the model. @throw
/// NumericalError: nothing left to fit (fewer residuals than unknowns).
CalibrationResult calibrate(const Session& session, Model model, const CalibrateOptions& options,
                            const Eigen::VectorXd& start = {});

}  // namespace mm
