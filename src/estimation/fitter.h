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

/// One fit and everything that belongs to it: polish, outliers, noise of each kind of row.
class Fitter {
 public:
  Fitter(const Problem& problem, const CalibrateOptions& options, Noise noise);

  /// Fits, looks for outliers and weighs the kinds of rows, until neither changes.
  void run(Eigen::VectorXd start, const std::vector<char>& fixed);
  /// Without a search for outliers: the weights stay as they are.
  void fitOnce(Eigen::VectorXd start, const std::vector<char>& fixed);

 private:
  void fit(const std::vector<char>& fixed);
  void soften(const std::vector<char>& fixed);
  bool estimateNoise(const std::vector<char>& fixed);

  const Problem& problem_;
  const CalibrateOptions& options_;

 public:
  Noise noise;
  Eigen::VectorXd x, residuals, weight, sigma;
  int iterations = 0;
  bool converged = false, cancelled = false;
  std::string stop;
};

}  // namespace mm
