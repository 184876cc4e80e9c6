#include "verification/decision.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "verification/loading_evidence.h"

namespace mm {
namespace {

constexpr double kSeen = 5.0;           // standard deviations of noise that a correction must be large
const double kMisfit = std::log(1e-5);  // chance to say in vain that something changed
const double kNotExcluded = std::log(20.0);

/// Indices of the hypotheses, the best first.
std::vector<std::size_t> orderOf(const std::vector<double>& scores) {
  std::vector<std::size_t> order(scores.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return scores[a] > scores[b]; });
  return order;
}

/// Hypotheses with what changed since the calibration, as far as they were asked.
class ChangesAsked {
 public:
  ChangesAsked(const LoadingEvidence& evidence, const std::vector<LoadedHow>& all)
      : evidence_(evidence), all_(all) {
    changes_.resize(all.size());
  }
  const Changes& of(std::size_t h) {
    if (!changes_[h]) changes_[h] = evidence_.changes(all_[h]);
    return *changes_[h];
  }

 private:
  const LoadingEvidence& evidence_;
  const std::vector<LoadedHow>& all_;
  std::vector<std::optional<Changes>> changes_;
};

void addRivals(const std::vector<LoadedHow>& all, const std::vector<double>& scores, std::size_t best,
               Decision& decision) {
  for (const std::size_t h : orderOf(scores))
    if (h != best && scores[best] - scores[h] < kNotExcluded) {
      decision.rivals.push_back(all[h]);
      decision.odds.push_back(std::exp(scores[h] - scores[best]));
    }
}

}  // namespace

Eigen::MatrixXd covarianceOf(const FreshPoints& points, const Calibration& calibration) {
  const auto count = static_cast<Eigen::Index>(points.parameters().size());
  Eigen::MatrixXd covariance(count, count);
  for (Eigen::Index i = 0; i < count; ++i)
    for (Eigen::Index j = 0; j < count; ++j)
      covariance(i, j) = calibration.covariance(points.parameters()[static_cast<std::size_t>(i)],
                                                points.parameters()[static_cast<std::size_t>(j)]);
  return covariance;
}

Decision decide(const FreshPoints& points, const PointSystem& system, const Calibration& calibration,
                bool loaded) {
  const LoadingEvidence evidence(points, system, calibration);
  std::vector<char> seen;
  for (int a = 0; a < static_cast<int>(points.axes().size()); ++a)
    seen.push_back(evidence.asCalibrated().left(system.whiten(points.own(a))).norm() > kSeen);
  Decision decision;
  decision.tablesSeen = std::any_of(seen.begin(), seen.end(), [](char s) { return s != 0; });
  decision.offsetsSeen =
      points.hasOffsets() && evidence.asCalibrated().left(system.whiten(points.offsets())).norm() > kSeen;
  decision.seen = decision.tablesSeen || decision.offsetsSeen;
  const std::vector<LoadedHow> all = hypothesesOf(points, loaded, seen, decision.offsetsSeen);
  ChangesAsked asked(evidence, all);
  std::vector<double> scores = evidence.scores(evidence.asCalibrated(), all);
  std::size_t best = decision.seen ? orderOf(scores).front() : 0;
  // Something changed where one effect is not what it was, or where the whole does not fit; or where that is
  // likelier than tables at the wrong place, which can look like it.
  const auto changedUnder = [&](std::size_t h) {
    return !asked.of(h).effects.empty() || std::log(asked.of(h).unexplainedPValue) < kMisfit;
  };
  decision.drifted = changedUnder(best) || (best != 0 && asked.of(0).score > scores[best]);
  if (decision.drifted && decision.seen) {
    scores = evidence.scores(evidence.changedSince(), all);
    best = orderOf(scores).front();
  }
  decision.changed = asked.of(best).effects;
  decision.unexplainedPValue = asked.of(best).unexplainedPValue;
  decision.hypothesis = all[best];
  if (decision.seen) addRivals(all, scores, best, decision);
  return decision;
}

}  // namespace mm
