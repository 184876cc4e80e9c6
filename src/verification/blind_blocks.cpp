#include <algorithm>
#include <cmath>
#include <map>
#include <memory>

#include "base/dense.h"
#include "base/erase_if.h"
#include "base/error.h"
#include "base/format.h"
#include "base/median.h"
#include "base/numbered_names.h"
#include "session/trial_block.h"
#include "verification/blind_verdict.h"
#include "verification/figures.h"
#include "verification/fresh_points.h"

namespace mm {
namespace {

constexpr double kFewestMeasured = 0.5;  // of the usual measurements: a block with less is left out
constexpr double kMeasuredTwice = 1.5;   // more: it was measured again
constexpr double kNoPrediction = 1e-12;  // m (rad): rounding

/// The blocks of a session by their numbers: indices of observations.
struct SortedBlocks {
  std::string trial;
  int of = 0;
  std::map<int, std::pair<char, std::vector<std::size_t>>> blocks;
  std::size_t outside = 0;  // observations of no block
};

SortedBlocks sortedBlocks(const Session& session) {
  SortedBlocks sorted;
  for (std::size_t i = 0; i < session.observations.size(); ++i) {
    const int placement = session.observations[i].placement;
    const std::optional<TrialBlock> block =
        session.placements.empty() ? std::nullopt : trialBlock(session.placements[placement]);
    if (!block) {
      ++sorted.outside;
      continue;
    }
    if (sorted.trial.empty()) sorted.trial = block->trial, sorted.of = block->of;
    if (block->trial != sorted.trial)
      throw InputError(session.source + ": holds the blind trials " + sorted.trial + " and " + block->trial +
                       "; evaluate one at a time: each has states of its own");
    auto& [state, members] = sorted.blocks[block->number];
    if (!members.empty() && state != block->state)
      throw InputError(session.source + format(": block %d is in state A and in state B; its placements were "
                                               "renamed",
                                               block->number));
    state = block->state;
    members.push_back(i);
  }
  if (sorted.blocks.empty())
    throw InputError(session.source +
                     ": has no block of a blind trial; measure a plan that mm plan verify "
                     "--blind wrote");
  return sorted;
}

/// A block as a session without a trial.
Session alone(const Session& session, const std::vector<std::size_t>& members) {
  Session block = session;
  block.observations.clear();
  NumberedNames placements, setups;
  for (const std::size_t i : members) {
    Observation o = session.observations[i];
    const std::string& name = session.placements[o.placement];
    o.placement = placements[trialBlock(name)->placement];
    if (o.setup >= 0) o.setup = setups[session.setups[o.setup]];
    block.observations.push_back(std::move(o));
  }
  block.placements = placements.all();
  if (block.placements == std::vector<std::string>{""}) block.placements.clear();
  block.setups = setups.all();
  return block;
}

/// Weights of the data rows: 0 of those that stand apart from what the correction leaves of them.
Eigen::VectorXd withoutOutliers(const FreshPoints& points, const Eigen::VectorXd& left, int& outliers) {
  constexpr double kFarApart = 6.0, kOfMedian = 1.4826;  // standard deviations; one over the median size
  constexpr double kMostFarApart = 0.1;                  // of the rows: more are no outliers
  Eigen::VectorXd weights = points.fitted().weight;
  std::vector<double> sizes;
  for (int i = 0; i < points.rows(); ++i) sizes.push_back(std::abs(left[i]));
  const double limit = kFarApart * kOfMedian * upperMedian(sizes);
  for (int i = 0; i < points.rows(); ++i)
    if (sizes[i] > limit) {
      weights[points.space().used()[i]] = 0.0;
      ++outliers;
    }
  if (outliers > kMostFarApart * points.rows()) outliers = 0;
  return outliers > 0 ? weights : Eigen::VectorXd();
}

/// What each block fits for itself, so that neither state can show it. @param block of one trial.
std::string notJudgedIn(const Session& block) {
  std::string what;
  const auto& features = block.artifact.features;
  const bool free = std::any_of(features.begin(), features.end(), [](const Feature& f) { return !f.known; });
  if (block.poseFree(0) || free) what = "Shifts and turns of the whole artifact";
  if (free) what += ", and its scale (positions of its features are free)";
  if (!block.setups.empty())
    what += what.empty() ? "Zeros of the instrument" : " and zeros of the instrument";
  return what.empty() ? what : what + " are not judged: each block fits them";
}

/// The share of each axis's predicted error that is there, all axes and what no axis carries together.
void judgeAxes(const FreshPoints& points, TrialBlockFigures& found) {
  constexpr double kNothing = 1e-6;   // of the largest: rounding
  constexpr double kNotApart = 1e-4;  // of pivots of columns of length 1
  const int count = points.axisCount();
  if (count < 2) return;  // one axis is the whole
  Eigen::MatrixXd columns(points.length(), count + 1);
  for (int a = 0; a < count; ++a) columns.col(a) = points.own(a);
  columns.col(count) = points.rest();
  const Eigen::RowVectorXd sizes = columns.colwise().norm();
  const double largest = sizes.maxCoeff();
  std::vector<int> used;
  for (int c = 0; c <= count; ++c)
    if (sizes[c] > kNothing * largest) used.push_back(c);
  Eigen::MatrixXd unit = columns(Eigen::all, used);
  for (Eigen::Index k = 0; k < unit.cols(); ++k) unit.col(k) /= unit.col(k).norm();
  if (rankOf(unit, kNotApart) < unit.cols()) return;
  const Eigen::VectorXd share = leastSquares(unit, points.raw());
  for (std::size_t k = 0; k < used.size(); ++k)
    if (used[k] < count) found.ofAxis[points.axes()[used[k]]] = share[k] / sizes[used[k]];
}

/// @param found receives the figures. @return RMS of the predicted error, m (rad).
double judge(const Session& block, const Calibration& calibration, const CalibrateOptions& options,
             TrialBlockFigures& found, bool& angular) {
  Eigen::VectorXd weights;
  auto points = std::make_unique<FreshPoints>(block, calibration, options, 0, weights);
  const auto project = [&] {
    const Eigen::VectorXd whole = points->whole();
    const bool shows = rmsOf(*points, whole)[0] > kNoPrediction;
    found.remaining = shows ? whole.dot(points->raw()) / whole.squaredNorm() : kNotMeasured;
    return Eigen::VectorXd(points->raw() - (shows ? found.remaining : 0.0) * whole);
  };
  weights = withoutOutliers(*points, project(), found.outliers);
  if (weights.size() > 0) {
    points = std::make_unique<FreshPoints>(block, calibration, options, 0, weights);
    project();
  }
  found.rms = rmsOf(*points, points->raw())[0];
  judgeAxes(*points, found);
  angular = points->angular();
  return rmsOf(*points, points->whole())[0];
}

/// The measurements of a block in one go each: others lie between. Those that are too few are left out.
std::vector<std::vector<std::size_t>> runsOf(const std::vector<std::size_t>& members, double fewest) {
  std::vector<std::vector<std::size_t>> runs;
  for (std::size_t i = 0; i < members.size(); ++i) {
    if (i == 0 || members[i] != members[i - 1] + 1) runs.emplace_back();
    runs.back().push_back(members[i]);
  }
  eraseIf(runs, [&](const auto& run) { return run.size() < fewest; });
  return runs;
}

/// How a block was measured other than in one go; empty: in one.
std::string howMeasured(const std::vector<std::size_t>& members,
                        const std::vector<std::vector<std::size_t>>& runs, double usual) {
  std::size_t counted = 0;
  for (const auto& run : runs) counted += run.size();
  const bool twice = counted > kMeasuredTwice * usual;
  std::string how;
  if (runs.size() > 1)
    how = std::string(twice ? "was measured more than once and counts once"
                            : "was measured in pieces and counts") +
          ", as the mean";
  else if (twice)
    how = "was measured more than once without another between and counts once";
  if (counted < members.size())
    how += (how.empty() ? "was measured in pieces" : "") +
           format("; %zu of its %zu measurements are a piece of too few and are left out",
                  members.size() - counted, members.size());
  return how;
}

/// The mean of the runs of a block. @param found knows number and state. @return mean square of the
/// predicted error, m^2 (rad^2).
double judgeRuns(const Session& session, const std::vector<std::vector<std::size_t>>& runs,
                 const Calibration& calibration, const CalibrateOptions& options, TrialBlockFigures& found,
                 bool& angular) {
  double square = 0.0, remaining = 0.0, predicted = 0.0;
  std::map<std::string, int> told;  // runs that tell of an axis
  const double count = runs.size();
  for (const std::vector<std::size_t>& run : runs) {
    TrialBlockFigures one;
    predicted += std::pow(judge(alone(session, run), calibration, options, one, angular), 2) / count;
    square += one.rms * one.rms / count;
    remaining += one.remaining / count;
    for (const auto& [axis, share] : one.ofAxis) found.ofAxis[axis] += share / count, ++told[axis];
    found.outliers += one.outliers;
    found.measurements += run.size();
    for (const std::size_t i : run) found.time += session.observations[i].time / run.size() / count;
  }
  found.rms = std::sqrt(square);
  found.remaining = remaining;
  for (const auto& [axis, runsTold] : told)
    if (runsTold < count) found.ofAxis.erase(axis);
  return predicted;
}

}  // namespace

TrialBlocks trialBlocks(const Session& session, const Calibration& calibration,
                        const CalibrateOptions& options) {
  SortedBlocks sorted = sortedBlocks(session);
  TrialBlocks found;
  found.trial = sorted.trial;
  found.planned = sorted.of;
  std::vector<double> counts;
  for (const auto& [number, block] : sorted.blocks) counts.push_back(block.second.size());
  const double usual = upperMedian(counts);
  const auto remark = [&](int number, const std::string& what) {
    found.remarks.push_back(format("block %d ", number) + what);
  };
  if (sorted.outside > 0)
    found.remarks.push_back(std::to_string(sorted.outside) + " measurements belong to no block");
  CalibrateOptions own = options;
  own.progress = nullptr;
  double squares = 0.0;
  int judged = 0;
  for (int number = 1; number <= sorted.of; ++number) {
    const auto at = sorted.blocks.find(number);
    if (at == sorted.blocks.end()) {
      remark(number, "was not measured");
      continue;
    }
    const auto& [state, members] = at->second;
    const auto runs = runsOf(members, kFewestMeasured * usual);
    if (runs.empty()) {
      const bool pieces = members.back() - members.front() >= members.size();
      remark(number, format("has %zu of %.0f measurements%s and is left out", members.size(), usual,
                            pieces ? ", in pieces," : ""));
      continue;
    }
    if (const std::string how = howMeasured(members, runs, usual); !how.empty()) remark(number, how);
    if (found.notJudged.empty()) {
      const Session one = alone(session, members);
      found.fittedPose = one.poseFree(0);
      found.notJudged = notJudgedIn(one);
    }
    if (options.cancelled && options.cancelled()) throw Cancelled("stopped before the blocks were judged");
    if (options.progress)
      options.progress(format("block %d", number), static_cast<double>(number - 1) / sorted.of);
    TrialBlockFigures block;
    block.number = number;
    block.state = state;
    try {
      squares += judgeRuns(session, runs, calibration, own, block, found.angular);
    } catch (const NumericalError&) {
      remark(number, "has too few measurements and is left out");
      continue;
    }
    ++judged;
    if (!std::isfinite(block.remaining) || !std::isfinite(block.rms)) {
      remark(number, "has no point at which the correction shows and is left out");
      continue;
    }
    found.blocks.push_back(block);
  }
  found.predicted = std::sqrt(squares / std::max<double>(1.0, found.blocks.size()));
  if (judged > 0 && !(found.predicted > kNoPrediction))
    throw InputError(session.source +
                     ": the calibration predicts no error at these points, so a correction "
                     "cannot be seen; mm plan verify selects points that show it");
  std::sort(found.blocks.begin(), found.blocks.end(),
            [](const TrialBlockFigures& a, const TrialBlockFigures& b) { return a.time < b.time; });
  return found;
}

}  // namespace mm
