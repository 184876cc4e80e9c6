#include "verification/blind_verdict.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "base/distributions.h"
#include "base/format.h"
#include "base/nearest_name.h"
#include "base/quantity_words.h"
#include "base/tiny.h"
#include "verification/blind_trial.h"
#include "verification/trial_orders.h"

namespace mm {
namespace {

constexpr double kLittleGain = 0.5;     // share of the correction: less than this, for sure, is nothing
constexpr double kAsMuch = 1.25;        // a gain of 1, or one over this: tables are interpolated and rounded
constexpr double kLittleChange = 1.25;  // ratio of the RMS: less, for sure, is no change that counts
constexpr int kTrialColumns = 3;        // level, trend, step
constexpr double kNoRms = 1e-15;        // m (rad): no logarithm of less

double quantile(double freedoms, double outside = kFalseAnswers) {
  return studentLimit(0.5 * outside, freedoms);
}

Eigen::VectorXd stepOf(const std::string& order) {
  Eigen::VectorXd step(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) step[i] = order[i] == 'B' ? 0.5 : -0.5;
  return step;
}

/// Level and trend, orthonormal columns.
Eigen::MatrixXd levelAndTrend(const Eigen::VectorXd& time) {
  Eigen::MatrixXd trend(time.size(), 2);
  trend.col(0).setConstant(1.0 / std::sqrt(time.size()));
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

/// What the blocks of one state say of their scatter, a level, trend and step taken out.
struct Scatter {
  double variance = 0.0, freedoms = 0.0;
};

/// @param left residuals. @param maker the matrix that makes them (idempotent). Only what the residuals of a
/// state have from its own blocks counts as their degrees of freedom, so that the variance is not too small
/// whatever the other state's is.
Scatter scatterOfState(char state, const std::string& order, const Eigen::VectorXd& left,
                       const Eigen::MatrixXd& maker) {
  Scatter found;
  for (Eigen::Index i = 0; i < left.size(); ++i) {
    if (order[i] != state) continue;
    found.variance += left[i] * left[i];
    for (Eigen::Index j = 0; j < left.size(); ++j)
      if (order[j] == state) found.freedoms += maker(i, j) * maker(i, j);
  }
  constexpr double kNoFreedom = 1e-9;
  if (found.freedoms < kNoFreedom) found.freedoms = 0.0;
  found.variance /= std::max(found.freedoms, kTiny);
  return found;
}

/// Half-width of a weighted sum of the blocks (Welch, Satterthwaite).
double halfWidth(const Eigen::VectorXd& weights, const std::string& order, const Scatter& ofA,
                 const Scatter& ofB, double outside) {
  double square = 0.0, spread = 0.0;
  for (const char state : {'A', 'B'}) {
    const Scatter& scatter = state == 'A' ? ofA : ofB;
    double part = 0.0;
    for (Eigen::Index i = 0; i < weights.size(); ++i)
      if (order[i] == state) part += weights[i] * weights[i] * scatter.variance;
    square += part;
    spread += part * part / scatter.freedoms;
  }
  return spread > 0.0 ? quantile(square * square / spread, outside) * std::sqrt(square) : 0.0;
}

/// @param outside share of the intervals that need not hold the truth.
StatesCompared compared(const std::string& order, const Eigen::VectorXd& y, const Eigen::VectorXd& time,
                        double outside = kFalseAnswers) {
  StatesCompared found;
  const Eigen::MatrixXd trend = levelAndTrend(time);
  Eigen::MatrixXd columns(time.size(), kTrialColumns);
  columns << trend, stepOf(order);
  const Eigen::MatrixXd normal = columns.transpose() * columns;
  const Eigen::MatrixXd weights = normal.ldlt().solve(columns.transpose());  // of the blocks
  const Eigen::VectorXd x = weights * y;
  const Eigen::MatrixXd maker = Eigen::MatrixXd::Identity(y.size(), y.size()) - columns * weights;
  const Eigen::VectorXd left = maker * y;
  const Scatter ofA = scatterOfState('A', order, left, maker), ofB = scatterOfState('B', order, left, maker);
  const bool tells = ofA.freedoms > 0.0 && ofB.freedoms > 0.0 && std::abs(correlationWithTime(order)) < 0.95;
  const auto half = [&](const Eigen::Vector3d& contrast) {
    return tells ? halfWidth(weights.transpose() * contrast, order, ofA, ofB, outside)
                 : std::numeric_limits<double>::infinity();
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

std::string gainText(const OpenedTrial& t) {
  const auto text = [](const TrialFigure& gain) {
    return format(" %.2f ± %.2f", gain.value, gain.upper - gain.value);
  };
  std::string axes;
  for (const AxisGain& axis : t.axes)
    if (std::isfinite(axis.gain.upper)) axes += (axes.empty() ? "" : ", ") + axis.axis + text(axis.gain);
  return "gain" + text(t.gain) + (axes.empty() ? "" : " (" + axes + ")");
}

std::string rmsText(const OpenedTrial& t, bool angular) {
  const auto number = [&](double value) { return shortNumber(value / unitOf(angular)); };
  const std::string unit = " " + nameOfUnit(angular);
  return "RMS " + number(t.without.value) + " -> " + number(t.with.value) + unit +
         " (what is left: " + number(t.with.lower) + " to " + number(t.with.upper) + unit + ")";
}

/// What is sure of the figures of a trial.
struct Evidence {
  bool changed = false, same = false;  // the RMS
  bool arrives = false;                // any of the correction, to either side
  bool little = false;                 // of it
  bool worse = false;
  // Axes whose gain is surely below 0, above a half, below it.
  std::vector<std::string> reversed, arriving, missing;
};

Evidence evidenceOf(const OpenedTrial& t, double smallestP) {
  Evidence e;
  const double most = std::max(kFalseAnswers, smallestP) * (1.0 + 1e-9);
  e.changed = t.ratio.lower > 1.0 || t.ratio.upper < 1.0;
  e.same = t.ratio.upper < kLittleChange && t.ratio.lower > 1.0 / kLittleChange;
  e.arrives = t.gainP <= most && (t.gain.lower > 0.0 || t.gain.upper < 0.0);
  e.little = t.gain.upper < kLittleGain && t.gain.lower > -kLittleGain;
  e.worse = e.changed && t.rmsP <= most && t.ratio.value > 1.0;
  for (const AxisGain& axis : t.axes) {
    if (axis.p <= most && axis.gain.upper < 0.0) e.reversed.push_back(axis.axis);
    if (axis.p <= most && axis.gain.lower > kLittleGain) e.arriving.push_back(axis.axis);
    if (axis.gain.upper < kLittleGain) e.missing.push_back(axis.axis);
  }
  return e;
}

TrialVerdict trialVerdict(const OpenedTrial& t, const Evidence& e) {
  if (!e.reversed.empty()) return TrialVerdict::kWrongSign;
  if (e.little && (e.same || !e.changed)) {
    if (e.arriving.empty()) return TrialVerdict::kDidNothing;
    return e.worse ? TrialVerdict::kWorse : TrialVerdict::kHelpedInPart;  // an axis has what is another's
  }
  if (e.arrives && t.gain.lower > kAsMuch) return TrialVerdict::kOvercorrected;
  const bool reversed = t.gain.value < 0.0;
  if (e.changed && e.arrives && reversed == (t.ratio.value > 1.0)) {
    if (reversed) return TrialVerdict::kWrongSign;
    return t.gain.upper < 1.0 / kAsMuch || !e.missing.empty() ? TrialVerdict::kHelpedInPart
                                                              : TrialVerdict::kHelped;
  }
  return e.worse ? TrialVerdict::kWorse : TrialVerdict::kCannotTell;
}

std::string cannotTell(OpenedTrial& t, const Evidence& e, const LabelledTrial& trial) {
  const int blocks = trial.blocksA + trial.blocksB;
  if (trial.blocksA == 0 || trial.blocksB == 0)
    return std::string("cannot tell: state ") + (trial.blocksA == 0 ? 'A' : 'B') + " was not measured";
  if (blocks <= kTrialColumns || !std::isfinite(t.gain.upper))
    return format(
        "cannot tell: %d blocks are too few, or lie so that a drift explains them as well; measure "
        "a trial of ten blocks",
        blocks);
  std::string text =
      "cannot tell: " + gainText(t) + format(", ratio of the RMS %.2f to %.2f", t.ratio.lower, t.ratio.upper);
  if (e.arrives)
    text += std::string("; the correction arrives") + (t.gain.value > 0.0 ? "" : " with the wrong sign") +
            ", but the RMS does not show it";
  if (e.arrives && e.same) return text + ": other errors are larger at these points";
  const double logHalf = 0.5 * std::log(t.ratio.upper / t.ratio.lower);
  const double logRatio = std::abs(std::log(t.ratio.value));
  t.blocksWanted = e.arrives ? blocksFor(blocks, logHalf, logRatio)
                             : blocksFor(blocks, t.gain.upper - t.gain.value, kLittleGain);
  return text + (t.blocksWanted > 0
                     ? format("; a trial of %d blocks could tell", t.blocksWanted)
                     : std::string("; the correction is too small for the scatter of these blocks: choose "
                                   "points where it is larger, or more in a block (--places, --touches)"));
}

std::string wrongSign(const Evidence& e, const OpenedTrial& t, const std::string& figures) {
  if (e.reversed.empty() && t.gain.lower > -1.0 / kAsMuch)
    return "it has the wrong sign in part: " + figures + "; mm verify --loaded says of which axis";
  if (e.reversed.empty() || e.reversed.size() == t.axes.size())
    return "it has the wrong sign: " + figures + "; load the table with the other sign";
  const std::string axes = listOf(e.reversed);
  return "the sign is wrong for " + axes + ": " + figures + "; load what corrects " + axes +
         " with the other sign, unless mm verify --loaded says that tables are exchanged";
}

std::string sentenceOf(OpenedTrial& t, const Evidence& e, const LabelledTrial& trial, bool angular) {
  const std::string figures = rmsText(t, angular) + ", " + gainText(t);
  switch (t.verdict) {
    case TrialVerdict::kHelped:
      return "it helped: " + figures;
    case TrialVerdict::kHelpedInPart:
      return format("it helped in part: %.2f of the correction arrives; ", t.gain.value) + figures +
             "; mm verify --loaded says which axis";
    case TrialVerdict::kOvercorrected:
      return format("it corrects too much: the correction is applied %.1f times; ", t.gain.value) + figures +
             "; check whether it is loaded twice, or beside offsets";
    case TrialVerdict::kDidNothing:
      return "it did nothing: " + figures + "; check that the table is loaded and was switched";
    case TrialVerdict::kWrongSign:
      return wrongSign(e, t, figures);
    case TrialVerdict::kWorse:
      return "it made it worse: " + figures +
             "; the table belongs to another axis, or the machine is no longer as it was calibrated: mm "
             "verify --loaded says which";
    case TrialVerdict::kCannotTell:
      break;
  }
  return cannotTell(t, e, trial);
}

}  // namespace

std::string nameOf(TrialVerdict verdict) {
  static constexpr const char* kNames[] = {"helped",     "helped_in_part", "overcorrected", "did_nothing",
                                           "wrong_sign", "worse",          "cannot_tell"};
  return kNames[static_cast<std::size_t>(verdict)];
}

LabelledTrial compareStates(const std::vector<TrialBlockFigures>& blocks) {
  LabelledTrial trial;
  const Eigen::Index n = blocks.size();
  std::string order;
  Eigen::VectorXd time(n), remaining(n), logRms(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const TrialBlockFigures& block = blocks[i];
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
  const std::map<std::string, double>& axes = blocks.front().ofAxis;
  for (const auto& [axis, value] : axes) {
    Eigen::VectorXd y(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const auto& ofAxis = blocks[i].ofAxis;
      const auto at = ofAxis.find(axis);
      y[i] = at == ofAxis.end() ? kNotMeasured : at->second;
    }
    if (y.allFinite()) trial.ofAxis[axis] = compared(order, y, time, kFalseAnswers / axes.size());
  }
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
  for (const auto& [axis, gain] : trial.ofAxis)
    t.axes.push_back({axis, figure(-side * gain.difference, gain.half), gain.p});
  const Evidence evidence = evidenceOf(t, trial.smallestP);
  t.verdict = trialVerdict(t, evidence);
  t.inWords = sentenceOf(t, evidence, trial, angular);
  return t;
}

}  // namespace mm
