#include "posterior/sample.h"

#include <algorithm>
#include <cmath>

#include "base/parallel.h"

namespace mm {
namespace {

constexpr double kFarBehind = 7.0;      // nats, 1000 to 1
constexpr std::size_t kMostModes = 40;  // more are met less often than they cost
constexpr double kWorthAChain = 20.0;  // nats that a start may be behind: its noise and sizes are not its own

class Sampler {
 public:
  Sampler(const PosteriorProblem& problem, const SampleOptions& options)
      : problem_(problem),
        options_(options),
        packed_(std::make_shared<const PackedColumns>(problem.columns)),
        visits_(static_cast<std::size_t>(options.chains)) {}

  PosteriorSample run(const Eigen::VectorXd& variance) {
    for (NoiseState& s : plainStates(problem_, variance)) add(std::move(s));
    const std::size_t plain = pool_.size();
    addFitted(fittedBeside(problem_, {}, pool_.front()->state()));
    addFitted(fittedBeside(problem_, {}, pool_[densest({})]->state()));
    for (const PosteriorStart& s : options_.starts) addFitted(s.noise);
    // from the two ends: no noise but the white, and the noise that explains most alone
    for (int c = 0; c < options_.chains; ++c) {
      const int given = static_cast<int>(options_.starts.size()) - 1 - c;
      const ActingSet set = given >= 0 ? options_.starts[static_cast<std::size_t>(given)].set : ActingSet();
      const int noise = given < 0 && c % 2 == 0 ? 0 : static_cast<int>(densest(set));
      chains_.emplace_back(problem_, pool_, plain, options_.seed, c, noise, set);
    }
    for (int fit = 0; fit < options_.fits; ++fit) {
      advance(options_.warmUp, false);
      fitBesideWhatWasFound();
    }
    advance(options_.warmUp, false);
    leaveWhatIsFarBehind();
    meetTheOtherStarts(plain);
    PosteriorSample out;
    for (int round = 0; round < options_.mostRounds && !out.settled; ++round) {
      if ((round & (round - 1)) == 0) setModes();  // again where as much again was drawn
      advance(options_.steps, true);
      read(out);
    }
    out.pool = pool_;
    meetWhatChainsMet(chains_);
    out.best = densestOf(met_).set;
    out.bestNoise = densestOf(met_).noise;
    return out;
  }

 private:
  void add(NoiseState state) {
    for (const auto& v : pool_)
      if (v->state().resembles(state)) return;
    pool_.push_back(std::make_shared<NoiseView>(problem_, std::move(state), packed_));
  }

  void addFitted(NoiseState state) {
    add(ofOtherKernel(state));
    add(std::move(state));
  }

  std::size_t densest(const ActingSet& set) const {
    std::size_t best = 0;
    for (std::size_t v = 1; v < pool_.size(); ++v)
      if (pool_[v]->logDensity(set) > pool_[best]->logDensity(set)) best = v;
    return best;
  }

  /// A chain that has met nothing nearly as dense as another has not come to where the posterior is: it
  /// begins there again.
  void leaveWhatIsFarBehind() {
    meetWhatChainsMet(chains_);
    const Place& densest = densestOf(met_);
    for (PosteriorChain& c : chains_)
      if (c.best().density < densest.density - kFarBehind) c.beginAt(densest.noise, densest.set);
  }

  void meetWhatChainsMet(const std::vector<PosteriorChain>& chains) {
    for (const PosteriorChain& c : chains)
      for (const auto& [causes, place] : c.met()) keepDenser(met_, causes, place);
  }

  /// What chains that began at the other starts would meet.
  void meetTheOtherStarts(std::size_t plain) {
    const double least = densestOf(met_).density - kWorthAChain;
    std::vector<PosteriorChain> chains;
    for (const PosteriorStart& s : options_.starts) {
      const std::size_t noise = densest(s.set);
      if (pool_[noise]->logDensity(s.set) < least) continue;
      const int number = static_cast<int>(chains_.size() + chains.size());
      chains.emplace_back(problem_, pool_, plain, options_.seed, number, static_cast<int>(noise), s.set);
    }
    parallelFor(chains.size(), [&](std::size_t c) { chains[c].run(options_.warmUp, nullptr); });
    meetWhatChainsMet(chains);
  }

  /// Chains jump between the densest sets that any of them has met.
  void setModes() {
    meetWhatChainsMet(chains_);
    std::vector<Place> places;
    for (const auto& [causes, place] : met_) places.push_back(place);
    std::stable_sort(places.begin(), places.end(),
                     [](const Place& a, const Place& b) { return a.density > b.density; });
    std::vector<Mode> modes;
    for (const Place& place : places)
      if (modes.size() < kMostModes && place.density > places.front().density - kFarBehind)
        modes.push_back({place.set, logNoiseBeside(place.set)});
    for (PosteriorChain& c : chains_) c.setModes(modes);
  }

  /// Log probability of each state of the pool beside a set.
  std::vector<double> logNoiseBeside(const ActingSet& set) const {
    std::vector<double> log;
    for (const auto& view : pool_) log.push_back(view->logDensity(set));
    const double sum =
        logSumExp(Eigen::Map<const Eigen::ArrayXd>(log.data(), static_cast<Eigen::Index>(log.size())));
    for (double& density : log) density -= sum;
    return log;
  }

  void fitBesideWhatWasFound() {
    std::vector<NoiseState> fitted(chains_.size());
    for (std::size_t c = 0; c < chains_.size(); ++c) {
      const ActingSet& set = chains_[c].best().set;
      fitted[c] = fittedBeside(problem_, set, pool_[densest(set)]->state());
    }
    for (NoiseState& s : fitted) addFitted(std::move(s));
  }

  void advance(int steps, bool keep) {
    parallelFor(chains_.size(), [&](std::size_t c) { chains_[c].run(steps, keep ? &visits_[c] : nullptr); });
  }

  void read(PosteriorSample& out) const {
    const std::size_t causes = problem_.causes.size();
    std::vector<std::vector<double>> ofChain;
    out.visits.clear();
    out.weights.clear();
    for (const auto& all : visits_) {
      // of more than one round the first half is the way from where the chain began
      const std::size_t first = all.size() > static_cast<std::size_t>(options_.steps) ? all.size() / 2 : 0;
      double most = -1e300, sum = 0.0;
      for (std::size_t i = first; i < all.size(); ++i) most = std::max(most, all[i].logWeight);
      for (std::size_t i = first; i < all.size(); ++i) sum += std::exp(all[i].logWeight - most);
      std::vector<double> inclusion(causes, 0.0);
      for (std::size_t i = first; i < all.size(); ++i) {
        const double weight = std::exp(all[i].logWeight - most) / sum;
        for (std::size_t c = 0; c < causes; ++c) inclusion[c] += weight * all[i].inclusion[c];
        out.visits.push_back(all[i]);
        out.weights.push_back(weight / static_cast<double>(visits_.size()));
      }
      ofChain.push_back(std::move(inclusion));
    }
    out.inclusion.assign(causes, 0.0);
    out.disagreement = 0.0;
    for (std::size_t c = 0; c < causes; ++c) {
      double low = 1.0, high = 0.0;
      for (const auto& inclusion : ofChain) {
        out.inclusion[c] += inclusion[c] / static_cast<double>(ofChain.size());
        low = std::min(low, inclusion[c]);
        high = std::max(high, inclusion[c]);
      }
      out.disagreement = std::max(out.disagreement, high - low);
    }
    out.settled = out.disagreement <= kAgree;
  }

  const PosteriorProblem& problem_;
  const SampleOptions& options_;
  std::shared_ptr<const PackedColumns> packed_;
  NoisePool pool_;
  std::vector<PosteriorChain> chains_;
  std::vector<std::vector<Visit>> visits_;
  PlacesMet met_;  // by any chain
};

}  // namespace

PosteriorSample samplePosterior(const PosteriorProblem& problem, const Eigen::VectorXd& variance,
                                const SampleOptions& options) {
  return Sampler(problem, options).run(variance);
}

}  // namespace mm
