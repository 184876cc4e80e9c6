#include "diagnosis/drift_report.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>

#include "base/dense.h"
#include "base/units.h"
#include "diagnosis/wording.h"
#include "estimation/drift.h"
#include "estimation/repeatability.h"
#include "posterior/slots.h"

namespace mm {
namespace {

const double kSaid = std::log(100.0);  // nats: drift that is not there at 100 to 1 is not spoken of
constexpr std::size_t kMostAsked = 3;  // causes told for a direction
constexpr double kSomeShare = 0.3;  // of a drift's variance: what a cause must take over to be what it may be
constexpr double kPartOfRun = 0.05;  // of a session: half a run in one direction, of five in both (ISO 230-2)
constexpr double kOfThePlace = 0.5;  // of its variance that runs have in common: more follows the place
/// Standard deviation of what two slow courses have in common by chance: each has one or two degrees of
/// freedom in a run. What is told is no chance at two and a half of it.
constexpr double kAlikeByChance = 0.7, kNoChance = 2.5;

/// @param most time constant, s: longer ones do not count.
double varianceAlong(const NoiseModel& noise, int direction, double white,
                     double most = std::numeric_limits<double>::infinity()) {
  double sum = 0.0;
  for (const DriftTerm& t : noise.drift)
    if (t.direction == direction && t.tau < most) sum += t.ratio * t.ratio * white * white;
  return sum;
}

Explanation withoutDriftAlong(Explanation found, int direction) {
  auto& drift = found.noise.drift;
  drift.erase(std::remove_if(drift.begin(), drift.end(),
                             [&](const DriftTerm& t) { return t.direction == direction; }),
              drift.end());
  return found;
}

/// The drift along a direction as the session had it, a row, whitened.
/// @param most time constant, s: that of longer ones does not count.
Eigen::VectorXd pathOf(const Search& search, const Explanation& found, int direction,
                       double most = std::numeric_limits<double>::infinity()) {
  const Questions& q = search.questions();
  const int n = q.rows.rows();
  const Eigen::VectorXd left = q.rows.target - search.evidenceAt(found)->fit(found.members).withoutDrift;
  const Eigen::MatrixXd byTerm =
      whitenerOf(q.rows, found.noise.variance, found.noise.drift).driftByTerm(left.head(n));
  Eigen::VectorXd path = Eigen::VectorXd::Zero(n);
  int term = 0;
  for (const DriftTerm& t : found.noise.drift) {
    if (!(t.ratio > 0.0)) continue;
    if (t.direction == direction && t.tau < most) path += byTerm.col(term);
    ++term;
  }
  return path;
}

/// Causes that may act, and whose course resembles the drift along a direction, likeliest first.
std::vector<DriftResult::Perhaps> perhapsOf(const Search& search, const Explanation& found, int direction,
                                            const PosteriorAnswer& answer) {
  const Questions& q = search.questions();
  Eigen::MatrixXd path = Eigen::MatrixXd::Zero(q.rows.length(), 1);
  path.col(0).head(q.rows.rows()) = pathOf(search, found, direction);
  q.space->project(path);
  const double all = path.squaredNorm();
  std::vector<DriftResult::Perhaps> perhaps;
  for (std::size_t g = 0; g < answer.sample.inclusion.size() && all > 0.0; ++g) {
    const Group& group = q.groups.groups[g];
    const auto there = [&](const Member& m) { return m.group == static_cast<int>(g); };
    if (group.profile || !(answer.sample.inclusion[g] > kPossible) ||
        std::any_of(found.members.begin(), found.members.end(), there))
      continue;
    double share = 0.0;
    for (const Shape& s : group.shapes) {
      Eigen::MatrixXd columns = q.groups.columns.middleCols(s.first, s.main);
      q.space->project(columns);
      const Eigen::VectorXd rest = path - columns * leastSquares(columns, path);
      share = std::max(share, 1.0 - rest.squaredNorm() / all);
    }
    if (share > kSomeShare)
      perhaps.push_back(
          {specOf(q, answer, static_cast<int>(g)), odds(answer.sample, answer.sample.inclusion[g]), share});
  }
  std::stable_sort(perhaps.begin(), perhaps.end(),
                   [](const auto& a, const auto& b) { return a.odds > b.odds; });
  if (perhaps.size() > kMostAsked) perhaps.resize(kMostAsked);
  return perhaps;
}

/// What changes within less time than this is told by no measurement that was made again.
struct Quickest {
  double most = 0.0;        // s
  bool ofThePlace = false;  // it is the same in each run
};

/// Where runs agree, what changes, or what of it changes within a part of one, follows the place or the
/// direction of travel; else it is drift.
Quickest quickestOf(const Search& search, const Explanation& found, int direction) {
  const Questions& q = search.questions();
  const double spacing = medianSpacing(q.rows.time);
  if (q.space->fitted().repeated.from != "runs") return {spacing, false};
  const auto [first, last] = std::minmax_element(q.rows.time.begin(), q.rows.time.end());
  const auto followsThePlace = [&](double most) {
    const Eigen::VectorXd path = pathOf(search, found, direction, most);
    const Problem& problem = q.space->problem();
    Eigen::VectorXd values = Eigen::VectorXd::Constant(static_cast<int>(problem.rows().size()), kNotMeasured);
    const std::vector<int>& used = q.space->used();
    bool angular = false;
    for (std::size_t i = 0; i < used.size() && static_cast<int>(i) < path.size(); ++i) {
      if (path[static_cast<int>(i)] == 0.0) continue;
      values[used[i]] = path[static_cast<int>(i)];
      angular = problem.rows()[used[i]].angular;
    }
    const SharedByRuns shared = sharedByRuns(problem, values, angular);
    return shared.share >
           std::max(kOfThePlace, kNoChance * kAlikeByChance / std::sqrt(std::max(1, shared.pairs)));
  };
  const double part = std::max(spacing, kPartOfRun * (*last - *first));
  for (const double most : {std::numeric_limits<double>::infinity(), part})
    if (followsThePlace(most)) return {most, true};
  return {spacing, false};
}

bool anyTimes(const Session& session) {
  const auto& all = session.observations;
  return std::any_of(all.begin(), all.end(), [&](const Observation& o) { return session.timed(o); });
}

}  // namespace

DriftReport driftOf(const Search& search, const Explanation& found, const PosteriorAnswer& answer) {
  const Questions& q = search.questions();
  DriftReport report{{}, found};
  std::vector<DriftResult>& results = report.drift;
  std::vector<int> directions;
  for (int d = 0; d < static_cast<int>(q.directions.size()); ++d) {
    if (!(varianceAlong(found.noise, d, found.white) > 0.0)) continue;
    Explanation without = search.refitted(found.members, withoutDriftAlong(found, d));
    if (found.logEvidence - without.logEvidence < kSaid) {
      report.spokenOf = withoutDriftAlong(std::move(report.spokenOf), d);
      continue;
    }
    DriftResult r;
    r.direction = q.directions[d];
    const Quickest quickest = quickestOf(search, found, d);
    r.std = std::sqrt(varianceAlong(found.noise, d, found.white)) * q.directionScale[d];
    r.quickStd = std::sqrt(varianceAlong(found.noise, d, found.white, quickest.most)) * q.directionScale[d];
    double largest = 0.0;
    for (const DriftTerm& t : found.noise.drift)
      if (t.direction == d && t.ratio > largest) largest = t.ratio, r.timeConstant = t.tau;
    r.quick = r.timeConstant < quickest.most;
    r.ofThePlace = r.quick && quickest.ofThePlace;
    if (!anyTimes(q.space->problem().session())) r.timeConstant = 0.0;
    results.push_back(std::move(r));
    directions.push_back(d);
  }
  if (report.spokenOf.noise.drift.size() != found.noise.drift.size())
    report.spokenOf = search.refitted(found.members, report.spokenOf);

  for (std::size_t r = 0; r < results.size(); ++r)
    results[r].perhaps = perhapsOf(search, found, directions[r], answer);
  return report;
}

}  // namespace mm
