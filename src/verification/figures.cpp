#include "verification/figures.h"

#include <algorithm>
#include <cmath>

namespace mm {
namespace {

constexpr int kExact = 800;  // rows up to which the noise's covariance is written out
constexpr int kProbes = 64;  // else its trace comes from so many random vectors (Hutchinson 1990)

/// The rows of one kind, in m or rad.
class Rows {
 public:
  explicit Rows(const FreshPoints& points) {
    const bool angular = points.angular();
    sigma_ = Eigen::VectorXd::Zero(points.rows());
    for (int i = 0; i < points.rows(); ++i) {
      if (points.row(i).angular != angular) continue;
      sigma_[i] = points.fitted().sigma[points.space().used()[i]];
      ++count_;
    }
  }

  int count() const { return count_; }
  /// Of whitened rows (their priors left away), in m or rad; rows of the other kind are 0.
  Eigen::MatrixXd sized(const Eigen::MatrixXd& whitened) const {
    return sigma_.asDiagonal() * whitened.topRows(sigma_.size());
  }
  /// Covariance of the noise times m, in m^2 or rad^2.
  Eigen::MatrixXd noiseTimes(const PointSystem& system, const Eigen::MatrixXd& m) const {
    return sigma_.asDiagonal() * system.covarianceTimes(sigma_.asDiagonal() * m);
  }
  /// Traces of the covariance and of its square.
  void traces(const PointSystem& system, double& trace, double& ofSquare) const {
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
    const Eigen::MatrixXd times = noiseTimes(system, probes);
    trace = share * probes.cwiseProduct(times).sum();
    ofSquare = share * times.squaredNorm();
  }

 private:
  Eigen::VectorXd sigma_;
  int count_ = 0;
};

}  // namespace

ComparedFigures beforeAndAfter(const FreshPoints& points, const PointSystem& system,
                               const LoadedHow& hypothesis, bool loaded) {
  const Rows rows(points);
  const double n = rows.count();
  const Eigen::VectorXd raw = rows.sized(points.raw());
  double trace = 0.0, ofSquare = 0.0;
  rows.traces(system, trace, ofSquare);
  // variance of the sum of squares of a signal under noise
  const auto variance = [&](const Eigen::VectorXd& signal) {
    return 2.0 * ofSquare + 4.0 * signal.dot(rows.noiseTimes(system, signal).col(0));
  };
  const auto figure = [&](const Eigen::VectorXd& measured) {
    const double square = measured.squaredNorm();
    // the signal in what was measured with noise
    const double share = square > 0.0 ? std::sqrt(std::max(0.0, 1.0 - trace / square)) : 1.0;
    Figure f;
    f.rms = std::sqrt(square / n);
    f.std = f.rms > 0.0 ? std::sqrt(variance(share * measured)) / (2.0 * n * f.rms) : 0.0;
    return f;
  };
  ComparedFigures found;
  found.angular = points.angular();
  found.residuals = rows.count();
  found.noise = std::sqrt(trace / n);
  found.freedoms = std::max(1.0, n - points.space().baseRank());
  if (ofSquare > 0.0) found.freedoms *= std::min(1.0, trace * trace / ofSquare / n);
  found.unforeseen = std::sqrt(rows.sized(points.raw() - hypothesis.field).squaredNorm() / n);
  // What the correction takes away, there where it is: the noise of both sides is the same.
  const Eigen::VectorXd taken = rows.sized(loaded ? points.whole() - hypothesis.field : points.whole());
  const Eigen::VectorXd before = loaded ? raw + taken : raw, after = loaded ? raw : raw - taken;
  found.before = figure(loaded ? before : Eigen::VectorXd(raw + rows.sized(points.measuring())));
  found.after = figure(after);
  const double ofDifference = 4.0 * taken.dot(rows.noiseTimes(system, taken).col(0));
  constexpr double kRounding = 1e-9;  // of what was measured
  if (ofDifference > 0.0 && taken.norm() > kRounding * raw.norm())
    found.improvement = (before.squaredNorm() - after.squaredNorm()) / std::sqrt(ofDifference);
  return found;
}

Eigen::VectorXd rmsOf(const FreshPoints& points, const Eigen::MatrixXd& whitened) {
  const Rows rows(points);
  return rows.sized(whitened).colwise().norm().transpose() / std::sqrt(std::max<double>(1.0, rows.count()));
}

}  // namespace mm
