#pragma once
#include "base/units.h"
#include "estimation/calibrate.h"

namespace mm {

/// The noise of the rows: declared, from repeated contacts, or estimated from the residuals.
struct Noise {
  double linear = kMicrometre, angular = kArcsecond;  // m, rad
  bool linearStated = false, angularStated = false;
  std::string from = "estimated";
};

/// Whether the problem has residuals of a kind: in rad, or in m.
bool has(const Problem& problem, bool angular);

/// RMS over the used rows of one kind; NaN without any. @param count rows used. @param onlyUnstated leaves
/// out rows whose noise was stated with the data.
double rmsOf(const Problem& problem, const Eigen::VectorXd& r, const Eigen::VectorXd& weight, bool angular,
             int* count = nullptr, bool onlyUnstated = false);

/// 1 for each data row that the model can be evaluated at, else 0.
Eigen::VectorXd usableWeight(const Problem& problem);

/// What residuals are multiplied by: sqrt(weight) / sigma.
Eigen::VectorXd inverseOf(const Eigen::VectorXd& sigma, const Eigen::VectorXd& weight);

int freeCount(const std::vector<char>& fixed);  ///< number of zeros in it

/// What is fitted, and how.
struct FitTask {
  const Problem& problem;
  const std::vector<char>& fixed;  // an unknown: held at its start
  const CalibrateOptions& options;
};

/// A fit as it passes through its stages: values, what they leave, and what each row counts for.
struct Fit {
  Noise noise;
  Eigen::VectorXd x;          // of all unknowns, SI
  Eigen::VectorXd residuals;  // of the data rows at x, m or rad
  Eigen::VectorXd weight;     // a data row; 0: not used
  Eigen::VectorXd sigma;      // a data row, m or rad, by `noise`
  int iterations = 0;
  bool converged = false, cancelled = false;
  std::string stop;
};

/// Before the first stage: values and noise to begin with, every usable row counts.
Fit fitFrom(const FitTask& task, Eigen::VectorXd start, Noise noise);

/// Stage "refine": Levenberg-Marquardt from fit.x with the weights and the noise as they are.
Fit refined(const FitTask& task, Fit fit);
/// Stage "soften": refines with Huber's weights where residuals stand far out of the bulk, so that gross
/// outliers do not bend the fit that is to unmask them.
Fit softened(const FitTask& task, Fit fit);
/// Stage "noise": rows of two kinds without a stated noise are weighed by their own residuals.
/// @param moved set to whether a noise changed.
Noise estimatedNoise(const FitTask& task, const Fit& fit, bool* moved);
/// Stage "outliers": weight of each data row, 0 for those that stand apart.
Eigen::VectorXd weightsWithoutOutliers(const FitTask& task, const Fit& fit);

/// The stages in turn until neither noise nor outliers change; then what only seemed to stand apart comes
/// back. Without a search for outliers (options) all usable rows count.
Fit fitted(const FitTask& task, Fit fit);

}  // namespace mm
