#include "thermal/mutual_information.h"

#include <algorithm>
#include <boost/math/constants/constants.hpp>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <string>

#include "base/dense.h"
#include "base/error.h"
#include "base/unit_random.h"

namespace mm {
namespace {

/// Standardised copy; a column that does not vary becomes 0.
Eigen::VectorXd standardised(const Eigen::VectorXd& v) {
  const Eigen::VectorXd centred = v.array() - v.mean();
  const double deviation = std::sqrt(centred.squaredNorm() / static_cast<double>(v.size()));
  return deviation > 0.0 ? Eigen::VectorXd(centred / deviation)
                         : Eigen::VectorXd(Eigen::VectorXd::Zero(v.size()));
}

std::vector<int> binned(const Eigen::VectorXd& v, double low, double high, int bins) {
  std::vector<int> result(static_cast<std::size_t>(v.size()), 0);
  if (high > low)
    for (Eigen::Index i = 0; i < v.size(); ++i)
      result[static_cast<std::size_t>(i)] =
          std::clamp(static_cast<int>((v(i) - low) / (high - low) * bins), 0, bins - 1);
  return result;
}

/// Sum over cells of count * log(count), and how many cells are occupied. Sorts its argument.
std::pair<double, int> cellSum(std::vector<std::uint64_t>& keys) {
  std::sort(keys.begin(), keys.end());
  double sum = 0.0;
  int occupied = 0;
  for (std::size_t begin = 0; begin < keys.size();) {
    std::size_t end = begin;
    while (end < keys.size() && keys[end] == keys[begin]) ++end;
    const double count = static_cast<double>(end - begin);
    sum += count * std::log(count);
    ++occupied;
    begin = end;
  }
  return {sum, occupied};
}

void check(const Eigen::MatrixXd& t, const Eigen::VectorXd& y, const InformationSettings& s) {
  if (t.rows() != y.size())
    throw InputError("sensor information: " + std::to_string(t.rows()) + " samples of temperature and " +
                     std::to_string(y.size()) + " of displacement; the series must have the same length");
  if (!t.allFinite() || !y.allFinite())
    throw InputError(
        "sensor information: a value is not a finite number; fill the gap or leave the sample out");
  const Eigen::Index least = s.estimator == InformationEstimator::kKsg ? s.neighbours + 2 : 3;
  if (y.size() < least)
    throw InputError("sensor information: " + std::to_string(y.size()) + " samples; at least " +
                     std::to_string(least) + " are needed");
  if (s.neighbours < 1 || s.temperatureBins < 2 || s.displacementBins < 2 || s.surrogates < 1)
    throw InputError("sensor information: neighbours and surrogates must be at least 1, bins at least 2");
}

}  // namespace

SensorInformation::SensorInformation(const Eigen::MatrixXd& temperatures, const Eigen::VectorXd& displacement,
                                     const InformationSettings& settings)
    : settings_(settings) {
  check(temperatures, displacement, settings);
  const Eigen::Index n = temperatures.rows();
  temperatures_.resize(n, temperatures.cols());
  for (Eigen::Index s = 0; s < temperatures.cols(); ++s)
    temperatures_.col(s) = standardised(temperatures.col(s));
  displacement_ = standardised(displacement);
  std::mt19937_64 random(settings.seed);

  if (settings.estimator == InformationEstimator::kKsg) {
    constexpr double kJitter = 1e-10;  // of a standard deviation: no two samples tie (Kraskov et al., 2004)
    jittered_ = temperatures_;
    for (Eigen::Index s = 0; s < jittered_.cols(); ++s)
      for (Eigen::Index i = 0; i < n; ++i) jittered_(i, s) += kJitter * (unitRandom(random) - 0.5);
    Eigen::VectorXd y = displacement_;
    for (Eigen::Index i = 0; i < n; ++i) y(i) += kJitter * (unitRandom(random) - 0.5);
    displacementDistance_.resize(n, n);
    for (Eigen::Index i = 0; i < n; ++i) displacementDistance_.col(i) = (y.array() - y(i)).abs();
    digamma_.resize(n + 1);
    digamma_(0) = -std::numeric_limits<double>::infinity();
    digamma_(1) = -boost::math::constants::euler<double>();
    for (Eigen::Index i = 2; i <= n; ++i) digamma_(i) = digamma_(i - 1) + 1.0 / static_cast<double>(i - 1);
  }

  if (settings.estimator == InformationEstimator::kHistogram) {
    bins_.resize(n, temperatures.cols());
    for (Eigen::Index s = 0; s < temperatures.cols(); ++s) {
      const Eigen::VectorXd t = temperatures.col(s);
      const double low = settings.commonRange ? temperatures.minCoeff() : t.minCoeff();
      const double high = settings.commonRange ? temperatures.maxCoeff() : t.maxCoeff();
      const std::vector<int> bins = binned(t, low, high, settings.temperatureBins);
      bins_.col(s) = Eigen::Map<const Eigen::VectorXi>(bins.data(), n);
    }
    displacementBins_.push_back(
        binned(displacement, displacement.minCoeff(), displacement.maxCoeff(), settings.displacementBins));
    const bool shuffle = settings.correction == BiasCorrection::kShuffle;
    const bool shift = settings.correction == BiasCorrection::kCircularShift;
    for (int k = 0; k < settings.surrogates && (shuffle || shift); ++k) {
      std::vector<int> y = displacementBins_.front();
      if (shuffle)
        for (std::size_t i = y.size() - 1; i > 0; --i)
          std::swap(y[i], y[static_cast<std::size_t>(unitRandom(random) * static_cast<double>(i + 1))]);
      else  // by at least a tenth of the series: a small shift of a slow series is the series itself
        std::rotate(y.begin(),
                    y.begin() + static_cast<long>((0.1 + 0.8 * unitRandom(random)) * static_cast<double>(n)),
                    y.end());
      displacementBins_.push_back(std::move(y));
    }
  }
}

double SensorInformation::joint(const std::vector<int>& sensors) const {
  if (sensors.empty()) return 0.0;
  switch (settings_.estimator) {
    case InformationEstimator::kKsg:
      return ksg(sensors);
    case InformationEstimator::kHistogram:
      return histogram(sensors);
    case InformationEstimator::kCorrelation:
      return gaussian(sensors);
  }
  return 0.0;
}

double SensorInformation::correlation(int sensor) const {
  return std::abs(temperatures_.col(sensor).dot(displacement_)) / static_cast<double>(samples());
}

double SensorInformation::ksg(const std::vector<int>& sensors) const {
  const Eigen::Index n = temperatures_.rows();
  const int k = settings_.neighbours;
  thread_local Eigen::ArrayXd distance, both;
  thread_local std::vector<double> nearest;
  distance.resize(n);
  both.resize(n);
  double sum = 0.0;
  for (Eigen::Index i = 0; i < n; ++i) {
    distance = (jittered_.col(sensors[0]).array() - jittered_(i, sensors[0])).abs();
    for (std::size_t s = 1; s < sensors.size(); ++s)
      distance = distance.max((jittered_.col(sensors[s]).array() - jittered_(i, sensors[s])).abs());
    const auto y = displacementDistance_.col(i).array();
    both = distance.max(y);
    both(i) = std::numeric_limits<double>::infinity();
    nearest.assign(static_cast<std::size_t>(k), std::numeric_limits<double>::infinity());
    for (Eigen::Index j = 0; j < n; ++j) {
      const double d = both(j);
      if (d >= nearest.back()) continue;
      auto place = nearest.end() - 1;
      for (; place != nearest.begin() && *(place - 1) > d; --place) *place = *(place - 1);
      *place = d;
    }
    const double radius = nearest.back();
    // Counts strictly within the radius include sample i itself, which is the "+ 1" of eq. (8).
    sum += digamma_((distance < radius).count()) + digamma_((y < radius).count());
  }
  return digamma_(k) + digamma_(n) - sum / static_cast<double>(n);
}

double SensorInformation::histogram(const std::vector<int>& sensors) const {
  const std::size_t n = displacementBins_.front().size();
  thread_local std::vector<std::uint64_t> cell, keys;
  cell.assign(n, 0);
  for (int s : sensors)  // wraps beyond 64 bits into an odd multiplier's hash: cells stay apart
    for (std::size_t i = 0; i < n; ++i)
      cell[i] = (cell[i] + static_cast<std::uint64_t>(bins_(static_cast<Eigen::Index>(i), s)) + 1) *
                0x9E3779B97F4A7C15u;
  keys = cell;
  const auto [sumT, cellsT] = cellSum(keys);
  const double count = static_cast<double>(n);
  std::vector<double> information;
  int cellsY = 0, cellsBoth = 0;
  for (const std::vector<int>& y : displacementBins_) {
    keys.assign(y.begin(), y.end());
    const auto [sumY, occupiedY] = cellSum(keys);
    for (std::size_t i = 0; i < n; ++i)
      keys[i] = (cell[i] + static_cast<std::uint64_t>(y[i]) + 1) * 0x9E3779B97F4A7C15u;
    const auto [sumBoth, occupiedBoth] = cellSum(keys);
    // (1), (2) with p = count / n: sum p log(p / p_T p_Y) = log n + (S_both - S_T - S_Y) / n.
    information.push_back(std::log(count) + (sumBoth - sumT - sumY) / count);
    if (information.size() == 1) cellsY = occupiedY, cellsBoth = occupiedBoth;
  }
  if (settings_.correction == BiasCorrection::kMillerMadow)
    return information[0] + (cellsT + cellsY - cellsBoth - 1) / (2.0 * count);
  if (information.size() == 1) return information[0];
  return information[0] - std::accumulate(information.begin() + 1, information.end(), 0.0) /
                              static_cast<double>(information.size() - 1);
}

double SensorInformation::gaussian(const std::vector<int>& sensors) const {
  const auto m = static_cast<Eigen::Index>(sensors.size());
  const Eigen::MatrixXd t = temperatures_(Eigen::all, sensors);
  const double n = static_cast<double>(temperatures_.rows());
  const Eigen::VectorXd covariance = t.transpose() * displacement_ / n;
  constexpr double kAlike = 1e-12;      // of a variance of one: sensors that read the same
  constexpr double kLeastLeft = 1e-15;  // of a variance of one: a course that is explained to the last bit
  const Eigen::MatrixXd matrix = t.transpose() * t / n + kAlike * Eigen::MatrixXd::Identity(m, m);
  const double explained = covariance.dot(solveSymmetric(matrix, covariance));
  return -0.5 * std::log(std::max(1.0 - explained, kLeastLeft));
}

}  // namespace mm
