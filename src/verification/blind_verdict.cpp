#include "verification/blind_verdict.h"

#include <Eigen/Dense>
#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>

#include "base/format.h"
#include "base/quantity_words.h"
#include "verification/blind_trial.h"
#include "verification/trial_orders.h"

namespace mm {
namespace {

constexpr double kFalseAnswers = 0.01;  // of false answers
constexpr double kLittleGain = 0.5;     // share of the correction: less than this, for sure, is nothing
constexpr double kLittleChange = 1.25;  // ratio of the RMS: less, for sure, is no change that counts
constexpr int kTrialColumns = 3;        // level, trend, step
constexpr double kNoRms = 1e-15;        // m (rad): no logarithm of less

double quantile(int freedoms) {
  return boost::math::quantile(boost::math::students_t(freedoms), 1.0 - 0.5 * kFalseAnswers);
}

Eigen::VectorXd stepOf(const std::string& order) {
  Eigen::VectorXd step(static_cast<Eigen::Index>(order.size()));
  for (std::size_t i = 0; i < order.size(); ++i)
    step[static_cast<Eigen::Index>(i)] = order[i] == 'B' ? 0.5 : -0.5;
  return step;
}

/// Level and trend, orthonormal columns.
Eigen::MatrixXd levelAndTrend(const Eigen::VectorXd& time) {
  Eigen::MatrixXd trend(time.size(), 2);
  trend.col(0).setConstant(1.0 / std::sqrt(static_cast<double>(time.size())));
  const Eigen::VectorXd centred = time.array() - time.mean();
  trend.col(1) = centred / std::max(centred.norm(), 1e-300);
  return trend;
}

/// p of the randomisation test: of all orders, how many explain as much beside the trend.
double randomisationP(const std::string& order, const Eigen::VectorXd& y, const Eigen::MatrixXd& trend) {
  const auto explained = [&](const std::string& o) {
    Eigen::VectorXd step = stepOf(o);
    step -= trend * (trend.transpose() * step);
    const double square = step.squaredNorm();
    return square > 0.0 ? std::pow(step.dot(y), 2) / square : 0.0;
  };
  constexpr double kRounding = 1e-9;
  const double here = explained(order) * (1.0 - kRounding);
  double as = 0.0, all = 0.0;
  forEachOrder(order, [&](const std::string& other) {
    ++all;
    if (explained(other) >= here) ++as;
  });
  return as / all;
}

StatesCompared compared(const std::string& order, const Eigen::VectorXd& y, const Eigen::VectorXd& time) {
  StatesCompared found;
  const int freedoms = static_cast<int>(order.size()) - kTrialColumns;
  const Eigen::MatrixXd trend = levelAndTrend(time);
  Eigen::MatrixXd columns(time.size(), kTrialColumns);
  columns << trend, stepOf(order);
  const Eigen::MatrixXd normal = columns.transpose() * columns;
  const Eigen::LDLT<Eigen::MatrixXd> solver(normal);
  const Eigen::VectorXd x = solver.solve(columns.transpose() * y);
  const double infinite = std::numeric_limits<double>::infinity();
  double variance = infinite, t = infinite;
  const bool tells = freedoms > 0 && std::abs(correlationWithTime(order)) < 0.95;
  if (tells) {
    variance = (y - columns * x).squaredNorm() / freedoms;
    t = quantile(freedoms);
  }
  const auto half = [&](const Eigen::Vector3d& contrast) {
    return tells ? t * std::sqrt(variance * contrast.dot(solver.solve(contrast))) : infinite;
  };
  const double level = trend(0, 0);
  found.a = level * x[0] - 0.5 * x[2];
  found.b = level * x[0] + 0.5 * x[2];
  found.aHalf = half({level, 0.0, -0.5});
  found.bHalf = half({level, 0.0, 0.5});
  found.difference = x[2];
  found.half = half({0.0, 0.0, 1.0});
  found.p = randomisationP(order, y, trend);
  return found;
}

/// Blocks of a trial in which a half-width of `half` with n blocks would be below `wanted`; 0: too many.
int blocksFor(int n, double half, double wanted) {
  constexpr double kMargin = 0.8;  // for the scatter of the scatter
  for (int more = n + 2 - n % 2; more <= kMostBlocks; more += 2) {
    const double with = half * quantile(more - kTrialColumns) / quantile(n - kTrialColumns) *
                        std::sqrt(static_cast<double>(n) / more);
    if (with < kMargin * wanted) return more;
  }
  return 0;
}

std::string gainText(const TrialFigure& gain) {
  return format("gain %.2f ± %.2f", gain.value, gain.upper - gain.value);
}

std::string rmsText(const OpenedTrial& t, bool angular) {
  const auto number = [&](double value) { return shortNumber(value / unitOf(angular)); };
  const std::string unit = " " + nameOfUnit(angular);
  return "RMS " + number(t.without.value) + " -> " + number(t.with.value) + unit +
         " (what is left: " + number(t.with.lower) + " to " + number(t.with.upper) + unit + ")";
}

std::string cannotTell(OpenedTrial& t, bool arrives, int blocks) {
  if (blocks <= kTrialColumns || !std::isfinite(t.gain.upper))
    return format(
        "cannot tell: %d blocks are too few, or lie so that a drift explains them as well; measure "
        "a trial of ten blocks",
        blocks);
  const double logHalf = 0.5 * std::log(t.ratio.upper / t.ratio.lower);
  const double logRatio = std::abs(std::log(t.ratio.value));
  std::string text = "cannot tell: " + gainText(t.gain) +
                     format(", ratio of the RMS %.2f to %.2f", t.ratio.lower, t.ratio.upper);
  if (arrives)
    text += std::string("; the correction arrives") + (t.gain.value > 0.0 ? "" : " with the wrong sign") +
            ", but the RMS does not show it";
  t.blocksWanted = arrives ? blocksFor(blocks, logHalf, logRatio)
                           : blocksFor(blocks, t.gain.upper - t.gain.value, kLittleGain);
  return text + (t.blocksWanted > 0
                     ? format("; a trial of %d blocks could tell", t.blocksWanted)
                     : std::string("; the correction is too small for the scatter of these blocks: choose "
                                   "points where it is larger, or more in a block (--places, --touches)"));
}

std::string sentenceOf(OpenedTrial& t, bool arrives, int blocks, bool angular) {
  const std::string figures = rmsText(t, angular) + ", " + gainText(t.gain);
  switch (t.verdict) {
    case TrialVerdict::kHelped:
      return "it helped: " + figures;
    case TrialVerdict::kDidNothing:
      return "it did nothing: " + figures + "; check that the table is loaded and was switched";
    case TrialVerdict::kWrongSign:
      return "it has the wrong sign: " + figures + "; load the table with the other sign";
    case TrialVerdict::kWorse:
      return "it made it worse: " + figures +
             "; the table belongs to another axis, or the machine is no longer as it was calibrated: mm "
             "verify --loaded says which";
    case TrialVerdict::kCannotTell:
      break;
  }
  return cannotTell(t, arrives, blocks);
}

}  // namespace

std::string nameOf(TrialVerdict verdict) {
  switch (verdict) {
    case TrialVerdict::kHelped:
      return "helped";
    case TrialVerdict::kDidNothing:
      return "did_nothing";
    case TrialVerdict::kWrongSign:
      return "wrong_sign";
    case TrialVerdict::kWorse:
      return "worse";
    case TrialVerdict::kCannotTell:
      break;
  }
  return "cannot_tell";
}

LabelledTrial compareStates(const std::vector<TrialBlockFigures>& blocks) {
  LabelledTrial trial;
  const auto n = static_cast<Eigen::Index>(blocks.size());
  std::string order;
  Eigen::VectorXd time(n), remaining(n), logRms(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const TrialBlockFigures& block = blocks[static_cast<std::size_t>(i)];
    order += block.state;
    ++(block.state == 'A' ? trial.blocksA : trial.blocksB);
    time[i] = block.time;
    remaining[i] = block.remaining;
    logRms[i] = std::log(std::max(block.rms, kNoRms));
  }
  if (trial.blocksA == 0 || trial.blocksB == 0) return trial;
  trial.smallestP = smallestP(order);
  trial.remaining = compared(order, remaining, time);
  trial.logRms = compared(order, logRms, time);
  return trial;
}

OpenedTrial opened(const LabelledTrial& trial, char on, bool angular) {
  OpenedTrial t;
  const double side = on == 'B' ? 1.0 : -1.0;  // of what is with minus what is without
  const auto figure = [](double value, double half) {
    return TrialFigure{value, value - half, value + half};
  };
  const auto exponential = [](const TrialFigure& f) {
    return TrialFigure{std::exp(f.value), std::exp(f.lower), std::exp(f.upper)};
  };
  const StatesCompared& r = trial.logRms;
  const TrialFigure a = exponential(figure(r.a, r.aHalf)), b = exponential(figure(r.b, r.bHalf));
  t.with = on == 'B' ? b : a;
  t.without = on == 'B' ? a : b;
  t.ratio = exponential(figure(side * r.difference, r.half));
  t.gain = figure(-side * trial.remaining.difference, trial.remaining.half);
  t.gainP = trial.remaining.p;
  t.rmsP = r.p;
  const double most = std::max(kFalseAnswers, trial.smallestP) * (1.0 + 1e-9);
  const bool changed = t.ratio.lower > 1.0 || t.ratio.upper < 1.0;
  const bool arrives = t.gainP <= most && (t.gain.lower > 0.0 || t.gain.upper < 0.0);
  const bool reversed = arrives && t.gain.value < 0.0;
  const bool little = t.gain.upper < kLittleGain && t.gain.lower > -kLittleGain;
  const bool same = t.ratio.upper < kLittleChange && t.ratio.lower > 1.0 / kLittleChange;
  if (little && (same || !changed))
    t.verdict = TrialVerdict::kDidNothing;
  else if (changed && arrives && reversed == (t.ratio.value > 1.0))
    t.verdict = reversed ? TrialVerdict::kWrongSign : TrialVerdict::kHelped;
  else if (changed && t.rmsP <= most && t.ratio.value > 1.0)
    t.verdict = TrialVerdict::kWorse;
  t.inWords = sentenceOf(t, arrives, trial.blocksA + trial.blocksB, angular);
  return t;
}

}  // namespace mm
