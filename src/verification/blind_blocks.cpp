#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <set>

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
        session.placements.empty() ? std::nullopt
                                   : trialBlock(session.placements[static_cast<std::size_t>(placement)]);
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
    const std::string& name = session.placements[static_cast<std::size_t>(o.placement)];
    o.placement = placements[trialBlock(name)->placement];
    if (o.setup >= 0) o.setup = setups[session.setups[static_cast<std::size_t>(o.setup)]];
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
    if (sizes[static_cast<std::size_t>(i)] > limit) {
      weights[points.space().used()[static_cast<std::size_t>(i)]] = 0.0;
      ++outliers;
    }
  if (outliers > kMostFarApart * points.rows()) outliers = 0;
  return outliers > 0 ? weights : Eigen::VectorXd();
}

/// @param found receives the figures. @return RMS of the predicted error, m (rad).
double judge(const Session& block, const Calibration& calibration, const CalibrateOptions& options,
             TrialBlockFigures& found, bool& angular) {
  Eigen::VectorXd weights;
  auto points = std::make_unique<FreshPoints>(block, calibration, options, 0, weights);
  const auto project = [&] {
    const Eigen::VectorXd whole = points->whole();
    const double square = whole.squaredNorm();
    found.remaining = square > 0.0 ? whole.dot(points->raw()) / square : kNotMeasured;
    return Eigen::VectorXd(points->raw() - found.remaining * whole);
  };
  weights = withoutOutliers(*points, project(), found.outliers);
  if (weights.size() > 0) {
    points = std::make_unique<FreshPoints>(block, calibration, options, 0, weights);
    project();
  }
  found.rms = rmsOf(*points, points->raw())[0];
  const Problem& problem = *points->fitted().problem;
  const std::vector<int>& used = points->space().used();
  angular = std::all_of(used.begin(), used.end(),
                        [&](int row) { return problem.rows()[static_cast<std::size_t>(row)].angular; });
  return rmsOf(*points, points->whole())[0];
}

/// The measurements of a block in one go each: others lie between. Those that are too few are left out.
std::vector<std::vector<std::size_t>> runsOf(const std::vector<std::size_t>& members, double fewest) {
  std::vector<std::vector<std::size_t>> runs;
  for (std::size_t i = 0; i < members.size(); ++i) {
    if (i == 0 || members[i] != members[i - 1] + 1) runs.emplace_back();
    runs.back().push_back(members[i]);
  }
  runs.erase(std::remove_if(runs.begin(), runs.end(),
                            [&](const auto& run) { return static_cast<double>(run.size()) < fewest; }),
             runs.end());
  return runs;
}

/// The mean of the runs of a block. @param found knows number and state. @return mean square of the
/// predicted error, m^2 (rad^2).
double judgeRuns(const Session& session, const std::vector<std::vector<std::size_t>>& runs,
                 const Calibration& calibration, const CalibrateOptions& options, TrialBlockFigures& found,
                 bool& angular) {
  double square = 0.0, remaining = 0.0, predicted = 0.0;
  const double count = static_cast<double>(runs.size());
  for (const std::vector<std::size_t>& run : runs) {
    TrialBlockFigures one;
    predicted += std::pow(judge(alone(session, run), calibration, options, one, angular), 2) / count;
    square += one.rms * one.rms / count;
    remaining += one.remaining / count;
    found.outliers += one.outliers;
    found.measurements += static_cast<int>(run.size());
    for (const std::size_t i : run)
      found.time += session.observations[i].time / static_cast<double>(run.size()) / count;
  }
  found.rms = std::sqrt(square);
  found.remaining = remaining;
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
  for (const auto& [number, block] : sorted.blocks)
    counts.push_back(static_cast<double>(block.second.size()));
  const double usual = upperMedian(counts);
  const auto remark = [&](int number, const std::string& what) {
    found.remarks.push_back(format("block %d ", number) + what);
  };
  if (sorted.outside > 0)
    found.remarks.push_back(std::to_string(sorted.outside) + " measurements belong to no block");
  CalibrateOptions own = options;
  own.progress = nullptr;
  double squares = 0.0;
  for (int number = 1; number <= sorted.of; ++number) {
    const auto at = sorted.blocks.find(number);
    if (at == sorted.blocks.end()) {
      remark(number, "was not measured");
      continue;
    }
    const auto& [state, members] = at->second;
    const auto runs = runsOf(members, kFewestMeasured * usual);
    if (runs.empty()) {
      remark(number, format("has %zu of %.0f measurements and is left out", members.size(), usual));
      continue;
    }
    if (static_cast<double>(members.size()) > kMeasuredTwice * usual ||
        members.back() - members.front() >= members.size())
      remark(number, "was measured more than once and counts once, as the mean");
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
    found.blocks.push_back(block);
  }
  found.predicted = std::sqrt(squares / std::max<double>(1.0, static_cast<double>(found.blocks.size())));
  constexpr double kNoPrediction = 1e-12;  // m (rad): rounding
  if (!found.blocks.empty() && !(found.predicted > kNoPrediction))
    throw InputError(session.source +
                     ": the calibration predicts no error at these points, so a correction "
                     "cannot be seen; mm plan verify selects points that show it");
  std::sort(found.blocks.begin(), found.blocks.end(),
            [](const TrialBlockFigures& a, const TrialBlockFigures& b) { return a.time < b.time; });
  return found;
}

}  // namespace mm
