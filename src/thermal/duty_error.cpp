#include "thermal/duty_error.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <string>

#include "base/dense.h"
#include "base/error.h"
#include "base/unit_random.h"

namespace mm {
namespace {

constexpr int kDuties = 60;
constexpr double kStopped = 0.25;                    // share of the steps of a duty
constexpr double kShortest = 0.04, kLongest = 0.25;  // a step, of the series
constexpr double kWhite = 3.09;                      // normal quantile, 0.1 %

/// Von Neumann's ratio of the mean square successive difference to the variance: 2 for white noise, less the
/// slower a course is.
bool whiteNoise(const Eigen::VectorXd& course) {
  const Eigen::Index n = course.size();
  const double differences = (course.tail(n - 1) - course.head(n - 1)).squaredNorm(),
               squares = (course.array() - course.mean()).square().sum();
  return differences > (2.0 - 2.0 * kWhite / std::sqrt(static_cast<double>(n))) * squares;
}

/// The courses of a machine that ran, from rest, as `courses` (samples x any) tell, on a random duty.
Eigen::MatrixXd onDuty(const Eigen::MatrixXd& courses, std::mt19937_64& random) {
  const Eigen::Index n = courses.rows();
  const Eigen::MatrixXd change = courses.rowwise() - courses.row(0);
  Eigen::MatrixXd result = courses.row(0).replicate(n, 1);
  double power = 0.0;
  for (double begin = 0.0; begin < static_cast<double>(n);) {
    const double next = unitRandom(random) < kStopped ? 0.0 : unitRandom(random);
    const auto at = static_cast<Eigen::Index>(begin);
    result.bottomRows(n - at) += (next - power) * change.topRows(n - at);
    power = next;
    begin +=
        std::max(1.0, (kShortest + (kLongest - kShortest) * unitRandom(random)) * static_cast<double>(n));
  }
  return result;
}

}  // namespace

DutyError::DutyError(const Eigen::MatrixXd& temperatures, const Eigen::VectorXd& displacement,
                     std::uint64_t seed) {
  const Eigen::Index n = temperatures.rows(), sensors = temperatures.cols();
  if (n != displacement.size() || n < 4 || sensors < 1)
    throw InputError("error on other duties: " + std::to_string(n) + " samples of " +
                     std::to_string(sensors) + " temperatures and " + std::to_string(displacement.size()) +
                     " of displacement; as many of both are needed, at least 4");
  const Eigen::MatrixXd t = temperatures.rowwise() - temperatures.colwise().mean();
  const Eigen::VectorXd y = displacement.array() - displacement.mean();
  products_ = t.transpose() * t;
  projections_ = t.transpose() * y;

  // principal components from the smaller of the two matrices of products, the largest last
  const bool wide = sensors > n;
  const SymmetricEigen solver(wide ? Eigen::MatrixXd(t * t.transpose()) : products_);
  const Eigen::Index all = solver.values.size();
  const auto courseOf = [&](Eigen::Index k) {
    const Eigen::VectorXd vector = solver.vectors.col(all - 1 - k);
    return Eigen::VectorXd(wide ? vector : (t * vector).normalized());
  };
  const Eigen::Index most = std::min(sensors, std::max<Eigen::Index>(1, n / 4));
  constexpr double kRounding = 1e-13;  // of the largest eigenvalue
  const double rounding = kRounding * solver.values(all - 1);
  std::vector<Eigen::VectorXd> field, first;
  for (Eigen::Index k = 0; k < all && static_cast<Eigen::Index>(field.size()) < most; ++k) {
    if (!(solver.values(all - 1 - k) > rounding)) break;
    const Eigen::VectorXd course = courseOf(k);
    if (!whiteNoise(course)) field.push_back(course);
    if (static_cast<Eigen::Index>(first.size()) < most) first.push_back(course);
  }
  if (field.empty()) field = first;  // the samples do not follow each other: nothing tells field from noise

  const auto count = static_cast<Eigen::Index>(field.size());
  Eigen::MatrixXd courses(n, count);
  for (Eigen::Index c = 0; c < count; ++c) courses.col(c) = field[static_cast<std::size_t>(c)];
  loadings_ = courses.transpose() * t;
  displacement_ = courses.transpose() * y;
  noise_ = (products_.diagonal() - loadings_.colwise().squaredNorm().transpose()).cwiseMax(0.0) /
           static_cast<double>(std::max<Eigen::Index>(1, n - 1 - count));

  std::mt19937_64 random(seed);
  duties_ = Eigen::MatrixXd::Zero(count, count);
  for (int d = 0; d < kDuties; ++d) {
    const Eigen::MatrixXd other = onDuty(courses, random);
    duties_ += other.transpose() * other / static_cast<double>(kDuties * n);
  }
}

double DutyError::of(const std::vector<int>& sensors) const {
  Eigen::MatrixXd matrix = products_(sensors, sensors);
  constexpr double kAlike = 1e-10;  // of sensors that read the same
  matrix.diagonal() *= 1.0 + kAlike;
  const Eigen::VectorXd slopes = solveSymmetric(matrix, Eigen::VectorXd(projections_(sensors)));
  Eigen::VectorXd left = displacement_;
  double passedOn = 0.0;
  for (std::size_t a = 0; a < sensors.size(); ++a) {
    const double slope = slopes(static_cast<Eigen::Index>(a));
    left -= slope * loadings_.col(sensors[a]);
    passedOn += slope * slope * noise_(sensors[a]);
  }
  return std::sqrt(left.dot(duties_ * left) + passedOn);
}

}  // namespace mm
