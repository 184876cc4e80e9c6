// The stages of a calibration before the fit: networks, statement, start.
#include <Eigen/Dense>
#include <algorithm>

#include "base/error.h"
#include "estimation/beam_start.h"
#include "estimation/calibration_stages.h"
#include "estimation/genetic_start.h"
#include "estimation/linear_start.h"
#include "estimation/nonlinear_start.h"

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
  for (std::size_t i = 0, count = starts.size(); i < count; ++i) {
    Eigen::VectorXd solved = starts[i];
    if (linearStart(problem, solved, fixed, inverse)) starts.push_back(solved);
  }
  found.x = bestRefined(problem, starts, fixed, s.sigma, s.weight, options.cancelled);
  return found;
}

}  // namespace mm
