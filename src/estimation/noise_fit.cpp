#include "estimation/noise_fit.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>
#include <utility>

#include "base/cancel_scope.h"
#include "base/dense.h"
#include "base/median.h"
#include "base/parallel.h"
#include "base/tiny.h"
#include "estimation/row_products.h"

namespace mm {
namespace {

constexpr int kTimeConstants = 6;
constexpr int kRoughOnly = 3;    // the shortest of them
constexpr double kEnough = 0.3;  // nats: what another round must bring
// Nats that a change must bring to be kept: above the rounding of the evidence, and, where the ratios stay as
// they are meanwhile, above what fitting them again gives and takes.
constexpr double kBetterRatio = 1e-6, kBetterDrift = 1e-3;
constexpr double kRatiosSettled = 0.05;  // nats that a round over all ratios must bring
/// Further terms that are asked with everything beside them, of all that are asked with the blocks where they
/// are: which is best of those that are nearly as good, the blocks decide.
constexpr std::size_t kLikeliest = 4;
constexpr double kShortest = 4.0;  // spacings of the rows: a shorter session has no time constants

RowMatrix some(const RowMatrix& all, const std::vector<int>& taken, int rows) {
  const int priors = static_cast<int>(all.rows()) - rows, n = static_cast<int>(taken.size());
  RowMatrix out(n + priors, all.cols());
  for (int i = 0; i < n; ++i) out.row(i) = all.row(taken[i]);
  out.bottomRows(priors) = all.bottomRows(priors);
  return out;
}

}  // namespace

std::vector<int> stretches(int rows, int most, int length) {
  std::vector<int> taken;
  const int count = most / length;
  for (int s = 0; s < count; ++s) {
    const int first = static_cast<int>(static_cast<long>(s) * (rows - length) / std::max(1, count - 1));
    for (int i = 0; i < length; ++i)
      if (taken.empty() || first + i > taken.back()) taken.push_back(first + i);
  }
  return taken;
}

double medianSpacing(const std::vector<double>& time) {
  std::vector<double> dt;
  for (std::size_t i = 1; i < time.size(); ++i)
    if (time[i] > time[i - 1]) dt.push_back(time[i] - time[i - 1]);
  return dt.empty() ? 0.0 : upperMedian(std::move(dt));
}

struct NoiseFit::Gram {
  RowMatrix products;      // of base, blocks and target
  std::vector<int> first;  // a block: its first column, -1 where it was left out
  double logDeterminant = 0.0;
};

NoiseFit::NoiseFit(const NoiseRows& rows, std::vector<RandomBlock> blocks)
    : rows_(rows), blocks_(std::move(blocks)), base_(static_cast<int>(rows.base.cols())) {
  const double spacing = medianSpacing(rows.time);
  const double length = rows.rows() > 1 ? rows.time.back() - rows.time.front() : 0.0;
  if (spacing > 0.0 && length > kShortest * spacing) {
    // from noise that lasts from one row to the next to a walk that never comes back
    const double first = spacing, last = 2.0 * length;
    for (int k = 0; k < kTimeConstants; ++k)
      timeConstants_.push_back(first * std::pow(last / first, k / (kTimeConstants - 1.0)));
  }
}

NoiseFit::Gram NoiseFit::gramOf(const NoiseModel& noise, const std::vector<double>& ratios,
                                bool everything) const {
  CancelScope::check();
  Gram gram;
  int columns = base_;
  for (std::size_t b = 0; b < blocks_.size(); ++b) {
    const bool there = everything || ratios[b] > 0.0;
    gram.first.push_back(there ? columns : -1);
    if (there) columns += static_cast<int>(blocks_[b].columns.cols());
  }
  RowMatrix m(rows_.length(), columns + 1);
  m.leftCols(base_) = rows_.base;
  for (std::size_t b = 0; b < blocks_.size(); ++b)
    if (gram.first[b] >= 0) m.middleCols(gram.first[b], blocks_[b].columns.cols()) = blocks_[b].columns;
  m.col(columns) = rows_.target;
  const TimeWhitener whitener = whitenerOf(rows_, noise.variance, noise.drift);
  whitener.whiten(m);
  gram.logDeterminant = whitener.logDeterminant();
  gram.products = rowProducts(m);
  return gram;
}

double NoiseFit::value(const Gram& gram, const std::vector<double>& ratios, double* rest) const {
  const int columns = static_cast<int>(gram.products.cols()) - 1;
  std::vector<int> taken;
  std::vector<double> scale;
  for (int k = 0; k < base_; ++k) taken.push_back(k), scale.push_back(1.0);
  for (std::size_t b = 0; b < blocks_.size(); ++b)
    if (ratios[b] > 0.0)
      for (int k = 0; k < blocks_[b].columns.cols(); ++k)
        taken.push_back(gram.first[b] + k), scale.push_back(ratios[b]);
  const int n = static_cast<int>(taken.size());
  Eigen::MatrixXd m(n, n);
  Eigen::VectorXd to(n);
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j <= i; ++j) m(i, j) = scale[i] * scale[j] * gram.products(taken[i], taken[j]);
    m(i, i) += i < base_ ? kRidge : 1.0;
    to[i] = scale[i] * gram.products(columns, taken[i]);
  }
  const Cholesky factor(m);
  const Eigen::VectorXd explained = factor.solveLower(to);
  const double left = std::max(kTiny, gram.products(columns, columns) - explained.squaredNorm());
  if (rest != nullptr) *rest = left;
  const double freedoms = std::max(1, rows_.length() - base_);
  const double logDeterminant = gram.logDeterminant + factor.logDeterminant();
  return -0.5 * logDeterminant - 0.5 * freedoms * std::log(left / freedoms);
}

double NoiseFit::fitRatios(const Gram& gram, std::vector<double>& ratios) const {
  const auto worth = [&] {
    double v = value(gram, ratios, nullptr);
    for (std::size_t b = 0; b < blocks_.size(); ++b) v -= ratios[b] > 0.0 ? blocks_[b].price : 0.0;
    return v;
  };
  double best = worth();
  for (int round = 0; round < 6; ++round) {
    const double before = best;
    for (std::size_t b = 0; b < blocks_.size(); ++b) {
      if (blocks_[b].fixed || gram.first[b] < 0) continue;
      const auto attempt = [&](double ratio) {
        const double kept = ratios[b];
        ratios[b] = ratio;
        const double v = worth();
        if (v > best + kBetterRatio) {
          best = v;
          return true;
        }
        ratios[b] = kept;
        return false;
      };
      if (ratios[b] > 0.0) {
        for (const double step : {1.5, 1.15, 1.04}) {
          while (attempt(ratios[b] * step)) {
          }
          while (attempt(ratios[b] / step)) {
          }
        }
        if (blocks_[b].price > 0.0) attempt(0.0);
      } else {
        for (const double r : {0.1, 0.3, 1.0, 3.0}) attempt(r);
      }
    }
    if (best - before < kRatiosSettled) break;
  }
  return best;
}

double NoiseFit::prices(const NoiseModel& noise, const std::vector<double>& ratios,
                        const NoiseFitOptions& options) const {
  double sum = 0.0;
  for (const DriftTerm& t : noise.drift) {
    if (!(t.ratio > 0.0)) continue;
    sum += t.smooth ? options.smoothPrice : options.driftPrice;
  }
  for (std::size_t b = 0; b < blocks_.size(); ++b) sum += ratios[b] > 0.0 ? blocks_[b].price : 0.0;
  return sum;
}

NoiseFitResult NoiseFit::at(const NoiseModel& noise, const NoiseFitOptions& options) const {
  std::vector<double> ratios;
  for (const RandomBlock& b : blocks_) ratios.push_back(b.ratio);
  return fittedRatios(noise, ratios, options);
}

NoiseFitResult NoiseFit::fittedRatios(const NoiseModel& noise, const std::vector<double>& from,
                                      const NoiseFitOptions& options) const {
  NoiseFitResult result;
  result.noise = noise;
  result.ratios = from;
  const Gram gram = gramOf(noise, result.ratios, true);
  fitRatios(gram, result.ratios);
  double rest = 0.0;
  result.logEvidence = value(gram, result.ratios, &rest) - prices(noise, result.ratios, options);
  result.freedoms = std::max(1, rows_.length() - base_);
  result.white = std::sqrt(rest / result.freedoms);
  result.whiteStd = result.white / std::sqrt(2.0 * result.freedoms);
  return result;
}

bool NoiseFit::take(NoiseModel noise, const NoiseFitOptions& options, NoiseFitResult& best) const {
  const Gram gram = gramOf(noise, best.ratios, false);
  double rest = 0.0;
  const double v = value(gram, best.ratios, &rest) - prices(noise, best.ratios, options);
  if (!(v > best.logEvidence + kBetterDrift)) return false;
  best.noise = std::move(noise);
  best.logEvidence = v;
  best.white = std::sqrt(rest / best.freedoms);
  return true;
}

void NoiseFit::dropTerms(const NoiseFitOptions& options, NoiseFitResult& best) const {
  for (std::size_t k = 0; k < best.noise.drift.size();) {
    NoiseModel without = best.noise;
    without.drift.erase(without.drift.begin() + static_cast<long>(k));
    if (!take(std::move(without), options, best)) ++k;
  }
}

void NoiseFit::addTerm(const NoiseFitOptions& options, NoiseFitResult& best) const {
  constexpr double kRatio = 0.6;  // its size is fitted next
  const int directions = static_cast<int>(rows_.factors.cols());
  // smooth ones of time constants that are long beside the spacing: a short one is as rough as the noise
  const int rough = static_cast<int>(timeConstants_.size()), smooth = rough - kRoughOnly;
  const auto further = [&](std::size_t number) {
    NoiseModel more = best.noise;
    const int k = static_cast<int>(number), of = k / directions;
    more.drift.push_back({k % directions, kRatio,
                          timeConstants_[static_cast<std::size_t>(of < rough ? of : of - smooth)],
                          of >= rough});
    return more;
  };
  std::vector<double> worth(static_cast<std::size_t>(directions * (rough + smooth)));
  if (worth.empty()) return;
  const auto worthOf = [&](const NoiseFit& fit, std::size_t k) {
    const NoiseModel more = further(k);
    const std::vector<double> ratios(best.ratios.begin(), best.ratios.begin() + fit.blocks_.size());
    return fit.value(fit.gramOf(more, ratios, false), ratios, nullptr) - prices(more, best.ratios, options);
  };
  // which of them, with the blocks where they are: their columns are many
  NoiseRows bare = rows_;
  if (!blocks_.empty()) bare.target = withoutBlocks(best);
  const NoiseFit quick(bare, {});
  parallelFor(worth.size(), [&](std::size_t k) { worth[k] = worthOf(quick, k); });
  std::vector<std::size_t> order(worth.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return worth[a] > worth[b]; });
  if (!blocks_.empty()) {
    order.resize(std::min(order.size(), kLikeliest));
    parallelFor(order.size(), [&](std::size_t i) { worth[order[i]] = worthOf(*this, order[i]); });
  }
  const std::size_t most =
      *std::max_element(order.begin(), order.end(), [&](auto a, auto b) { return worth[a] < worth[b]; });
  take(further(most), options, best);
}

/// The target less what the blocks are expected to do.
Eigen::VectorXd NoiseFit::withoutBlocks(const NoiseFitResult& best) const {
  const Gram gram = gramOf(best.noise, best.ratios, false);
  const auto n = gram.products.cols() - 1;
  Eigen::VectorXd scale = Eigen::VectorXd::Ones(n);
  for (std::size_t b = 0; b < blocks_.size(); ++b)
    if (gram.first[b] >= 0)
      scale.segment(gram.first[b], blocks_[b].columns.cols()).setConstant(best.ratios[b]);
  Eigen::MatrixXd m = scale.asDiagonal() * gram.products.topLeftCorner(n, n) * scale.asDiagonal();
  m.diagonal().head(base_).array() += kRidge;
  m.diagonal().tail(n - base_).array() += 1.0;
  const Cholesky factor(m);
  const Eigen::VectorXd values = scale.cwiseProduct(
      factor.solveUpper(factor.solveLower(scale.cwiseProduct(gram.products.row(n).head(n).transpose()))));
  Eigen::VectorXd left = rows_.target;
  for (std::size_t b = 0; b < blocks_.size(); ++b)
    if (gram.first[b] >= 0)
      left -= blocks_[b].columns * values.segment(gram.first[b], blocks_[b].columns.cols());
  return left;
}

/// What lasts less than from one row to the next, and is as large in every row, is white noise.
double NoiseFit::shortestOf(int direction) const {
  constexpr double kAlike = 0.99;
  const auto sizes = rows_.factors.col(direction).cwiseAbs();
  return sizes.minCoeff() > kAlike * sizes.maxCoeff() ? timeConstants_.front() : 0.0;
}

void NoiseFit::refineTerms(int round, const NoiseFitOptions& options, NoiseFitResult& best) const {
  constexpr double kSteps[] = {1.7, 1.3, 1.15};  // factors of a size; of a time constant their squares
  constexpr int kMostSteps = 4;
  const double step = kSteps[std::min(round, 2)];
  for (std::size_t k = 0; k < best.noise.drift.size(); ++k) {
    const auto scaled = [&](double ratio, double tau) {
      NoiseModel other = best.noise;
      other.drift[k].ratio *= ratio;
      other.drift[k].tau *= tau;
      if (!timeConstants_.empty())
        other.drift[k].tau =
            std::clamp(other.drift[k].tau, shortestOf(other.drift[k].direction), timeConstants_.back());
      return take(std::move(other), options, best);
    };
    const auto walk = [&](double ratio, double tau) {
      int steps = 0;
      while (steps < kMostSteps && scaled(ratio, tau)) ++steps;
      return steps > 0;
    };
    for (const double tau : {1.0, kSmoothTime}) {  // as rough as it was, or smooth
      NoiseModel other = best.noise;
      other.drift[k].smooth = !other.drift[k].smooth;
      other.drift[k].tau *= tau;
      if (take(std::move(other), options, best)) break;
    }
    if (!walk(step, 1.0)) walk(1.0 / step, 1.0);
    if (!walk(1.0, step * step)) walk(1.0, 1.0 / (step * step));
  }
}

NoiseFitResult NoiseFit::run(const NoiseModel& start, const NoiseFitOptions& options) const {
  NoiseFitResult best = at(start, options);
  for (int round = 0;; ++round) {
    const double before = best.logEvidence;
    if (options.dropDrift) dropTerms(options, best);
    if (options.addDrift && !timeConstants_.empty()) addTerm(options, best);
    if (options.refine) refineTerms(round, options, best);
    NoiseFitResult refitted = fittedRatios(best.noise, best.ratios, options);
    if (refitted.logEvidence > best.logEvidence) best = std::move(refitted);
    if (!(best.logEvidence - before >= kEnough)) break;  // nor where it is no number
  }
  best.whiteStd = best.white / std::sqrt(2.0 * best.freedoms);
  return best;
}

double NoiseFit::whiteStdOf(const NoiseFitResult& found, const NoiseFitOptions& options) const {
  // factors of the size and of the time constant of the shortest drift, which is rough or smooth
  constexpr double kSizes[] = {0.1, 0.2, 0.35, 0.5, 0.65, 0.8, 0.9, 1.0, 1.12, 1.25, 1.5, 2.0, 3.0, 6.0};
  constexpr double kTimes[] = {0.4, 0.6, 0.8, 1.0, 1.25, 1.7, 2.5};
  constexpr std::size_t kTimesAsked = std::size(kTimes);
  const auto shortest = std::min_element(
      found.noise.drift.begin(), found.noise.drift.end(), [](const DriftTerm& a, const DriftTerm& b) {
        return std::pair(!(a.ratio > 0.0), a.tau) < std::pair(!(b.ratio > 0.0), b.tau);
      });
  if (shortest == found.noise.drift.end() || !(shortest->ratio > 0.0)) return found.whiteStd;
  const auto k = static_cast<std::size_t>(shortest - found.noise.drift.begin());
  // what lasts less than from one row to the next is white noise
  const double least = std::min(shortest->tau, timeConstants_.empty() ? 0.0 : timeConstants_.front());
  constexpr std::size_t kOfAKind = std::size(kSizes) * kTimesAsked;
  std::vector<double> evidence(2 * kOfAKind), white(evidence.size());
  parallelFor(evidence.size(), [&](std::size_t i) {
    NoiseModel other = found.noise;
    DriftTerm& drift = other.drift[k];
    if (i >= kOfAKind) {
      drift.smooth = !drift.smooth;
      drift.tau *= drift.smooth ? kSmoothTime : 1.0 / kSmoothTime;
    }
    drift.ratio *= kSizes[i % kOfAKind / kTimesAsked];
    drift.tau = std::max(least, drift.tau * kTimes[i % kTimesAsked]);
    const Gram gram = gramOf(other, found.ratios, false);
    double rest = 0.0;
    evidence[i] = value(gram, found.ratios, &rest) - prices(other, found.ratios, options);
    white[i] = std::sqrt(rest / found.freedoms);
  });
  const double most = *std::max_element(evidence.begin(), evidence.end());
  double sum = 0.0, squares = 0.0;
  for (std::size_t i = 0; i < evidence.size(); ++i) {
    // a step of each factor; any standard deviation of the white noise is as likely as another, beforehand
    const std::size_t at = i % kOfAKind / kTimesAsked;
    const double before = kSizes[at == 0 ? 0 : at - 1],
                 after = kSizes[std::min(at + 1, std::size(kSizes) - 1)];
    const double weight = std::exp(evidence[i] - most) * std::log(after / before) * white[i];
    sum += weight;
    squares += weight * (white[i] - found.white) * (white[i] - found.white);
  }
  return std::hypot(found.whiteStd, std::sqrt(squares / sum));
}

NoiseFitResult fitNoise(const NoiseRows& rows, std::vector<RandomBlock> blocks, const NoiseModel& start,
                        const NoiseFitOptions& options, int most) {
  if (rows.rows() <= most) return NoiseFit(rows, std::move(blocks)).run(start, options);
  constexpr int kStretch = 30;
  const std::vector<int> taken = stretches(rows.rows(), most, kStretch);
  NoiseRows fewer;
  for (const int i : taken) fewer.time.push_back(rows.time[i]);
  fewer.factors = some(rows.factors, taken, rows.rows());
  fewer.target = some(rows.target, taken, rows.rows()).col(0);
  fewer.base = some(rows.base, taken, rows.rows());
  for (RandomBlock& b : blocks) b.columns = some(b.columns, taken, rows.rows());
  NoiseModel from = start;
  from.variance = some(start.variance, taken, rows.rows()).col(0);
  NoiseFitResult fit = NoiseFit(fewer, std::move(blocks)).run(from, options);
  fit.noise.variance = start.variance;
  return fit;
}

}  // namespace mm
