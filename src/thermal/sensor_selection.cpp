#include "thermal/sensor_selection.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <thread>

#include "base/error.h"
#include "base/parallel.h"
#include "thermal/duty_error.h"
#include "thermal/ridge.h"

namespace mm {
namespace {

using Subset = std::vector<int>;

/// From 0 to 1.
Eigen::VectorXd scaled(const Eigen::VectorXd& v) {
  return (v.array() - v.minCoeff()) / (v.maxCoeff() - v.minCoeff());
}

constexpr double kNoError = 1e-300;       // has a logarithm
constexpr int kInformationSamples = 500;  // longer series are thinned evenly to so many for the information
constexpr int kShortlist = 500;           // sets of each size that are proposed to the cross-validation

double binomial(int n, int k) {
  double count = 1.0;
  for (int i = 0; i < k; ++i) count = count * (n - i) / (i + 1);
  return std::round(count);
}

std::vector<Subset> allSubsets(int n, int size) {
  std::vector<Subset> subsets;
  Subset subset(static_cast<std::size_t>(size));
  std::iota(subset.begin(), subset.end(), 0);
  for (;;) {
    subsets.push_back(subset);
    int i = size - 1;
    while (i >= 0 && subset[static_cast<std::size_t>(i)] == n - size + i) --i;
    if (i < 0) return subsets;
    int next = ++subset[static_cast<std::size_t>(i)];
    for (std::size_t j = static_cast<std::size_t>(i) + 1; j < subset.size(); ++j) subset[j] = ++next;
  }
}

/// Runs work(0) … work(count - 1), in blocks; `tick` is called from the caller's thread.
void parallel(std::size_t count, unsigned threads, const std::function<void(std::size_t)>& work,
              const std::function<void(double)>& tick) {
  constexpr std::size_t kBlock = 16;
  const std::thread::id caller = std::this_thread::get_id();
  Threads(threads).run([&] {
    parallelFor(partsOf(count, kBlock), [&](std::size_t block) {
      const Part part = partOf(count, kBlock, block);
      for (std::size_t i = part.first; i < part.end; ++i) work(i);
      if (std::this_thread::get_id() == caller)
        tick(static_cast<double>(part.first) / static_cast<double>(count));
    });
  });
}

/// One selection under way: the series without constant sensors.
class Selector {
 public:
  Selector(const Eigen::MatrixXd& temperatures, const Eigen::VectorXd& displacement,
           const std::vector<int>& varying, const SelectionSettings& settings,
           const SelectionProgress& progress)
      : settings_(settings),
        progress_(progress),
        temperatures_(temperatures(Eigen::all, varying)),
        displacement_(displacement),
        information_(thinned(temperatures_), thinned(displacement), settings.information),
        gaussian_(temperatures_, displacement, gaussianSettings()),
        duties_(temperatures_, displacement, settings.seed),
        folds_(blockedFolds(static_cast<int>(displacement.size()),
                            std::min(settings.blocks, static_cast<int>(displacement.size())), settings.gap)) {
  }

  SensorSelection run() {
    SensorSelection result;
    const int sensors = information_.sensors();
    const int largest = std::min(settings_.largestSize, sensors);
    for (int s = 0; s < sensors; ++s)
      result.singles.push_back({s, information_.joint({s}), information_.correlation(s)});
    std::stable_sort(result.singles.begin(), result.singles.end(),
                     [](const auto& a, const auto& b) { return a.information > b.information; });
    for (int size = 1; size <= largest; ++size) {
      stage_ = "sets of " + std::to_string(size);
      begin_ = static_cast<double>(size - 1) / largest;
      share_ = 1.0 / largest;
      const bool all = binomial(sensors, size) <= settings_.enumerationLimit;
      tried_ = 0;
      result.sets.push_back(choose(all ? ranked(allSubsets(sensors, size)) : searched(size)));
      result.exhaustive.push_back(all);
      result.subsetsTried.push_back(static_cast<double>(tried_));
    }
    const auto least =
        std::min_element(result.sets.begin(), result.sets.end(),
                         [](const auto& a, const auto& b) { return a.heldOutRms < b.heldOutRms; });
    const double enough = least->heldOutRms * (1.0 + settings_.accuracyMargin);
    const double limit = least->heldOutRms <= settings_.accuracy ? settings_.accuracy : enough;
    while (result.sets[result.recommended].heldOutRms > limit) ++result.recommended;
    report(1.0);
    return result;
  }

  /// The sensors that could take the place of `chosen` in a set.
  std::vector<int> standIns(const SensorSet& set, int chosen) const {
    std::vector<int> others;
    for (int s = 0; s < information_.sensors(); ++s) {
      if (std::find(set.sensors.begin(), set.sensors.end(), s) != set.sensors.end()) continue;
      if (correlation(s, chosen) < settings_.equivalent) continue;
      Subset replaced = set.sensors;
      std::replace(replaced.begin(), replaced.end(), chosen, s);
      if (heldOutRms(replaced) <= set.heldOutRms * (1.0 + settings_.accuracyMargin)) others.push_back(s);
    }
    return others;
  }

 private:
  Eigen::MatrixXd thinned(const Eigen::MatrixXd& all) const {
    return rowsOf(all, evenlyChosen(all.rows(), kInformationSamples));
  }

  InformationSettings gaussianSettings() const {
    InformationSettings settings = settings_.information;
    settings.estimator = InformationEstimator::kCorrelation;
    return settings;
  }

  double correlation(int a, int b) const {
    const Eigen::VectorXd x = temperatures_.col(a).array() - temperatures_.col(a).mean();
    const Eigen::VectorXd y = temperatures_.col(b).array() - temperatures_.col(b).mean();
    return std::abs(x.dot(y)) / std::sqrt(x.squaredNorm() * y.squaredNorm());
  }

  double heldOutRms(const Subset& subset) const {
    return validateRidge(temperatures_(Eigen::all, subset), displacement_, folds_).rms;
  }

  void report(double fraction) const {
    if (progress_ && !progress_(begin_ + share_ * fraction, stage_))
      throw Cancelled("sensor selection: cancelled at the " + stage_);
  }

  /// What proposes a set. The held-out judge is linear, so that linear information has a say as well.
  double proposal(const Subset& subset) const {
    switch (settings_.choice) {
      case SetChoice::kPrediction:
        return -std::log(std::max(duties_.of(subset), kNoError));
      case SetChoice::kHeldOut:
        return information_.joint(subset) + gaussian_.joint(subset);
      case SetChoice::kInformation:
        break;
    }
    return information_.joint(subset);
  }

  std::vector<Subset> ranked(std::vector<Subset> subsets) {
    tried_ += subsets.size();
    std::vector<double> score(subsets.size());
    parallel(
        subsets.size(), settings_.threads, [&](std::size_t i) { score[i] = proposal(subsets[i]); },
        [&](double fraction) { report(0.8 * fraction); });
    std::vector<std::size_t> order(subsets.size());
    std::iota(order.begin(), order.end(), 0u);
    const std::size_t keep = std::min(order.size(), static_cast<std::size_t>(kShortlist));
    std::partial_sort(
        order.begin(), order.begin() + static_cast<long>(keep), order.end(),
        [&](std::size_t a, std::size_t b) { return score[a] != score[b] ? score[a] > score[b] : a < b; });
    std::vector<Subset> best;
    for (std::size_t i = 0; i < keep; ++i) best.push_back(std::move(subsets[order[i]]));
    return best;
  }

  std::vector<Subset> searched(int size) {
    if (!settings_.search)
      throw InputError("sensor selection: " + std::to_string(information_.sensors()) +
                       " sensors in sets of " + std::to_string(size) +
                       " are too many to try all; ask for smaller sets");
    std::atomic<std::size_t> evaluations{0};
    const SetScore score = [&](const Subset& subset) {
      ++evaluations;
      return proposal(subset);
    };
    std::vector<Subset> best = settings_.search(information_.sensors(), size, kShortlist, settings_.seed,
                                                score, [&](double f) { report(0.8 * f); });
    if (best.empty())
      throw NumericalError("sensor selection: the search found no set of " + std::to_string(size));
    tried_ += evaluations;
    for (Subset& subset : best) std::sort(subset.begin(), subset.end());
    return best;
  }

  /// The best set of a shortlist (best proposal first).
  SensorSet choose(const std::vector<Subset>& shortlist) {
    const std::size_t judged = settings_.choice == SetChoice::kInformation ? 1 : shortlist.size();
    std::vector<SensorSet> sets(judged);
    parallel(
        judged, settings_.threads,
        [&](std::size_t i) {
          sets[i] = {shortlist[i], 0.0, heldOutRms(shortlist[i]), duties_.of(shortlist[i])};
          if (settings_.choice != SetChoice::kPrediction)
            sets[i].information = information_.joint(shortlist[i]);
        },
        [&](double fraction) { report(0.8 + 0.2 * fraction); });
    const auto merit = [&](const SensorSet& s) {
      const double heldOut = -std::log(std::max(s.heldOutRms, kNoError));
      return heldOut + (settings_.choice == SetChoice::kPrediction ? -std::log(std::max(s.dutyRms, kNoError))
                                                                   : s.information);
    };
    std::size_t best = 0;
    for (std::size_t i = 1; i < judged; ++i)
      if (merit(sets[i]) > merit(sets[best])) best = i;
    sets[best].information = information_.joint(sets[best].sensors);
    return sets[best];
  }

  const SelectionSettings& settings_;
  const SelectionProgress& progress_;
  Eigen::MatrixXd temperatures_;
  Eigen::VectorXd displacement_;
  SensorInformation information_, gaussian_;
  DutyError duties_;
  std::vector<Fold> folds_;
  std::string stage_ = "single sensors";
  double begin_ = 0.0, share_ = 0.0;
  std::size_t tried_ = 0;
};

}  // namespace

SensorSelection selectSensors(const Eigen::MatrixXd& temperatures, const Eigen::VectorXd& displacement,
                              const SelectionSettings& settings, const SelectionProgress& progress) {
  if (temperatures.rows() != displacement.size())
    throw InputError("sensor selection: " + std::to_string(temperatures.rows()) +
                     " samples of temperature and " + std::to_string(displacement.size()) +
                     " of displacement; the series must have the same length");
  if (displacement.size() < 4)
    throw InputError("sensor selection: " + std::to_string(displacement.size()) +
                     " samples say nothing about information; at least 4 are needed, 100 are usual");
  if (!temperatures.allFinite() || !displacement.allFinite())
    throw InputError(
        "sensor selection: a value is not a finite number; fill the gap or leave the sample out");
  if (!varies(displacement))
    throw InputError("sensor selection: the displacement does not vary, so no temperature can explain it");
  if (settings.largestSize < 1 || settings.blocks < 2)
    throw InputError("sensor selection: the largest set has " + std::to_string(settings.largestSize) +
                     " sensors and there are " + std::to_string(settings.blocks) +
                     " blocks; at least 1 sensor and 2 blocks are needed");
  std::vector<int> varying, constant;
  for (int s = 0; s < temperatures.cols(); ++s)
    (varies(temperatures.col(s)) ? varying : constant).push_back(s);
  if (varying.empty())
    throw InputError("sensor selection: none of the temperatures varies; there is nothing to choose");

  Selector selector(temperatures, displacement, varying, settings, progress);
  SensorSelection result = selector.run();
  result.constant = constant;
  const auto original = [&](int s) { return varying[static_cast<std::size_t>(s)]; };
  const SensorSet& best = result.sets[result.recommended];
  for (int chosen : best.sensors) {
    std::vector<int> others = selector.standIns(best, chosen);
    std::transform(others.begin(), others.end(), others.begin(), original);
    if (!others.empty()) result.equivalent.emplace_back(original(chosen), others);
  }
  for (SensorScore& single : result.singles) single.sensor = original(single.sensor);
  for (SensorSet& set : result.sets)
    for (int& s : set.sensors) s = original(s);
  return result;
}

Eigen::VectorXd greyRelationalGrade(const Eigen::MatrixXd& inputs, const Eigen::MatrixXd& outputs) {
  constexpr double kRho = 0.5;
  if (inputs.rows() != outputs.rows() || inputs.rows() < 2)
    throw InputError("grey relational grade: " + std::to_string(inputs.rows()) +
                     " samples of the inputs and " + std::to_string(outputs.rows()) +
                     " of the outputs; at least 2 are needed, of each as many");
  Eigen::VectorXd grade = Eigen::VectorXd::Zero(inputs.cols());
  int counted = 0;
  for (Eigen::Index p = 0; p < outputs.cols(); ++p) {
    const Eigen::VectorXd out = outputs.col(p);
    if (!varies(out)) continue;
    const Eigen::VectorXd reference = scaled(out);
    Eigen::MatrixXd delta(inputs.rows(), inputs.cols());
    double least = 1.0, most = 0.0;
    for (Eigen::Index i = 0; i < inputs.cols(); ++i) {
      const Eigen::VectorXd in = inputs.col(i);
      if (!varies(in)) continue;
      const bool falls = (in.array() - in.mean()).matrix().dot((out.array() - out.mean()).matrix()) < 0.0;
      delta.col(i) = (reference - scaled(falls ? Eigen::VectorXd(-in) : in)).cwiseAbs();
      least = std::min(least, delta.col(i).minCoeff());
      most = std::max(most, delta.col(i).maxCoeff());
    }
    for (Eigen::Index i = 0; i < inputs.cols(); ++i) {
      if (!varies(inputs.col(i))) continue;
      grade(i) += most > 0.0 ? ((least + kRho * most) / (delta.col(i).array() + kRho * most)).mean() : 1.0;
    }
    ++counted;
  }
  if (counted > 0) grade /= counted;
  return grade;
}

}  // namespace mm
