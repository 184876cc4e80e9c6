#include "posterior/chain.h"

#include <algorithm>
#include <cmath>

namespace mm {
namespace {

/// Rate, shared by all causes, at which a cause is tried that does not look likely: without it two that are
/// likely only together would never meet.
constexpr double kTried = 0.3;
constexpr double kRedrawn = 0.5;  // rate at which the shape of one that acts is drawn again
constexpr int kNoiseEvery = 3;    // steps
constexpr int kModeEvery = 4;
constexpr int kTogetherEvery = 10;
constexpr double kNearlyAny = 0.1;  // power of the density by which a state of the noise is proposed
constexpr int kMostActing = 12;
constexpr double kNever = -1e300;  // log weight

/// log(1 + e^x)
double softPlus(double x) { return x > 0.0 ? x + std::log1p(std::exp(-x)) : std::log1p(std::exp(x)); }
double logAdd(double a, double b) { return std::max(a, b) + std::log1p(std::exp(-std::abs(a - b))); }

void insert(ActingSet& set, Acting a) {
  set.insert(std::lower_bound(set.begin(), set.end(), a,
                              [](const Acting& s, const Acting& t) { return s.shape < t.shape; }),
             a);
}

}  // namespace

void keepDenser(PlacesMet& met, const std::vector<int>& causes, const Place& place) {
  Place& kept = met.insert({causes, place}).first->second;
  if (place.density > kept.density) kept = place;
}

const Place& densestOf(const PlacesMet& met) {
  return std::max_element(met.begin(), met.end(),
                          [](const auto& a, const auto& b) { return a.second.density < b.second.density; })
      ->second;
}

PosteriorChain::PosteriorChain(const PosteriorProblem& problem, const NoisePool& pool,
                               std::size_t firstFitted, std::uint64_t seed, int number, int noise,
                               ActingSet set)
    : problem_(problem),
      pool_(pool),
      firstFitted_(firstFitted),
      random_(seed, "posterior chain " + std::to_string(number)),
      noise_(noise),
      set_(std::move(set)) {}

void PosteriorChain::beginAt(int noise, ActingSet set) {
  noise_ = noise;
  set_ = std::move(set);
}

int PosteriorChain::causeOf(Acting a) const {
  return problem_.shapes[static_cast<std::size_t>(a.shape)].cause;
}

int PosteriorChain::memberOf(const ActingSet& set, int cause) const {
  for (std::size_t k = 0; k < set.size(); ++k)
    if (causeOf(set[k]) == cause) return static_cast<int>(k);
  return -1;
}

std::vector<int> PosteriorChain::causesOf(const ActingSet& set) const {
  std::vector<int> causes;
  for (const Acting& a : set) causes.push_back(causeOf(a));
  return causes;
}

PosteriorChain::Rates PosteriorChain::ratesOf(const Conditionals& look, const ActingSet& set) const {
  // a cause in state s is flipped at (p(acts) + tried) / p(s), given all others
  const auto causes = static_cast<int>(look.logOdds.size());
  const double logTried = std::log(kTried / std::max(1, causes));
  Rates rates;
  for (int c = 0; c < causes; ++c) {
    const double odds = look.logOdds[static_cast<std::size_t>(c)];
    const double logActs = -softPlus(-odds);
    const double logState = memberOf(set, c) >= 0 ? logActs : -softPlus(odds);
    rates.logRate.push_back(logAdd(logActs, logTried) - logState);
  }
  for (std::size_t k = 0; k < set.size(); ++k) rates.logRate.push_back(std::log(kRedrawn));
  if (static_cast<int>(set.size()) >= kMostActing)  // full: what does not act stays out
    for (int c = 0; c < causes; ++c)
      if (memberOf(set, c) < 0) rates.logRate[static_cast<std::size_t>(c)] = kNever;
  if (rates.logRate.empty()) return rates;  // nothing is asked
  rates.logSum = logSumExp(Eigen::Map<const Eigen::ArrayXd>(rates.logRate.data(),
                                                            static_cast<Eigen::Index>(rates.logRate.size())));
  return rates;
}

std::size_t PosteriorChain::drawFrom(const std::vector<double>& logWeights) {
  const double most = *std::max_element(logWeights.begin(), logWeights.end());
  double sum = 0.0;
  for (const double w : logWeights) sum += std::exp(w - most);
  double left = random_.uniform() * sum;
  for (std::size_t i = 0; i < logWeights.size(); ++i) {
    left -= std::exp(logWeights[i] - most);
    if (left < 0.0) return i;
  }
  return static_cast<std::size_t>(std::max_element(logWeights.begin(), logWeights.end()) -
                                  logWeights.begin());
}

Acting PosteriorChain::drawShape(const Conditionals& look, int cause) {
  const Cause& c = problem_.causes[static_cast<std::size_t>(cause)];
  const auto part = look.logWeights.middleRows(c.first, c.end - c.first);
  const std::vector<double> weights(part.data(), part.data() + part.size());
  const auto drawn = static_cast<int>(drawFrom(weights));
  return {c.first + drawn / kSizes, drawn % kSizes};
}

void PosteriorChain::moveTo(ActingSet set, Look look, Rates rates) {
  set_ = std::move(set);
  look_ = std::move(look);
  rates_ = std::move(rates);
  remember();
}

void PosteriorChain::remember() { keepDenser(met_, causesOf(set_), {view().logDensity(set_), noise_, set_}); }

void PosteriorChain::stepSet() {
  if (rates_.logRate.empty()) return;
  const std::size_t move = drawFrom(rates_.logRate);
  ActingSet set = set_;
  if (move < look_->logOdds.size()) {
    const int cause = static_cast<int>(move), member = memberOf(set, cause);
    if (member >= 0)
      set.erase(set.begin() + member);
    else
      insert(set, drawShape(*look_, cause));
  } else {
    const std::size_t member = move - look_->logOdds.size();
    const int cause = causeOf(set[member]);
    set[member] = drawShape(*look_, cause);
  }
  Look look = view().look(set);
  Rates rates = ratesOf(*look, set);
  moveTo(std::move(set), std::move(look), std::move(rates));
}

void PosteriorChain::stepNoise() {
  if (pool_.size() < 2) return;
  // proposed by its density beside the set, or nearly any: drawn without regard to where the chain is
  std::vector<double> densities, proposed;
  for (const auto& v : pool_) densities.push_back(v->logDensity(set_));
  const double power = random_.uniform() < 0.5 ? kNearlyAny : 1.0;
  for (const double density : densities) proposed.push_back(power * density);
  const std::size_t to = drawFrom(proposed);
  if (static_cast<int>(to) == noise_) return;
  const auto from = static_cast<std::size_t>(noise_);
  Look look = pool_[to]->look(set_);
  Rates rates = ratesOf(*look, set_);
  const double logRatio = rates.logSum - rates_.logSum + (1.0 - power) * (densities[to] - densities[from]);
  if (std::log(1.0 - random_.uniform()) >= logRatio) return;
  noise_ = static_cast<int>(to);
  moveTo(set_, std::move(look), std::move(rates));
}

double PosteriorChain::logDrawn(const Conditionals& look, Acting a) const {
  return look.logWeights(a.shape, a.size) - look.logOdds[static_cast<std::size_t>(causeOf(a))];
}

double PosteriorChain::drawAsMode(const Mode& mode, const NoiseView& noise, const ActingSet* was,
                                  ActingSet& drawn) {
  for (const Acting& a : mode.set) insert(drawn, a);
  double log = 0.0;
  for (const Acting& a : mode.set) {
    const int cause = causeOf(a);
    const Look look = noise.look(drawn);
    const Acting now =
        was != nullptr ? (*was)[static_cast<std::size_t>(memberOf(*was, cause))] : drawShape(*look, cause);
    drawn.erase(drawn.begin() + memberOf(drawn, cause));
    insert(drawn, now);
    log += logDrawn(*look, now);
  }
  return log;
}

void PosteriorChain::stepMode() {
  if (modes_.size() < 2) return;
  const auto from = random_.below(static_cast<int>(modes_.size()));
  int other = random_.below(static_cast<int>(modes_.size()) - 1);
  if (other >= from) ++other;
  const Mode& here = modes_[static_cast<std::size_t>(from)];
  const Mode& mode = modes_[static_cast<std::size_t>(other)];
  ActingSet beside = set_;
  for (const Acting& a : here.set) {
    const int member = memberOf(beside, causeOf(a));
    if (member < 0) return;
    beside.erase(beside.begin() + member);
  }
  for (const Acting& a : mode.set)
    if (memberOf(beside, causeOf(a)) >= 0) return;
  if (beside.size() + mode.set.size() > kMostActing) return;
  const std::size_t drawn = drawFrom(mode.logNoise);
  const NoiseView& noise = *pool_[drawn];
  ActingSet to = beside, same = beside;
  const double there = mode.logNoise[drawn] + drawAsMode(mode, noise, nullptr, to);
  const double back = here.logNoise[static_cast<std::size_t>(noise_)] + drawAsMode(here, view(), &set_, same);
  Look look = noise.look(to);
  Rates rates = ratesOf(*look, to);
  const double logRatio =
      noise.logDensity(to) + rates.logSum + back - view().logDensity(set_) - rates_.logSum - there;
  if (std::log(1.0 - random_.uniform()) >= logRatio) return;
  noise_ = static_cast<int>(drawn);
  moveTo(std::move(to), std::move(look), std::move(rates));
}

void PosteriorChain::stepTogether() {
  if (static_cast<std::size_t>(noise_) < firstFitted_) return;
  const bool out = random_.uniform() < 0.5;
  if (out ? set_.empty() : static_cast<int>(set_.size()) >= kMostActing) return;
  ActingSet common = set_;
  if (out) common.erase(common.begin() + random_.below(static_cast<int>(common.size())));
  // a state of the noise, with none or one of the other causes: drawn by its density
  std::vector<Look> looks;
  std::vector<double> densities;  // a state: with none, then with each cause
  for (std::size_t v = firstFitted_; v < pool_.size(); ++v) {
    const double density = pool_[v]->logDensity(common);
    looks.push_back(pool_[v]->look(common));
    densities.push_back(density);
    for (const double odds : looks.back()->logOdds) densities.push_back(density + odds);
    for (const Acting& a : common)
      densities[densities.size() - looks.back()->logOdds.size() + causeOf(a)] = kNever;
  }
  const std::size_t each = 1 + looks.front()->logOdds.size(), drawn = drawFrom(densities);
  const std::size_t state = drawn / each, cause = drawn % each;
  if (cause > 0) insert(common, drawShape(*looks[state], static_cast<int>(cause) - 1));
  // on the way back one of those that act then is taken out
  const double before = static_cast<double>(set_.size()), after = static_cast<double>(common.size());
  const double logWays = after > before ? -std::log(after) : after < before ? std::log(before) : 0.0;
  const std::size_t to = firstFitted_ + state;
  Look look = pool_[to]->look(common);
  Rates rates = ratesOf(*look, common);
  if (std::log(1.0 - random_.uniform()) >= rates.logSum - rates_.logSum + logWays) return;
  noise_ = static_cast<int>(to);
  moveTo(std::move(common), std::move(look), std::move(rates));
}

/// What the members of the set do, in units of the white noise.
std::vector<double> PosteriorChain::sizesOfMembers() const {
  std::vector<double> sizes;
  const double white = std::sqrt(view().whiteVariance(set_));
  for (const Eigen::VectorXd& values : view().fit(set_).values) sizes.push_back(values.norm() / white);
  return sizes;
}

/// What belongs to another cause as real parts are made is there as often as not where that one acts, at its
/// usual share of what that one does; to be a cause of its own, it must be likelier than that.
double PosteriorChain::logPartOf(int cause, const std::vector<double>& sizes) const {
  const Cause& one = problem_.causes[static_cast<std::size_t>(cause)];
  double logPart = kNever;
  for (const auto& [whole, share] : one.partOf) {
    const int member = memberOf(set_, whole);
    if (member < 0) continue;
    Eigen::Index size = 0;
    (sizeGrid().log() - std::log(share * sizes[static_cast<std::size_t>(member)])).abs().minCoeff(&size);
    Eigen::ArrayXd logWeights(one.end - one.first);  // of its shapes, one as likely as another
    for (int s = one.first; s < one.end; ++s)
      logWeights[s - one.first] =
          look_->logWeights(s, size) - problem_.shapes[static_cast<std::size_t>(s)].logPrior[size];
    logPart = logAdd(logPart, logSumExp(logWeights) - one.logPriorOdds -
                                  std::log(static_cast<double>(one.end - one.first)));
  }
  return logPart;
}

void PosteriorChain::run(int steps, std::vector<Visit>* visits) {
  look_ = view().look(set_);
  rates_ = ratesOf(*look_, set_);
  remember();
  for (int step = 0; step < steps; ++step) {
    if (step % kNoiseEvery == 0) stepNoise();
    if (step % kModeEvery == kModeEvery - 1) stepMode();
    if (step % kTogetherEvery == kTogetherEvery / 2) stepTogether();
    if (visits != nullptr) {
      Visit v;
      v.logWeight = -rates_.logSum;
      v.noise = noise_;
      v.set = set_;
      const std::vector<double> sizes = sizesOfMembers();
      for (std::size_t c = 0; c < problem_.causes.size(); ++c) {
        const int cause = static_cast<int>(c);
        const double odds = look_->logOdds[c], part = logPartOf(cause, sizes);
        v.inclusion.push_back(std::exp(-softPlus(logAdd(0.0, part) - odds)));
        if (memberOf(set_, cause) >= 0 && odds > part) v.acting.push_back(cause);
      }
      visits->push_back(std::move(v));
    }
    stepSet();
  }
}

}  // namespace mm
