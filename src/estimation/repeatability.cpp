#include "estimation/repeatability.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "base/format.h"
#include "base/range.h"
#include "estimation/robust.h"

namespace mm {
namespace {

constexpr double kOutlying = 4.0;        // times the bulk: 1 in 16,000 of normal noise is lost
constexpr double kRoundingOfAll = 1e-9;  // of the largest residual: 1 pm of 1 mm

/// Differences that should be noise alone, each over its own standard deviation in units of the noise.
/// @return standard deviation of the noise, without what stands apart. @param kept which counted.
double spreadOf(const std::vector<double>& differences, std::vector<char>& kept) {
  const double bulk = robustSigma(differences);
  kept.assign(differences.size(), 1);
  double sum = 0.0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < differences.size(); ++i) {
    // a coarse scale reads most repeats alike: then nothing says what stands apart
    if (bulk > 0.0 && std::abs(differences[i]) > kOutlying * bulk) {
      kept[i] = 0;
      continue;
    }
    sum += differences[i] * differences[i];
    ++count;
  }
  return count > 0 ? std::sqrt(sum / static_cast<double>(count)) : 0.0;
}

/// What was measured more than once.
class Repeats {
 public:
  Repeats(const Problem& problem, const Eigen::VectorXd& residuals, bool angular)
      : problem_(problem),
        residuals_(residuals),
        angular_(angular),
        observations_(problem.session().observations) {
    findTolerance();
    findTargets();
  }

  Repeatability consecutive() const {
    constexpr std::size_t kFewest = 10;
    std::vector<double> differences;
    double dof = 0.0;
    const int count = static_cast<int>(observations_.size());
    for (int first = 0; first < count;) {
      int last = first + 1;
      while (last < count && target_[last] == target_[first]) ++last;
      for (int row = 0; row < rowsOf(first); ++row) dof += compare(first, last, row, differences);
      first = last;
    }
    if (differences.size() < kFewest) return {};
    std::vector<char> kept;
    Repeatability found;
    found.value = spreadOf(differences, kept);
    found.dof = dof * share(kept);
    found.from = "consecutive";
    found.inWords = std::to_string(differences.size()) + " repeats one after the other";
    return found;
  }

  Repeatability runs() const {
    const std::vector<Pair> pairs = inGroups(pairsOfRuns());
    std::vector<double> differences = withoutShift(pairs, std::vector<char>(pairs.size(), 1), false);
    // what the shift of a small group takes away must not make the others seem to stand apart
    std::map<std::pair<int, int>, double> of;
    for (const Pair& p : pairs) of[p.group] += 1.0;
    for (std::size_t i = 0; i < pairs.size(); ++i)
      differences[i] *= std::sqrt(of[pairs[i].group] / (of[pairs[i].group] - 1.0));
    std::vector<char> kept;
    spreadOf(differences, kept);
    // the outliers bend no shift
    differences = withoutShift(pairs, kept, true);
    double sum = 0.0;
    std::map<std::pair<int, int>, int> sizes;
    for (std::size_t i = 0; i < pairs.size(); ++i)
      if (kept[i] != 0) ++sizes[pairs[i].group];
    double independent = 0.0, all = 0.0;
    for (const auto& [group, size] : sizes) independent += size - 1, all += size;
    constexpr double kFewest = 8.0;  // degrees of freedom: beyond 25 % uncertain it says too little
    if (independent < kFewest) return {};
    for (std::size_t i = 0; i < pairs.size(); ++i)
      if (kept[i] != 0) sum += differences[i] * differences[i];
    Repeatability found;
    found.value = std::sqrt(sum / (2.0 * independent));
    // Two differences that share a measurement are not independent: Satterthwaite's degrees of freedom.
    const double chained = 2.0 * chains(pairs, kept);
    found.dof = 4.0 * all * all / (4.0 * all + chained) * independent / all;
    if (found.dof < kFewest) return {};
    found.from = "runs";
    int last = 0;
    std::map<int, int> targets;
    for (const Pair& p : pairs) last = std::max(last, p.group.first), ++targets[p.target];
    found.inWords = std::to_string(last + 2) + " runs over " + std::to_string(targets.size()) +
                    " targets, excluding shifts of a whole run";
    return found;
  }

  /// A run ends where a target comes again.
  std::vector<int> numbersOfRuns() const {
    std::map<int, int> seen;  // a target: the last run with it
    std::vector<int> numbers;
    int run = 0;
    for (int o = 0; o < static_cast<int>(observations_.size()); ++o) {
      if ((o == 0 || target_[o] != target_[o - 1]) && directed(observations_[o])) {
        const auto known = seen.find(target_[o]);
        if (known != seen.end() && known->second == run) ++run;
        seen[target_[o]] = run;
      }
      numbers.push_back(run);
    }
    return numbers;
  }

  SharedByRuns shared() const {
    struct Sums {
      double count = 0.0, earlier = 0.0, later = 0.0;
    };
    const std::vector<Pair> pairs = pairsOfRuns();
    std::map<std::pair<int, int>, Sums> groups;
    for (const Pair& p : pairs) {
      Sums& s = groups[p.group];
      s.count += 1.0, s.earlier += p.earlier, s.later += p.later;
    }
    double common = 0.0, all = 0.0;
    for (const Pair& p : pairs) {
      const Sums& s = groups[p.group];
      const double earlier = p.earlier - s.earlier / s.count, later = p.later - s.later / s.count;
      common += earlier * later;
      all += 0.5 * (earlier * earlier + later * later);
    }
    if (!(all > 0.0)) return {};
    return {common / all, static_cast<int>(groups.size())};
  }

 private:
  struct Pair {
    int target = 0, row = 0;
    std::pair<int, int> group;          // the earlier run; which rows are compared with each other
    double earlier = 0.0, later = 0.0;  // m or rad
    double difference() const { return later - earlier; }
  };

  static double share(const std::vector<char>& kept) {
    return static_cast<double>(std::count(kept.begin(), kept.end(), 1)) / static_cast<double>(kept.size());
  }

  int rowsOf(int o) const { return problem_.firstRow(o + 1) - problem_.firstRow(o); }

  /// The residual of one row of an observation; NaN where it has none of that kind.
  double residual(int o, int row) const {
    const int i = problem_.firstRow(o) + row;
    if (row >= rowsOf(o) || !problem_.uses(o) || problem_.rows()[i].angular != angular_) return NAN;
    return residuals_[i];
  }

  /// Compares the repeats first … last − 1 of a target. @return degrees of freedom that they add.
  double compare(int first, int last, int row, std::vector<double>& differences) const {
    const int count = last - first;
    if (count < 2) return 0.0;
    std::vector<double> r;
    for (int o = first; o < last; ++o) {
      r.push_back(residual(o, row));
      if (std::isnan(r.back())) return 0.0;
    }
    if (count == 2) {
      differences.push_back((r[1] - r[0]) / std::sqrt(2.0));
      return 1.0;
    }
    for (int i = 1; i + 1 < count; ++i)
      differences.push_back((r[i - 1] - 2.0 * r[i] + r[i + 1]) / std::sqrt(6.0));
    const double p = count - 2;  // second differences overlap: their covariances are 6, -4, 1
    return 36.0 * p * p / (36.0 * p + 32.0 * (p - 1.0) + 2.0 * std::max(0.0, p - 2.0));
  }

  void findTolerance() {
    constexpr double kSame = 20e-6, kOfRange = 1e-3;  // m or rad; of what the joint moved, on small machines
    const int joints = problem_.model().machine().jointCount();
    tolerance_.assign(joints, kSame);
    moves_.assign(joints, 0);
    for (int j = 0; j < joints; ++j) {
      Range range;
      for (const Observation& o : observations_) range.add(o.position[j]);
      if (range.size() > kSame * kOfRange) tolerance_[j] = std::min(kSame, kOfRange * range.size());
      moves_[j] = range.size() > tolerance_[j] ? 1 : 0;
    }
  }

  bool same(int a, int b) const {
    constexpr double kSameApproach = 0.02;
    const Observation &p = observations_[a], &q = observations_[b];
    if (p.kind != q.kind || p.feature != q.feature || p.setup != q.setup || p.travel != q.travel)
      return false;
    for (std::size_t j = 0; j < p.position.size(); ++j)
      if (std::abs(p.position[j] - q.position[j]) > tolerance_[j]) return false;
    if ((problem_.state(a).approach - problem_.state(b).approach).norm() > kSameApproach) return false;
    if (rowsOf(a) != rowsOf(b)) return false;
    for (int i = problem_.firstRow(a), k = problem_.firstRow(b); i < problem_.firstRow(a + 1); ++i, ++k)
      if (problem_.rows()[i].component != problem_.rows()[k].component) return false;
    return true;
  }

  /// Numbers the targets. Only observations whose readings have nearly the same sum can be of one.
  void findTargets() {
    const int count = static_cast<int>(observations_.size());
    target_.resize(count);
    std::iota(target_.begin(), target_.end(), 0);
    std::vector<double> key(count, 0.0);
    double window = 0.0;
    for (std::size_t j = 0; j < tolerance_.size(); ++j) {
      const double factor = 1.0 + 0.37 * static_cast<double>(j);  // else x + 1 and y - 1 have the same sum
      window += factor * tolerance_[j];
      for (int o = 0; o < count; ++o) key[o] += factor * observations_[o].position[j];
    }
    std::vector<int> order(target_);
    std::sort(order.begin(), order.end(),
              [&](int a, int b) { return key[a] != key[b] ? key[a] < key[b] : a < b; });
    constexpr int kSeen =
        64;  // neighbours compared at most: a session that stands still has all in one place
    for (int i = 0; i < count; ++i)
      for (int k = i + 1; k < std::min(count, i + kSeen) && key[order[k]] - key[order[i]] <= window; ++k)
        if (same(order[i], order[k])) target_[root(order[k])] = root(order[i]);
    for (int o = 0; o < count; ++o) target_[o] = root(o);
  }

  int root(int o) const {
    while (target_[o] != o) o = target_[o];
    return o;
  }

  /// The direction of travel is known of each joint that moves: else a run back is taken for a run there.
  bool directed(const Observation& o) const {
    for (std::size_t j = 0; j < moves_.size(); ++j)
      if (moves_[j] != 0 && o.travel[j] == 0.0) return false;
    return true;
  }

  /// Targets of two runs, one after the other.
  std::vector<Pair> pairsOfRuns() const {
    std::map<int, std::pair<int, int>> seen;  // a target: the last run with it, the observation in it
    std::map<std::vector<double>, int> kinds;
    std::vector<Pair> pairs;
    const std::vector<int> runs = numbersOfRuns();
    for (int o = 0; o < static_cast<int>(observations_.size()); ++o) {
      if (o > 0 && target_[o] == target_[o - 1]) continue;
      if (!directed(observations_[o])) continue;
      const int run = runs[o];
      auto found = seen.find(target_[o]);
      if (found != seen.end() && found->second.first == run - 1)
        for (int row = 0; row < rowsOf(o); ++row) {
          const double earlier = residual(found->second.second, row), later = residual(o, row);
          if (std::isnan(later - earlier)) continue;
          std::vector<double> kind = observations_[o].travel;
          kind.push_back(observations_[o].setup);
          kind.push_back(problem_.rows()[problem_.firstRow(o) + row].component);
          const int number = kinds.emplace(kind, static_cast<int>(kinds.size())).first->second;
          pairs.push_back({target_[o], row, {run - 1, number}, earlier, later});
        }
      seen[target_[o]] = {run, o};
    }
    return pairs;
  }

  /// Without those that are alone in their group: their shift is all that they tell.
  static std::vector<Pair> inGroups(std::vector<Pair> pairs) {
    std::map<std::pair<int, int>, int> of;
    for (const Pair& p : pairs) ++of[p.group];
    pairs.erase(std::remove_if(pairs.begin(), pairs.end(), [&](const Pair& p) { return of[p.group] < 2; }),
                pairs.end());
    return pairs;
  }

  /// The differences without what is common to their group: its median, or the mean of those kept.
  static std::vector<double> withoutShift(const std::vector<Pair>& pairs, const std::vector<char>& kept,
                                          bool mean) {
    std::map<std::pair<int, int>, std::vector<double>> groups;
    for (std::size_t i = 0; i < pairs.size(); ++i)
      if (kept[i] != 0) groups[pairs[i].group].push_back(pairs[i].difference());
    std::map<std::pair<int, int>, double> shift;
    for (auto& [group, d] : groups) {
      if (mean) {
        shift[group] = std::accumulate(d.begin(), d.end(), 0.0) / static_cast<double>(d.size());
        continue;
      }
      shift[group] = medianOf(d);
    }
    std::vector<double> left;
    for (const Pair& p : pairs) {
      const auto at = shift.find(p.group);
      left.push_back(at == shift.end() ? 0.0 : p.difference() - at->second);
    }
    return left;
  }

  /// How often a measurement is in two of the differences.
  static double chains(const std::vector<Pair>& pairs, const std::vector<char>& kept) {
    std::map<std::pair<int, int>, int> last;  // a target's row: the run of its last difference
    double count = 0.0;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      if (kept[i] == 0) continue;
      const auto at = last.find({pairs[i].target, pairs[i].row});
      if (at != last.end() && at->second == pairs[i].group.first - 1) ++count;
      last[{pairs[i].target, pairs[i].row}] = pairs[i].group.first;
    }
    return count;
  }

  const Problem& problem_;
  const Eigen::VectorXd& residuals_;
  bool angular_;
  const std::vector<Observation>& observations_;
  std::vector<double> tolerance_;
  std::vector<char> moves_;
  std::vector<int> target_;
};

}  // namespace

double Repeatability::relativeStd() const { return dof > 0.0 ? 1.0 / std::sqrt(2.0 * dof) : kNotMeasured; }

Repeatability repeatedMeasurements(const Problem& problem, const Eigen::VectorXd& residuals, bool angular) {
  const Repeats repeats(problem, residuals, angular);
  Repeatability found = repeats.consecutive();
  if (!(found.dof > 0.0)) found = repeats.runs();
  // repeats that are alike but for the rounding of their numbers were computed, or read on a coarse scale
  if (!(found.dof > 0.0) || !(found.value > kRoundingOfAll * residuals.cwiseAbs().maxCoeff())) return {};
  found.inWords =
      "from " + found.inWords +
      format(": %.3g degrees of freedom, ± %.2g %% (k = 2)", found.dof, 200.0 * found.relativeStd());
  return found;
}

std::vector<int> runNumbers(const Problem& problem) {
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(problem.rowCount());
  return Repeats(problem, none, false).numbersOfRuns();
}

SharedByRuns sharedByRuns(const Problem& problem, const Eigen::VectorXd& values, bool angular) {
  return Repeats(problem, values, angular).shared();
}

}  // namespace mm
