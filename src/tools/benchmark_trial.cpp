#include "tools/benchmark_trial.h"

#include <Eigen/Dense>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>

#include "diagnosis/residual_space.h"
#include "effects/registry.h"
#include "machine/error.h"
#include "machine/units.h"
#include "model/observed_domain.h"
#include "simulation/simulate.h"
#include "tools/benchmark_session.h"
#include "tools/formula_judge.h"

namespace mm {
namespace {

/// The base model fitted to a session, and the view in which residuals are compared.
struct Fitted {
  Fitted(const Session& session, const std::vector<EffectSpec>& base) : result(fit(session, base)) {
    result.problem->linearise(result.x);
  }
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

std::string sensorPair(const EffectSpec& s) {
  std::vector<std::string> names;
  if (const auto* v = s.find("sensors")) names = v->items;
  for (const char* key : {"warm", "cold"})
    if (!s.text(key).empty()) names.push_back(s.text(key));
  std::sort(names.begin(), names.end());
  std::string text;
  for (const auto& n : names) text += n + " ";
  return text;
}

/// Standard deviation of one measured value of the plan, m (rad where the plan measures angles).
double noiseOf(const Machine& machine, const Plan& plan, const NoiseSettings& noise) {
  double sum = 0.0;
  int count = 0;
  for (const PlanMove& m : plan.moves) {
    if (m.kind == MoveKind::kGo) continue;
    const bool rotary =
        m.kind == MoveKind::kDeviation && machine.joints()[m.joint].kind == JointKind::kRotary;
    const double one = m.kind == MoveKind::kTouch   ? noise.repeatability
                       : m.kind == MoveKind::kLaser ? std::hypot(noise.laser, noise.repeatability)
                       : rotary                     ? noise.referenceAngular
                                                    : noise.reference;
    sum += one * one;
    ++count;
  }
  return count > 0 ? std::sqrt(sum / count) : noise.repeatability;
}

/// What is hidden in an instrument; empty where the plan could not show it.
std::vector<HiddenSource> draw(const Machine& machine, const Plan& plan, const SimulationRequest& request) {
  try {
    return makeInstrument(machine, plan, request).hidden;
  } catch (const SourceNotShown&) {
    return {};
  }
}

Trial::Unknown judge(const Diagnosis& d, const HiddenSource& hidden, const Machine& machine, double noise) {
  Trial::Unknown unknown;
  unknown.truth = uncataloguedTruth(hidden, machine);
  if (d.formulas.empty()) return unknown;
  const FormulaResult& first = d.formulas[0];
  unknown.formula = first.effect.text("formula");
  unknown.direction = first.effect.text("direction");
  unknown.justTheVariables = justTheVariables(variablesOfFormula(unknown.formula), unknown.truth);
  unknown.rightDirection = unknown.direction == unknown.truth.direction;
  unknown.heldOut = first.heldOutAfter / noise;
  unknown.explained = unknown.heldOut <= 1.2;
  return unknown;
}

}  // namespace

/// The same cause: the same type, and the same axis, direction, sensor … wherever both name one. The shape
/// (degree, power, lag) is no part of the cause.
static bool sameCause(const EffectSpec& hidden, const EffectSpec& named) {
  if (hidden.type != named.type) return false;
  for (const char* key :
       {"axis", "of", "direction", "about", "sensor", "ball", "feature", "covariate", "joint", "with"}) {
    const std::string a = hidden.text(key), b = named.text(key);
    if (!a.empty() && !b.empty() && a != b &&
        !(hidden.type == "thermal_bending" && std::string(key) == "axis"))
      return false;
  }
  const std::string pa = sensorPair(hidden), pb = sensorPair(named);
  return pa.empty() || pb.empty() || pa == pb;
}

Trial runTrial(const Machine& machine, const TrialOptions& options, std::uint64_t seed) {
  const Plan plan = Plan::parse(options.planYaml, options.planSource, {}, machine);
  const Plan quiet = Plan::parse(withoutNoise(options.planYaml), options.planSource, {}, machine);
  const double noise =
      noiseOf(machine, plan, InstrumentSettings::parse(options.planYaml, options.planSource).noise);
  Trial trial;
  trial.seed = seed;

  const std::string any = options.uncatalogued ? "random_uncatalogued" : "random";
  std::vector<std::string> scaled;
  std::vector<EffectSpec> specs;
  bool ready = false;
  for (std::uint64_t attempt = 0; attempt < 50 && !ready; ++attempt) {
    SimulationRequest request;
    request.seed = seed * 1000 + attempt;
    for (int i = 0; i < options.effects; ++i)
      request.hide.push_back(options.only.empty() ? any : options.only[(seed + i) % options.only.size()]);
    const std::vector<HiddenSource> drawn = draw(machine, quiet, request);
    scaled.clear();
    specs.clear();
    std::vector<Eigen::VectorXd> lefts;
    bool apart = options.effects == 0 || !drawn.empty();
    SimulationRequest nothing;
    nothing.seed = request.seed;
    const Eigen::VectorXd clean = leftOf(simulate(machine, quiet, nothing), options.base);
    for (const HiddenSource& source : drawn) {
      std::string text = source.text();
      SimulationRequest alone;
      alone.seed = request.seed;
      double factor = 1.0;
      Eigen::VectorXd left;
      for (int pass = 0; pass < 2; ++pass) {  // the second pass makes up for what is not proportional
        HiddenSource resized = source;
        resized.numbers[0].value *= factor;
        text = resized.text();
        alone.hide = {text};
        left = leftOf(simulate(machine, quiet, alone), options.base);
        if (left.size() == clean.size()) left -= clean;
        const double rms = std::sqrt(left.squaredNorm() / std::max<Eigen::Index>(1, left.size()));
        if (!(rms > 1e-12)) {
          apart = false;
          break;
        }
        if (pass == 0) factor = options.size * noise / rms;
        if (factor > kLargestFactor) {
          apart = false;
          break;
        }
      }
      if (!apart) break;
      for (const Eigen::VectorXd& other : lefts)
        apart &= other.size() == left.size() && std::abs(other.dot(left)) < 0.8 * other.norm() * left.norm();
      for (const EffectSpec& other : specs) apart &= !sameCause(other, specOf(source));
      lefts.push_back(left);
      scaled.push_back(text);
      specs.push_back(specOf(source));
    }
    if (apart) {
      trial.seed = request.seed;
      ready = true;
    }
  }
  if (!ready) {
    trial.notShown = true;
    return trial;
  }
  trial.hidden = specs;
  trial.hiddenText = scaled;

  SimulationRequest request;
  request.seed = trial.seed;
  request.hide = scaled;
  const Simulation simulation = simulate(machine, plan, request);
  const Model model(machine, observedDomain(simulation.session), options.base);
  DiagnoseOptions diagnosing;
  diagnosing.seed = seed;
  const auto begin = std::chrono::steady_clock::now();
  const Diagnosis d = diagnose(simulation.session, model, diagnosing);
  trial.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  trial.verdict = d.verdict;

  const auto matches = [&](const CandidateResult& m, const EffectSpec& hidden, bool alsoConfusable) {
    if (sameCause(hidden, m.effect)) return true;
    return alsoConfusable && std::any_of(m.confusableWith.begin(), m.confusableWith.end(),
                                         [&](const Confusable& c) { return sameCause(hidden, c.effect); });
  };
  for (const CandidateResult& m : d.missing) {
    trial.found.push_back(m.effect.yaml());
    trial.falseClaims +=
        std::none_of(specs.begin(), specs.end(), [&](const EffectSpec& h) { return matches(m, h, true); });
  }
  for (const FormulaResult& f : d.formulas) trial.found.push_back(f.effect.yaml());
  for (const EffectSpec& h : specs) {
    trial.right += std::any_of(d.missing.begin(), d.missing.end(),
                               [&](const CandidateResult& m) { return matches(m, h, true); });
    trial.exact += std::any_of(d.missing.begin(), d.missing.end(),
                               [&](const CandidateResult& m) { return matches(m, h, false); });
  }
  trial.firstRight = !d.missing.empty() && std::any_of(specs.begin(), specs.end(), [&](const EffectSpec& h) {
    return matches(d.missing[0], h, true);
  });
  trial.heldOutEnd = (!d.formulas.empty()  ? d.formulas[0].heldOutAfter
                      : !d.missing.empty() ? d.missing.back().heldOutAfter
                                           : d.base.figures.heldOutRms) /
                     noise;

  if (options.uncatalogued && !simulation.hidden.empty()) {
    trial.unknown = judge(d, simulation.hidden[0], machine, noise);
    trial.unknown.byCatalogue = d.verdict != Verdict::kUnknownEffect && trial.heldOutEnd <= 1.05;
    return trial;
  }

  // what people do by hand: rank the candidates by their correlation with the residual
  std::vector<std::pair<double, EffectSpec>> ranked;
  const ResidualSpace space(d.base);
  for (const CandidateResult& c : d.candidates) {
    const EffectPtr effect = createEffect(c.effect, model.domain());
    std::vector<double> p;
    for (const Parameter& q : effect->parameters()) p.push_back(q.start);
    const std::vector<int> nonlinear = effect->nonlinearParameters();
    std::vector<std::vector<double>> starts = effect->searchStarts();
    if (starts.empty()) starts.push_back({});
    double best = 0.0;
    for (const auto& start : starts) {
      for (std::size_t k = 0; k < nonlinear.size(); ++k) p[nonlinear[k]] = start[k];
      const Eigen::MatrixXd columns = space.columns(*effect, p);
      for (int k = 0; k < columns.cols(); ++k)
        if (std::find(nonlinear.begin(), nonlinear.end(), k) == nonlinear.end() && columns.col(k).norm() > 0)
          best = std::max(best, std::abs(columns.col(k).dot(space.target())) / columns.col(k).norm());
    }
    ranked.emplace_back(-best, c.effect);
  }
  std::stable_sort(ranked.begin(), ranked.end(), [](auto& a, auto& b) { return a.first < b.first; });
  for (std::size_t i = 0; i < ranked.size() && i < specs.size(); ++i)
    trial.byCorrelation.push_back(ranked[i].second.yaml());
  for (const EffectSpec& h : specs)
    for (std::size_t i = 0; i < ranked.size() && i < specs.size(); ++i)
      if (sameCause(h, ranked[i].second)) {
        ++trial.rightByCorrelation;
        break;
      }
  return trial;
}

}  // namespace mm
