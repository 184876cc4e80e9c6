#include "uncertainty/found_remainder.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "estimation/drift.h"
#include "estimation/linearisation.h"
#include "estimation/noise_rows.h"

namespace mm {
namespace {

constexpr std::size_t kFewestRows = 12, kMostRows = 1200;
constexpr double kNear = 2.0;  // lengths: pairs farther apart tell the fit's own balance

/// Least squares of a normal equation of three unknowns that are not negative: the best of all subsets.
Eigen::Vector3d notNegative(const Eigen::Matrix3d& a, const Eigen::Vector3d& b) {
  Eigen::Vector3d best = Eigen::Vector3d::Zero();
  double least = 0.0;
  for (int subset = 1; subset < 8; ++subset) {
    Eigen::Matrix3d part = Eigen::Matrix3d::Identity();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (int i = 0; i < 3; ++i) {
      if ((subset >> i & 1) == 0) continue;
      right[i] = b[i];
      for (int j = 0; j < 3; ++j)
        if ((subset >> j & 1) != 0) part(i, j) = a(i, j);
    }
    const Eigen::FullPivLU<Eigen::Matrix3d> lu(part);
    if (!lu.isInvertible()) continue;
    const Eigen::Vector3d x = lu.solve(right);
    if (x.minCoeff() < 0.0) continue;
    const double value = x.dot(a * x) - 2.0 * b.dot(x);
    if (value < least) {
      least = value;
      best = x;
    }
  }
  return best;
}

/// The rows that are asked: in m, in use, at known places.
class ProbedRows {
 public:
  ProbedRows(const CalibrationResult& result, const Linearisation& at) : result_(result) {
    const Problem& problem = *result.problem;
    const Eigen::VectorXd& left =
        result.heldOut.size() == result.residuals.size() ? result.heldOut : result.residuals;
    std::vector<int> rows;
    for (int i = 0; i < problem.rowCount(); ++i) {
      const ResidualRow& row = problem.rows()[i];
      if (!row.angular && result.weight[i] > 0.0 && std::isfinite(left[i]) &&
          problem.state(row.observation).tip.allFinite())
        rows.push_back(i);
    }
    const std::size_t step = 1 + rows.size() / kMostRows;
    for (std::size_t i = 0; i < rows.size(); i += step) used_.push_back(rows[i]);
    if (used_.size() < kFewestRows) return;
    const Eigen::Index n = used_.size();
    const ErrorLayout layout = problem.model().machine().layout();
    residual_.resize(n);
    cosines_.resize(n, 3);
    const Directions directions = directionsOf(at, used_);
    for (Eigen::Index i = 0; i < n; ++i) {
      const int row = used_[i];
      const int observation = problem.rows()[row].observation;
      residual_[i] = left[row];
      for (int k = 0; k < 3; ++k) cosines_(i, k) = at.slotGradients()(row, layout.volume(k));
      place_.push_back(problem.state(observation).tip);
      time_.push_back(problem.session().observations[observation].time);
    }
    for (const Drift& d : result.drift) {
      const auto found = std::find(directions.names.begin(), directions.names.end(), d.direction);
      if (found != directions.names.end())
        drifts_.push_back(
            {d.std * directions.factors.col(found - directions.names.begin()), d.timeConstant, d.smooth});
    }
  }

  Eigen::Index count() const { return residual_.size(); }
  double distance(Eigen::Index i, Eigen::Index j) const { return (place_[i] - place_[j]).norm(); }
  Eigen::Vector3d cosines(Eigen::Index i, Eigen::Index j) const {
    return cosines_.row(i).cwiseProduct(cosines_.row(j)).transpose();
  }
  /// The product of two residuals, less what drift and (of one with itself) noise are expected to add.
  double product(Eigen::Index i, Eigen::Index j) const {
    double value = residual_[i] * residual_[j];
    const double apart = std::abs(time_[i] - time_[j]);
    for (const Memory& m : drifts_)
      value -= m.factors[i] * m.factors[j] * (i == j ? 1.0 : correlationOf(m.smooth, m.tau, apart));
    if (i == j) value -= std::pow(result_.sigma[used_[i]], 2);
    return value;
  }

 private:
  struct Memory {
    Eigen::VectorXd factors;
    double tau = 0.0;
    bool smooth = false;
  };
  const CalibrationResult& result_;
  std::vector<int> used_;
  Eigen::VectorXd residual_;
  Eigen::MatrixX3d cosines_;
  std::vector<Eigen::Vector3d> place_;
  std::vector<double> time_;
  std::vector<Memory> drifts_;
};

}  // namespace

std::optional<Remainder> remainderOf(const CalibrationResult& result, double length) {
  const Linearisation at = linearise(*result.problem, result.x);
  const ProbedRows rows(result, at);
  const Eigen::Index n = rows.count();
  if (n == 0 || !(length > 0.0)) return std::nullopt;
  Eigen::Matrix3d smooth = Eigen::Matrix3d::Zero(), rough = smooth;
  Eigen::Vector3d ofSmooth = Eigen::Vector3d::Zero(), ofRough = ofSmooth;
  double squares = n;
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < i; ++j) {
      const double d = rows.distance(i, j) / length, rho = std::exp(-0.5 * d * d);
      squares += 2.0 * rho * rho;
      if (d > kNear) continue;
      const Eigen::Vector3d design = rho * rows.cosines(i, j);
      smooth += design * design.transpose();
      ofSmooth += rows.product(i, j) * design;
    }
  const Eigen::Vector3d variance = notNegative(smooth, ofSmooth);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::Vector3d design = rows.cosines(i, i);
    rough += design * design.transpose();
    ofRough += (rows.product(i, i) - variance.dot(design)) * design;
  }
  const double pairs = static_cast<double>(n) * n;
  return Remainder{variance.cwiseSqrt(), notNegative(rough, ofRough).cwiseSqrt(), length, pairs / squares};
}

}  // namespace mm
