#include "export/hat_functions.h"

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <random>

#include "base/grid_values.h"
#include "base/unit_random.h"

namespace mm {
namespace {

Eigen::SparseMatrix<double> hats(const std::vector<double>& points, const std::vector<double>& at) {
  std::vector<Eigen::Triplet<double>> weights;
  for (std::size_t n = 0; n < at.size(); ++n) {
    const auto [i, share] = placeAmong(points, at[n]);
    weights.emplace_back(n, i, 1.0 - share);
    weights.emplace_back(n, i + 1, share);
  }
  Eigen::SparseMatrix<double> matrix(at.size(), points.size());
  matrix.setFromTriplets(weights.begin(), weights.end());
  return matrix;
}

constexpr double kHardlyLess = 0.98;
constexpr unsigned kPlacesSeed = 71;

/// Every second row, from the one of that number.
std::pair<std::vector<double>, Eigen::MatrixXd> everySecond(const std::vector<double>& at,
                                                            const Eigen::MatrixXd& samples,
                                                            std::size_t first) {
  std::vector<double> some;
  for (std::size_t n = first; n < at.size(); n += 2) some.push_back(at[n]);
  Eigen::MatrixXd rows(some.size(), samples.cols());
  for (Eigen::Index n = 0; n < rows.rows(); ++n) rows.row(n) = samples.row(2 * n + first);
  return {some, rows};
}

}  // namespace

std::vector<double> samplesWithin(const std::vector<double>& points, int aStep) {
  // Not by a rule such as the golden section: a period may agree with that, too, and pass for a slow curve.
  std::mt19937_64 random(kPlacesSeed);
  const std::size_t count = (points.size() - 1) * aStep;
  const double part = (points.back() - points.front()) / count;
  std::vector<double> at;
  for (std::size_t k = 0; k < count; ++k) at.push_back(points.front() + (k + unitRandom(random)) * part);
  return at;
}

Eigen::MatrixXd hatFit(const std::vector<double>& points, const std::vector<double>& at,
                       const Eigen::MatrixXd& samples) {
  const Eigen::SparseMatrix<double> matrix = hats(points, at);
  const Eigen::SparseMatrix<double> normal = matrix.transpose() * matrix;
  return Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>(normal).solve(matrix.transpose() * samples);
}

Eigen::MatrixXd hatHeldOut(const std::vector<double>& points, const std::vector<double>& at,
                           const Eigen::MatrixXd& samples) {
  const auto [fitted, values] = everySecond(at, samples, 0);
  const auto [held, others] = everySecond(at, samples, 1);
  return hatRemainder(points, hatFit(points, fitted, values), held, others);
}

Eigen::MatrixXd hatOrLineFit(const std::vector<double>& points, const std::vector<double>& at,
                             const Eigen::MatrixXd& samples) {
  const std::vector<double> ends{points.front(), points.back()};
  const Eigen::MatrixXd line = hatFit(ends, at, samples);
  const Eigen::MatrixXd fitLeaves = hatHeldOut(points, at, samples),
                        lineLeaves = hatHeldOut(ends, at, samples);
  Eigen::MatrixXd values = hatFit(points, at, samples);
  for (Eigen::Index c = 0; c < samples.cols(); ++c)
    if (!(fitLeaves.col(c).norm() < kHardlyLess * lineLeaves.col(c).norm()))
      for (Eigen::Index i = 0; i < values.rows(); ++i) {
        const double share = placeAmong(ends, points[i]).second;
        values(i, c) = (1.0 - share) * line(0, c) + share * line(1, c);
      }
  return values;
}

Eigen::MatrixXd hatRemainder(const std::vector<double>& points, const Eigen::MatrixXd& values,
                             const std::vector<double>& at, const Eigen::MatrixXd& samples) {
  return samples - hats(points, at) * values;
}

}  // namespace mm
