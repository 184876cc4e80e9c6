#include "benchmark_trial.h"

#include <Eigen/Dense>
#include <algorithm>
#include <chrono>
#include <cmath>

#include "base/error.h"
#include "base/units.h"
#include "benchmark_session.h"
#include "effects/linearity.h"
#include "effects/registry.h"
#include "estimation/residual_space.h"
#include "model/observed_domain.h"
#include "simulation/simulate.h"

namespace mm {
namespace {

/// The base model fitted to a session, and the view in which residuals are compared.
struct Fitted {
  Fitted(const Session& session, const std::vector<EffectSpec>& base) : result(fit(session, base)) {}
  static CalibrationResult fit(const Session& session, const std::vector<EffectSpec>& base) {
    CalibrateOptions options;
    options.method = Method::kLeastSquares;
    options.rejectOutliers = false;
    return calibrate(session, Model(session.machine, observedDomain(session), base), options);
  }
  CalibrationResult result;
};

/// Residuals by observation row, zero where a session has no such row; the same plan gives the same rows.
Eigen::VectorXd leftOf(const Simulation& s, const std::vector<EffectSpec>& base) {
  return Fitted(s.session, base).result.residuals;
}

/// The hidden source in the catalogue's words.
EffectSpec specOf(const HiddenSource& source) {
  EffectSpec spec(source.type);
  for (const auto& [key, value] : source.keys) spec.set(key, value);
  return spec;
}

/// An effect that would have to be made larger than this is one that the session hardly shows.
constexpr double kLargestFactor = 30.0;

/// A session of this seed that may hide all that is judged.
SimulationRequest sessionOf(std::uint64_t seed, std::vector<std::string> hide = {}) {
  SimulationRequest request;
  request.kinds = &judgedKinds();
  request.seed = seed;
  request.hide = std::move(hide);
  return request;
}

/// What is hidden in an instrument; empty where the plan could not show it.
std::vector<HiddenSource> draw(const Machine& machine, const Plan& plan, const SimulationRequest& request) {
  try {
    return makeInstrument(machine, plan, request).hidden;
  } catch (const SourceNotShown&) {
    return {};
  }
}

/// What was drawn for a trial.
struct Drawn {
  std::uint64_t seed = 0;
  std::vector<std::string> texts;      // with their sizes
  std::vector<EffectSpec> specs;       // in the catalogue's words
  std::vector<Eigen::VectorXd> lefts;  // what refit leaves of each, a data row
  Eigen::VectorXd clean;               // what it leaves with nothing hidden
};

/// Gives a source its size. @return false where the session hardly shows it.
bool resize(const HiddenSource& source, const Machine& machine, const Plan& quiet,
            const TrialOptions& options, double noise, Drawn& drawn) {
  double factor = 1.0;
  Eigen::VectorXd left;
  std::string text;
  for (int pass = 0; pass < 2; ++pass) {  // the second pass makes up for what is not proportional
    HiddenSource resized = source;
    resized.numbers[0].value *= factor;
    text = resized.text();
    left = leftOf(simulate(machine, quiet, sessionOf(drawn.seed, {text})), options.base);
    if (left.size() == drawn.clean.size()) left -= drawn.clean;
    const double rms = std::sqrt(left.squaredNorm() / std::max<Eigen::Index>(1, left.size()));
    constexpr double kNoError = 1e-12;  // m or rad: the plan does not show it
    if (!(rms > kNoError)) return false;
    if (pass == 0) factor = options.size * noise / rms;
    if (factor > kLargestFactor) return false;
  }
  drawn.texts.push_back(text);
  drawn.specs.push_back(specOf(source));
  drawn.lefts.push_back(left);
  return true;
}

std::optional<Drawn> drawEffects(const Machine& machine, const Plan& quiet, const TrialOptions& options,
                                 double noise, std::uint64_t seed) {
  for (std::uint64_t attempt = 0; attempt < 50; ++attempt) {
    SimulationRequest request = sessionOf(seed * 1000 + attempt);
    for (int i = 0; i < options.effects; ++i)
      request.hide.push_back(options.only.empty() ? "random"
                                                  : options.only[(seed + i) % options.only.size()]);
    const std::vector<HiddenSource> sources = draw(machine, quiet, request);
    if (options.effects > 0 && sources.empty()) continue;
    Drawn drawn;
    drawn.seed = request.seed;
    drawn.clean = leftOf(simulate(machine, quiet, sessionOf(drawn.seed)), options.base);
    const bool usable = std::all_of(sources.begin(), sources.end(), [&](const HiddenSource& source) {
      const EffectSpec spec = specOf(source);
      return std::none_of(drawn.specs.begin(), drawn.specs.end(),
                          [&](const EffectSpec& other) { return sameCause(other, spec); }) &&
             resize(source, machine, quiet, options, noise, drawn);
    });
    if (usable) return drawn;
  }
  return std::nullopt;
}

/// What people do by hand: rank the candidates by their correlation with the residual.
void rankByCorrelation(const Diagnosis& d, const Domain& domain, Trial& trial) {
  std::vector<std::pair<double, EffectSpec>> ranked;
  const ResidualSpace space(d.base);
  for (const CandidateResult& c : d.candidates) {
    const EffectPtr effect = createEffect(c.effect, domain);
    const std::vector<int> linear = linearParameters(*effect);
    std::vector<std::vector<double>> starts = effect->nature().searchStarts;
    if (starts.empty()) starts.push_back({});
    double best = 0.0;
    for (const auto& start : starts) {
      const Eigen::MatrixXd columns = space.columns(*effect, startsAt(*effect, start));
      for (const int k : linear)
        if (columns.col(k).norm() > 0)
          best = std::max(best, std::abs(columns.col(k).dot(space.target())) / columns.col(k).norm());
    }
    ranked.emplace_back(-best, c.effect);
  }
  std::stable_sort(ranked.begin(), ranked.end(), [](auto& a, auto& b) { return a.first < b.first; });
  if (ranked.size() > trial.hidden.size()) ranked.resize(trial.hidden.size());
  for (const auto& [correlation, effect] : ranked) trial.byCorrelation.push_back(effect.yaml());
  for (const EffectSpec& h : trial.hidden)
    trial.rightByCorrelation += std::any_of(ranked.begin(), ranked.end(),
                                            [&h = h](const auto& one) { return sameCause(h, one.second); });
}

}  // namespace

Oracle oracleOf(const Machine& machine, const TrialOptions& options, int sessions, std::uint64_t seed,
                const ProgressCallback& progress) {
  const Plan plan = Plan::parse(options.planYaml, options.planSource, {}, machine);
  const Plan quiet = Plan::parse(withoutNoise(options.planYaml), options.planSource, {}, machine);
  Eigen::MatrixXd noise;
  for (int k = 0; k < sessions; ++k) {
    if (progress) progress(static_cast<double>(k) / sessions);
    SimulationRequest request;
    request.seed = seed * 1000 + 999 + 1000000007ULL * (static_cast<std::uint64_t>(k) + 1);  // of no trial
    const Eigen::VectorXd clean = leftOf(simulate(machine, quiet, request), options.base);
    request.rough = options.rough;
    const Eigen::VectorXd left = leftOf(simulate(machine, plan, request), options.base);
    if (k == 0) noise.resize(left.size(), sessions);
    if (left.size() != noise.rows() || clean.size() != noise.rows())
      throw InputError(options.planSource +
                       ": --oracle needs sessions in which every move measures; this plan misses some");
    noise.col(k) = left - clean;
  }
  return Oracle(noise);
}

Trial runTrial(const Machine& machine, const TrialOptions& options, std::uint64_t seed,
               const Oracle* oracle) {
  const Plan plan = Plan::parse(options.planYaml, options.planSource, {}, machine);
  const Plan quiet = Plan::parse(withoutNoise(options.planYaml), options.planSource, {}, machine);
  const NoiseSettings errors = InstrumentSettings::parse(options.planYaml, options.planSource).noise;
  const double noise = repeatabilityOf(machine, plan, errors).all;
  Trial trial;
  trial.seed = seed;
  const std::optional<Drawn> drawn = drawEffects(machine, quiet, options, noise, seed);
  trial.notShown = !drawn;
  if (!drawn) return trial;
  trial.seed = drawn->seed;
  trial.hidden = drawn->specs;
  trial.hiddenText = drawn->texts;

  SimulationRequest request = sessionOf(drawn->seed, drawn->texts);
  request.rough = options.rough;
  const Simulation simulation = simulate(machine, plan, request);
  const Model model(machine, observedDomain(simulation.session), options.base);
  if (oracle != nullptr && drawn->lefts.size() == 1) {
    const Eigen::VectorXd left = leftOf(simulation, options.base);
    trial.oracleGain =
        left.size() == drawn->clean.size() ? oracle->gain(drawn->lefts[0], left - drawn->clean) : 0.0;
  }
  DiagnoseOptions diagnosing;
  diagnosing.seed = seed;
  const auto begin = std::chrono::steady_clock::now();
  const Diagnosis d = diagnose(simulation.session, model, diagnosing);
  trial.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  trial.verdict = d.verdict;

  trial.score = scoreOf(d, trial.hidden);
  constexpr double kLikely = 0.2;
  for (const CandidateResult& c : d.candidates)
    if (c.odds > kLikely)
      trial.said.emplace_back(c.odds,
                              std::any_of(trial.hidden.begin(), trial.hidden.end(),
                                          [&](const EffectSpec& h) { return sameCause(h, c.effect); }));
  for (const CandidateResult& m : d.missing) trial.found.push_back(m.effect.yaml());
  for (const ProfileResult& p : d.profiles) trial.found.push_back(p.effect.yaml());
  for (const FormulaResult& f : d.formulas) trial.found.push_back(f.effect.yaml());
  const double base = d.angular ? d.base.figures.heldOutRmsAngular : d.base.figures.heldOutRms;
  trial.heldOutEnd = (d.heldOut > 0.0 ? d.heldOut : base) / noise;
  if (options.uncatalogued && !simulation.hidden.empty()) {
    trial.unknown = judge(d, uncataloguedTruth(simulation.hidden[0], machine), noise);
    trial.byCatalogue = d.verdict != Verdict::kUnknownEffect && trial.heldOutEnd <= 1.05;
  } else if (d.base.problem) {
    rankByCorrelation(d, model.domain(), trial);
  }
  return trial;
}

}  // namespace mm
