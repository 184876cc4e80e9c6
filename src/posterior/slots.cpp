#include "posterior/slots.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

namespace mm {
namespace {

constexpr double kAsked = 0.05;  // inclusion from which a cause has a slot
constexpr double kRivalsFrom = 0.002;
constexpr double kOfTheRest = 0.02;  // share of what is left that a further rival must have
/// A rival acts instead: beside those of the slot it is less likely than without them, by this much.
constexpr double kInstead = 0.5;
constexpr double kLikelier = 0.5;    // than not: what is told with another that is sure
constexpr double kToldRival = 0.03;  // a rival of less is not told
constexpr std::size_t kMostRivals = 9;

/// Of a visit: that none of these acts, by each of them given the others (Rao-Blackwell). Two of which one is
/// enough are each improbable beside the other: that says nothing against both.
double noneOf(const std::vector<int>& causes, const Visit& visit) {
  double sum = 0.0;
  for (const int one : causes) {
    const bool other = std::any_of(visit.acting.begin(), visit.acting.end(), [&](int acts) {
      return acts != one && std::find(causes.begin(), causes.end(), acts) != causes.end();
    });
    if (!other) sum += 1.0 - visit.inclusion[static_cast<std::size_t>(one)];
  }
  return sum / static_cast<double>(causes.size());
}

/// Probability that none of a slot acts where a cause does. What is sure beside one that is told is told with
/// it: two that explain a session together, or one in their place.
double noneBeside(int cause, const std::vector<double>& none, const PosteriorSample& sample) {
  double acts = 0.0, noneActs = 0.0;
  for (std::size_t i = 0; i < none.size(); ++i) {
    const std::vector<int>& acting = sample.visits[i].acting;
    if (std::find(acting.begin(), acting.end(), cause) == acting.end()) continue;
    acts += sample.weights[i];
    noneActs += none[i];
  }
  return acts > 0.0 ? noneActs / acts : 1.0;
}

}  // namespace

std::vector<Slot> slotsOf(const PosteriorSample& sample, const std::set<int>& doubted) {
  const int causes = static_cast<int>(sample.inclusion.size());
  std::vector<int> order(static_cast<std::size_t>(causes));
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return sample.inclusion[a] > sample.inclusion[b]; });
  std::vector<char> used(order.size(), 0);
  for (const int cause : doubted) used[static_cast<std::size_t>(cause)] = 1;
  std::vector<Slot> slots;
  const std::size_t n = sample.visits.size();
  for (const int leader : order) {
    if (used[leader] || sample.inclusion[leader] < kAsked) continue;
    Slot slot;
    slot.causes = {leader};
    std::vector<double> none(n);  // a visit: weight of it that none of the slot acts
    const auto weigh = [&] {
      for (std::size_t i = 0; i < n; ++i) none[i] = sample.weights[i] * noneOf(slot.causes, sample.visits[i]);
    };
    weigh();
    const auto left = [&] { return std::accumulate(none.begin(), none.end(), 0.0); };
    while (left() > 1.0 - kNamed && slot.causes.size() < kMostRivals) {
      int best = -1;
      double most = kOfTheRest * left();
      for (int c = 0; c < causes; ++c) {
        if (used[c] || sample.inclusion[c] < kRivalsFrom ||
            std::find(slot.causes.begin(), slot.causes.end(), c) != slot.causes.end())
          continue;
        double taken = 0.0;
        for (std::size_t i = 0; i < n; ++i) taken += none[i] * sample.visits[i].inclusion[c];
        const double beside = (sample.inclusion[c] - taken) / (1.0 - left());  // acts beside one of the slot
        if (beside > kInstead * taken / left()) continue;
        if (taken > most) most = taken, best = c;
      }
      if (best < 0) break;
      slot.causes.push_back(best);
      weigh();
    }
    slot.probability = 1.0 - left();
    const auto isSureBeside = [&](const Slot& told) {
      return told.named && noneBeside(told.causes.front(), none, sample) < 1.0 - kNamed;
    };
    slot.named = slot.probability >= kNamed || (sample.inclusion[leader] > kLikelier &&
                                                std::any_of(slots.begin(), slots.end(), isSureBeside));
    for (const int c : slot.causes) used[c] = slot.named ? 1 : used[c];
    used[leader] = 1;
    std::vector<int> told;
    for (const int c : slot.causes)
      if (c == leader || sample.inclusion[c] > kToldRival) told.push_back(c);
    slot.causes = told;
    for (const int c : told) slot.shares.push_back(sample.inclusion[c]);
    slots.push_back(std::move(slot));
  }
  return slots;
}

Acting shapeOf(const PosteriorSample& sample, const PosteriorProblem& problem, int cause) {
  std::map<int, std::pair<double, double>> ofShape;  // weight, weighted index of the size
  for (std::size_t i = 0; i < sample.visits.size(); ++i)
    for (const Acting& a : sample.visits[i].set)
      if (problem.shapes[static_cast<std::size_t>(a.shape)].cause == cause) {
        ofShape[a.shape].first += sample.weights[i];
        ofShape[a.shape].second += sample.weights[i] * a.size;
      }
  Acting best{-1, 0};
  double most = 0.0;
  for (const auto& [shape, sums] : ofShape)
    if (sums.first > most)
      most = sums.first, best = {shape, static_cast<int>(std::lround(sums.second / sums.first))};
  return best;
}

double odds(const PosteriorSample& sample, double probability) {
  const double known = 1.0 / (1.0 + static_cast<double>(sample.visits.size()));
  return kOfThisWorld * std::min(std::max(probability, 0.0), 1.0 - known * 0.1);
}

}  // namespace mm
