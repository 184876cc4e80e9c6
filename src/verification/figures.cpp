#include "verification/figures.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace mm {
namespace {

constexpr int kExact = 800;  // rows up to which the noise's covariance is written out
constexpr int kProbes = 64;  // else its trace comes from so many random vectors (Hutchinson 1990)

/// The rows of one kind, in m or rad.
class Rows {
 public:
  Rows(const FreshPoints& points, const PointSystem& system) : system_(system) {
    const Problem& problem = *points.fitted().problem;
    const std::vector<int>& used = points.space().used();
    const auto angular = [&](int row) { return problem.rows()[static_cast<std::size_t>(row)].angular; };
    angular_ = std::all_of(used.begin(), used.end(), angular);
    sigma_ = Eigen::VectorXd::Zero(points.rows());
    for (int i = 0; i < points.rows(); ++i) {
      const int row = used[static_cast<std::size_t>(i)];
      if (angular(row) != angular_) continue;
      sigma_[i] = points.fitted().sigma[row];
      ++count_;
    }
  }

  bool angular() const { return angular_; }
  int count() const { return count_; }
  /// Of whitened rows (their priors left away), in m or rad; rows of the other kind are 0.
  Eigen::MatrixXd sized(const Eigen::MatrixXd& whitened) const {
    return sigma_.asDiagonal() * whitened.topRows(sigma_.size());
  }
  /// Covariance of the noise times m, in m^2 or rad^2.
  Eigen::MatrixXd noiseTimes(const Eigen::MatrixXd& m) const {
    return sigma_.asDiagonal() * system_.covarianceTimes(sigma_.asDiagonal() * m);
  }
  /// Traces of the covariance and of its square.
  void traces(double& trace, double& ofSquare) const {
    const Eigen::Index n = sigma_.size();
    Eigen::MatrixXd probes = Eigen::MatrixXd::Identity(n, n);
    double share = 1.0;
    if (n > kExact) {
      probes.resize(n, kProbes);
      std::uint64_t bits = 0x9E3779B97F4A7C15ULL;
      for (Eigen::Index i = 0; i < probes.size(); ++i) {  // splitmix64
        std::uint64_t z = (bits += 0x9E3779B97F4A7C15ULL);
        z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9ULL;
        z = (z ^ (z >> 27U)) * 0x94D049BB133111EBULL;
        probes.data()[i] = ((z ^ (z >> 31U)) & 1U) != 0 ? 1.0 : -1.0;
      }
      share = 1.0 / kProbes;
    }
    const Eigen::MatrixXd times = noiseTimes(probes);
    trace = share * probes.cwiseProduct(times).sum();
    ofSquare = share * times.squaredNorm();
  }

 private:
  const PointSystem& system_;
  Eigen::VectorXd sigma_;
  bool angular_ = false;
  int count_ = 0;
};

}  // namespace

BeforeAndAfter beforeAndAfter(const FreshPoints& points, const PointSystem& system,
                              const Eigen::MatrixXd& covariance, bool loaded) {
  const Rows rows(points, system);
  const double n = rows.count();
  const Eigen::VectorXd raw = rows.sized(points.raw());
  const Eigen::VectorXd field = rows.sized(points.whole());
  double trace = 0.0, ofSquare = 0.0;
  rows.traces(trace, ofSquare);
  // variance of the sum of squares of a signal under noise
  const auto variance = [&](const Eigen::VectorXd& signal) {
    return 2.0 * ofSquare + 4.0 * signal.dot(rows.noiseTimes(signal).col(0));
  };
  const auto quieter = [&](const Eigen::VectorXd& measured) {  // the signal in what was measured with noise
    const double square = measured.squaredNorm();
    return square > 0.0 ? Eigen::VectorXd(measured * std::sqrt(std::max(0.0, 1.0 - trace / square)))
                        : measured;
  };
  const auto figure = [&](double sum, double itsVariance) {
    Figure f;
    f.rms = std::sqrt(std::max(0.0, sum) / n);
    f.std = f.rms > 0.0 ? std::sqrt(itsVariance) / (2.0 * n * f.rms) : 0.0;
    return f;
  };
  BeforeAndAfter found;
  found.angular = rows.angular();
  found.residuals = rows.count();
  found.noise = std::sqrt(trace / n);
  const double freeShare = std::max(0.0, 1.0 - points.space().baseRank() / std::max(1.0, n));
  if (loaded) {
    const Eigen::VectorXd byParameters = rows.sized(points.byParameter()).transpose() * field;
    const double ofCalibration = 4.0 * byParameters.dot(covariance * byParameters);
    const double expected = field.squaredNorm() + trace * freeShare, measured = raw.squaredNorm();
    const double ofExpected = ofCalibration + variance(field), ofMeasured = variance(quieter(raw));
    found.before = figure(expected, ofExpected);
    found.after = figure(measured, ofMeasured);
    found.improvement = (expected - measured) / std::sqrt(ofCalibration + 2.0 * ofSquare + ofMeasured);
    return found;
  }
  const Eigen::VectorXd left = raw - field;
  const Eigen::VectorXd uncorrected = raw + rows.sized(points.measuring());
  found.before = figure(uncorrected.squaredNorm(), variance(quieter(uncorrected)));
  found.after = figure(left.squaredNorm(), variance(quieter(left)));
  // The noise of both is the same: only its part along the field differs.
  const double ofDifference = 4.0 * field.dot(rows.noiseTimes(field).col(0));
  found.improvement =
      ofDifference > 0.0 ? (raw.squaredNorm() - left.squaredNorm()) / std::sqrt(ofDifference) : 0.0;
  return found;
}

}  // namespace mm
