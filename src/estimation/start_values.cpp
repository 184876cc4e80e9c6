// The stages of a calibration before the fit: networks, statement, start.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "base/cancel_scope.h"
#include "base/dense.h"
#include "base/error.h"
#include "estimation/calibration_stages.h"
#include "estimation/genetic_start.h"
#include "estimation/refine.h"
#include "estimation/thin_qr.h"
#include "estimation/whitened.h"

namespace mm {
namespace {

/// Where the gauge is judged: linear parameters at their own start values, whatever fit they come from.
/// Products of two small errors break a gauge there just enough for a value that means nothing.
Eigen::VectorXd gaugePoint(const Problem& problem, Eigen::VectorXd x) {
  const Model& model = problem.model();
  for (std::size_t e = 0; e < model.effects().size(); ++e) {
    const Effect& effect = *model.effects()[e];
    if (!effect.separable()) continue;
    for (int k = 0; k < effect.parameterCount(); ++k)
      x[model.offset(static_cast<int>(e)) + k] = effect.parameters()[static_cast<std::size_t>(k)].start;
  }
  return x;
}

Noise noiseToBeginWith(const Problem& problem, const CalibrateOptions& options) {
  Noise noise;
  const double declared =
      options.repeatability > 0 ? options.repeatability : problem.session().artifact.repeatability;
  if (declared > 0) {
    noise.from = "declared";
    noise.linear = declared;
    noise.linearStated = true;
  } else {
    bool stated = true;
    for (const ResidualRow& r : problem.rows()) stated &= r.statedSigma > 0.0;
    if (stated) noise.from = "declared", noise.linearStated = noise.angularStated = true;
  }
  return noise;
}

/// One linear step of everything that is not held; x takes it where that helps. @return sum of squares after.
double linearStep(const Problem& problem, Eigen::VectorXd& x, const std::vector<char>& held,
                  const Eigen::VectorXd& inverseSigma) {
  const WhitenedSystem system(problem, x, inverseSigma, held);
  const double cost = system.residuals.squaredNorm();
  if (system.free.empty() || !system.jacobian.allFinite() || !std::isfinite(cost)) return cost;
  const Eigen::VectorXd step = leastSquares(system.jacobian, -system.residuals);
  Eigen::VectorXd next = x;
  for (std::size_t i = 0; i < system.free.size(); ++i)
    next[system.free[i]] += step[static_cast<Eigen::Index>(i)] * system.scale[static_cast<Eigen::Index>(i)];
  const double after = WhitenedSystem(problem, next, inverseSigma, held).residuals.squaredNorm();
  if (!(after < cost)) return cost;
  x = next;
  return after;
}

/// Direction of a beam to begin with: a probe may be mounted the other way round than the chain says, from
/// where no descent finds back. Of directions all around, each with everything else refitted by one linear
/// step, the best goes into x, if it is much better than the one that is there.
void beamStart(const Problem& problem, Eigen::VectorXd& x, const std::vector<char>& fixed,
               const Eigen::VectorXd& inverseSigma) {
  constexpr double kMuchBetter = 0.25;  // of the sum of squares
  for (const UnitVector& beam : problem.unitVectors()) {
    std::vector<char> held = fixed;
    for (int k = 0; k < 3; ++k) held[static_cast<std::size_t>(beam.first + k)] = 1;
    Eigen::VectorXd own = x, best;
    double least = kMuchBetter * linearStep(problem, own, held, inverseSigma);
    for (int i = 0; i < 27; ++i) {
      if (i == 13) continue;
      CancelScope::check();
      Eigen::VectorXd trial = x;
      trial.segment<3>(beam.first) = Eigen::Vector3d(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1).normalized();
      const double cost = linearStep(problem, trial, held, inverseSigma);
      if (!(cost < least)) continue;
      least = cost;
      best = trial;
    }
    if (best.size() > 0) x = best;
  }
}

/// Start values for parameters that enter nonlinearly (a period, a time constant): each effect's searchStarts
/// are tried with everything else refitted by the linearised problem; the best, with its amplitudes, goes
/// into x. Effects whose nonlinear parameters have no searchStarts (formulas) are left alone.
/// @param cancelled ends the search with the best so far; may be empty.
void nonlinearStart(const Problem& problem, Eigen::VectorXd& x, const std::vector<char>& fixed,
                    const Eigen::VectorXd& inverseSigma, const std::function<bool()>& cancelled) {
  const Model& model = problem.model();
  for (int e = 0; e < static_cast<int>(model.effects().size()); ++e) {
    const Effect& effect = *model.effects()[e];
    std::vector<std::vector<double>> starts = effect.nature().searchStarts;
    if (starts.empty() || effect.separable()) continue;  // nothing to search where all amplitudes are linear
    const std::vector<int> nonlinear = effect.nature().nonlinear;
    for (const double length : effect.nature().fineWaves.lengths) starts.push_back({length});
    const int offset = model.offset(e);
    bool atZero = true;  // a start that the caller chose is kept
    for (int k = 0; k < effect.parameterCount(); ++k)
      if (std::find(nonlinear.begin(), nonlinear.end(), k) == nonlinear.end()) atZero &= x[offset + k] == 0.0;
    if (!atZero) continue;

    std::vector<char> without = fixed;  // everything else is refitted
    for (int k = 0; k < effect.parameterCount(); ++k) without[offset + k] = 1;
    for (int other = e + 1; other < static_cast<int>(model.effects().size()); ++other)
      if (!model.effects()[other]->nature().searchStarts.empty())
        for (int k = 0; k < model.effects()[other]->parameterCount(); ++k)
          without[model.offset(other) + k] = 1;
    const Linearisation at = linearise(problem, x);
    const WhitenedSystem system(at, inverseSigma, without);
    const Eigen::Index rows = system.jacobian.rows();
    const Eigen::MatrixXd q =
        orthonormalBasis(rows > system.jacobian.cols() ? system.jacobian : Eigen::MatrixXd(rows, 0));
    Eigen::VectorXd target = -system.residuals;
    target -= q * (q.transpose() * target);
    double best = -1.0;
    Eigen::VectorXd bestValues;
    for (const std::vector<double>& start : starts) {
      if (cancelled && cancelled()) break;
      std::vector<double> p;
      for (const Parameter& one : effect.parameters()) p.push_back(one.start);
      for (std::size_t k = 0; k < nonlinear.size(); ++k) p[nonlinear[k]] = start[k];
      const Eigen::MatrixXd all = at.effectColumns(effect, p);
      std::vector<int> linear;
      for (int k = 0; k < effect.parameterCount(); ++k)
        if (std::find(nonlinear.begin(), nonlinear.end(), k) == nonlinear.end() && !fixed[offset + k])
          linear.push_back(k);
      if (linear.empty()) break;
      Eigen::MatrixXd a = Eigen::MatrixXd::Zero(rows, linear.size());
      for (std::size_t k = 0; k < linear.size(); ++k)
        for (int i = 0; i < problem.rowCount(); ++i) {
          const double v = all(i, linear[k]) * effect.parameters()[linear[k]].scale * inverseSigma[i];
          if (inverseSigma[i] != 0.0 && std::isfinite(v)) a(i, static_cast<int>(k)) = v;
        }
      a -= q * (q.transpose() * a);
      const Eigen::VectorXd amplitudes = leastSquares(a, target);
      const double drop = target.squaredNorm() - (target - a * amplitudes).squaredNorm();
      if (!(drop > best) || !amplitudes.allFinite()) continue;
      best = drop;
      bestValues.resize(effect.parameterCount());
      for (int k = 0; k < effect.parameterCount(); ++k) bestValues[k] = p[k];
      for (std::size_t k = 0; k < linear.size(); ++k)
        bestValues[linear[k]] = amplitudes[static_cast<int>(k)] * effect.parameters()[linear[k]].scale;
    }
    if (best >= 0.0) x.segment(offset, effect.parameterCount()) = bestValues;
  }
}

/// Parameters of effects that enter nonlinearly, e.g. a rate inside an exponential of a formula; not the
/// angles of MMT, whose effect is as good as linear.
bool hasNonlinearParameters(const Problem& problem) {
  const auto& effects = problem.model().effects();
  return std::any_of(effects.begin(), effects.end(),
                     [](const EffectPtr& e) { return !e->separable() && !e->nature().nonlinear.empty(); });
}

/// The fixed unknowns, and the nonlinear parameters of the effects.
std::vector<char> fixedOrNonlinear(const Problem& problem, std::vector<char> held) {
  const Model& model = problem.model();
  for (std::size_t e = 0; e < model.effects().size(); ++e)
    for (const int k : model.effects()[e]->nature().nonlinear)
      held[static_cast<std::size_t>(model.offset(static_cast<int>(e)) + k)] = 1;
  return held;
}

/// Each candidate refined; the one that ends with the smallest residual. Of equal ones the first.
/// @param cancelled ends it with the best so far; may be empty.
Eigen::VectorXd bestRefined(const Statement& s, const std::vector<Eigen::VectorXd>& candidates,
                            const std::function<bool()>& cancelled) {
  const std::vector<char>& fixed = s.identifiability.fixed;
  Eigen::VectorXd best = candidates.front();
  constexpr double kEqual = 1e-9;  // of a sum of squares: two ways to one optimum end within rounding of it
  double least = std::numeric_limits<double>::infinity();
  const RefineProgress progress = [&](int, double) { return !(cancelled && cancelled()); };
  for (const Eigen::VectorXd& candidate : candidates) {
    if (cancelled && cancelled()) break;
    const Eigen::VectorXd x = refine(*s.problem, candidate, fixed, s.sigma, s.weight, progress).x;
    const double cost =
        WhitenedSystem(*s.problem, x, inverseOf(s.sigma, s.weight), fixed).residuals.squaredNorm();
    if (!(cost < (1.0 - kEqual) * least)) continue;
    least = cost;
    best = x;
  }
  return best;
}

}  // namespace

LearnedModel withNetworks(const Session& session, Model model, const CalibrateOptions& options,
                          const Eigen::VectorXd& given) {
  if (options.holdEffects || !hasToLearn(model)) return {std::move(model), given, {}};
  return learnNetworks(session, model, options, given);
}

Statement stated(const Session& session, const LearnedModel& learned, const CalibrateOptions& options,
                 Datum datum) {
  Statement s;
  s.problem = std::make_shared<const Problem>(session, learned.model, datum);
  const Problem& problem = *s.problem;
  const int parameters = problem.model().parameterCount();
  s.noise = noiseToBeginWith(problem, options);
  s.x = problem.start();
  if (learned.start.size() == parameters) s.x.head(parameters) = learned.start;
  s.sigma = problem.sigmas(s.noise.linear, s.noise.angular);
  s.weight = usableWeight(problem);
  std::vector<char> held;
  if (options.holdEffects) {
    held.assign(static_cast<std::size_t>(problem.unknownCount()), 0);
    std::fill(held.begin(), held.begin() + parameters, 1);
  }
  s.identifiability = identify(problem, gaugePoint(problem, s.x), inverseOf(s.sigma, s.weight), true, held);
  const int free = freeCount(s.identifiability.fixed);
  const int rows = static_cast<int>((s.weight.array() > 0.0).count()) + problem.priorCount() +
                   static_cast<int>(problem.unitVectors().size());
  if (rows < free)
    throw NumericalError(session.source + ": " + std::to_string(problem.rowCount()) +
                         " residuals cannot determine " + std::to_string(free) +
                         " unknowns; measure more, or leave effects out of the model");
  return s;
}

StartValues startValues(const Statement& s, const CalibrateOptions& options, bool given) {
  const Problem& problem = *s.problem;
  const std::vector<char>& fixed = s.identifiability.fixed;
  const Eigen::VectorXd inverse = inverseOf(s.sigma, s.weight);
  StartValues found;
  found.x = s.x;
  if (!given && !options.holdEffects) beamStart(problem, found.x, fixed, inverse);
  nonlinearStart(problem, found.x, fixed, inverse, options.cancelled);
  std::vector<Eigen::VectorXd> starts = {found.x};
  if (options.method != Method::kLeastSquares) {
    found.genetic = geneticStart(problem, found.x, fixed, s.sigma, s.weight, options);
    found.cancelled = found.genetic->stop == "cancelled";
    starts.push_back(found.x);
  }
  if (options.holdEffects || found.cancelled || !hasNonlinearParameters(problem)) return found;
  // from a start far away what enters linearly is half of the way that a descent would have to find
  const std::vector<char> held = fixedOrNonlinear(problem, fixed);
  for (std::size_t i = 0, count = starts.size(); i < count; ++i) {
    Eigen::VectorXd solved = starts[i];
    linearStep(problem, solved, held, inverse);
    if (solved != starts[i]) starts.push_back(solved);
  }
  found.x = bestRefined(s, starts, options.cancelled);
  return found;
}

}  // namespace mm
