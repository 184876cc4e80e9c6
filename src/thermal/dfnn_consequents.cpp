#include "thermal/dfnn_consequents.h"

#include <algorithm>
#include <cmath>

#include "base/dense.h"

namespace mm {
namespace {

/// Centres, then logarithms of widths.
Eigen::VectorXd packed(const DfnnRules& rules) {
  Eigen::VectorXd p(rules.centres.size() + rules.count());
  p << Eigen::Map<const Eigen::VectorXd>(rules.centres.data(), rules.centres.size()),
      rules.widths.array().log().matrix();
  return p;
}

DfnnRules unpacked(const Eigen::VectorXd& p, const DfnnRules& start) {
  DfnnRules rules = start;
  rules.centres = Eigen::Map<const Eigen::MatrixXd>(p.data(), start.centres.rows(), start.centres.cols());
  rules.widths =
      p.tail(start.count()).array().exp().max(start.widths.array() * 0.1).min(start.widths.array() * 10.0);
  return rules;
}

/// Residuals of the samples and of the penalties, all outputs one below the other.
Eigen::VectorXd residuals(const Eigen::MatrixXd& x, const Eigen::MatrixXd& y, const DfnnRules& rules,
                          double ridge, double departureRidge) {
  const Eigen::MatrixXd z = RidgeConsequents::design(x, rules);
  const Eigen::MatrixXd w = RidgeConsequents(z, y, x.cols()).solve(ridge, departureRidge);
  const Eigen::Index departures = z.cols() - 1 - x.cols();
  Eigen::MatrixXd all(z.rows() + departures, y.cols());
  all << y - z * w, std::sqrt(departureRidge * static_cast<double>(z.rows())) * w.bottomRows(departures);
  return Eigen::Map<const Eigen::VectorXd>(all.data(), all.size());
}

}  // namespace

Eigen::MatrixXd RidgeConsequents::design(const Eigen::MatrixXd& x, const DfnnRules& rules) {
  const Eigen::Index r = x.cols();
  const Eigen::Index departures = rules.count() > 1 ? rules.count() * (r + 1) : 0;
  Eigen::MatrixXd z(x.rows(), 1 + r + departures);
  z.col(0).setOnes();
  z.middleCols(1, r) = x;
  if (departures > 0) z.rightCols(departures) = rules.design(rules.limited(x));
  return z;
}

RidgeConsequents::RidgeConsequents(const Eigen::MatrixXd& z, const Eigen::MatrixXd& y, Eigen::Index inputs)
    : gram_(z.transpose() * z),
      right_(z.transpose() * y),
      samples_(static_cast<double>(z.rows())),
      line_(1 + inputs) {}

std::vector<Eigen::MatrixXd> RidgeConsequents::solve(const std::vector<double>& ridges,
                                                     double departureRidge) const {
  constexpr double kLeast = 1e-13;  // keeps inputs that do not vary, and rules that never fire, regular
  const Eigen::Index departures = gram_.rows() - line_;
  Eigen::MatrixXd own = gram_.bottomRightCorner(departures, departures);
  own.diagonal().array() += std::max(departureRidge, kLeast) * samples_;
  Eigen::MatrixXd sides(departures, right_.cols() + line_);
  sides << right_.bottomRows(departures), gram_.bottomLeftCorner(departures, line_);
  const Eigen::MatrixXd solved = solveSymmetric(own, sides);
  std::vector<Eigen::MatrixXd> solutions;
  for (double ridge : ridges) {
    Eigen::MatrixXd matrix = gram_.topLeftCorner(line_, line_);
    matrix.diagonal().tail(line_ - 1).array() += std::max(ridge, kLeast) * samples_;
    Eigen::MatrixXd w(gram_.rows(), right_.cols());
    w.topRows(line_) = solveSymmetric(matrix, right_.topRows(line_));
    if (departures > 0)
      w.bottomRows(departures) = solved.leftCols(right_.cols()) - solved.rightCols(line_) * w.topRows(line_);
    solutions.push_back(std::move(w));
  }
  return solutions;
}

DfnnRules refineRules(const Eigen::MatrixXd& x, const Eigen::MatrixXd& y, const DfnnRules& start,
                      double ridge, double departureRidge, int iterations) {
  if (start.count() < 2) return start;
  Eigen::VectorXd p = packed(start);
  const auto at = [&](const Eigen::VectorXd& q) {
    return residuals(x, y, unpacked(q, start), ridge, departureRidge);
  };
  Eigen::VectorXd r = at(p);
  constexpr double kUnseen = 1e-9, kZero = 1e-300;  // a width that no sample feels stays where it is
  constexpr double kLeastDamping = 1e-9;            // Gauss-Newton
  constexpr double kWorthwhile = 1e-4;  // of the squared error: a step that gains less is the last
  double damping = 1e-2;
  for (int i = 0; i < iterations; ++i) {
    Eigen::MatrixXd jacobian(r.size(), p.size());
    constexpr double kStep = 1e-5;
    for (Eigen::Index c = 0; c < p.size(); ++c) {
      Eigen::VectorXd moved = p;
      moved(c) += kStep;
      jacobian.col(c) = (at(moved) - r) / kStep;
    }
    const Eigen::MatrixXd normal = jacobian.transpose() * jacobian;
    const Eigen::VectorXd gradient = jacobian.transpose() * r;
    bool better = false;
    double gain = 0.0;
    for (int tries = 0; tries < 8 && !better; ++tries) {
      Eigen::MatrixXd matrix = normal;
      matrix.diagonal().array() += damping * (normal.diagonal().array() + kUnseen * normal.trace() + kZero);
      const Eigen::VectorXd q = p - solveSymmetric(matrix, gradient);
      if (q.allFinite()) {
        const Eigen::VectorXd s = at(q);
        if (s.squaredNorm() < r.squaredNorm()) {
          gain = 1.0 - s.squaredNorm() / r.squaredNorm();
          p = q;
          r = s;
          better = true;
        }
      }
      damping = better ? std::max(kLeastDamping, damping * 0.3) : damping * 4.0;
    }
    if (!better || gain < kWorthwhile) break;
  }
  return unpacked(p, start);
}

}  // namespace mm
