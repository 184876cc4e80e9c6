#include "estimation/calibrate.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/parallel.h"
#include "estimation/calibration_stages.h"
#include "estimation/datum.h"

namespace mm {

Fit fitted(const Statement& statement, const StartValues& start, const CalibrateOptions& options) {
  const FitTask task{*statement.problem, statement.identifiability.fixed, options};
  Fit fit = fitFrom(task, start.x, statement.noise);
  const bool weighted = !options.rejectOutliers && options.weights.size() == statement.problem->rowCount();
  if (!weighted) return fitted(task, std::move(fit));
  fit.weight = options.weights;
  return refined(task, std::move(fit));
}

Identifiability lostAtTheFit(const Statement& statement, const Fit& fit) {
  Identifiability all = statement.identifiability;
  const Identifiability after = identify(*statement.problem, fit.x, inverseOf(fit.sigma, fit.weight), false);
  for (const LostDirection& l : after.lost)
    if (!all.fixed[l.fixedUnknown] && after.lost.size() > all.lost.size() && l.ofTheModel) {
      all.fixed[l.fixedUnknown] = 1;
      all.lost.push_back(l);
      --all.rank;
    }
  return all;
}

namespace {

/// The stages in their order. @param datum where the instrument's zeros count from.
CalibrationResult calibrateFrom(const Session& session, Model given, const CalibrateOptions& options,
                                const Eigen::VectorXd& values, Datum datum) {
  const LearnedModel learned = withNetworks(session, std::move(given), options, values);
  const Statement statement = stated(session, learned, options, datum);
  const StartValues start = startValues(statement, options, learned.start.size() > 0);
  Fit fit = fitted(statement, start, options);

  const Problem& problem = *statement.problem;
  const Model& model = problem.model();
  const bool mayBeLost = model.parameterCount() > 0 && !options.holdEffects && !fit.cancelled;
  const Identifiability known = mayBeLost ? lostAtTheFit(statement, fit) : statement.identifiability;

  if (options.progress) options.progress("uncertainty", 0.0);
  Uncertainty uncertainty = uncertaintyOf(problem, fit, known.fixed, options.whiteNoise);
  if (!options.holdEffects) uncertainty.takeFreedoms(networkUnknowns(model));
  if (learned.heldOutShift.size() > 0)
    addNetworkShift(problem, fit.x, learned.heldOutShift, uncertainty.heldOut);

  const RepeatabilityUsed repeatability = repeatabilityOf(problem, fit, uncertainty.dof);
  fit.noise = repeatability.noise;
  fit.sigma = problem.sigmas(fit.noise.linear, fit.noise.angular);

  CalibrationResult result;
  result.problem = statement.problem;
  result.method = options.method;
  result.seed = options.seed;
  result.genetic = start.genetic;
  result.identifiability = known;
  result.x = fit.x;
  result.residuals = fit.residuals;
  result.weight = fit.weight;
  result.sigma = fit.sigma;
  result.iterations = fit.iterations;
  result.converged = fit.converged;
  result.cancelled = start.cancelled || fit.cancelled;
  result.stop = fit.stop;
  result.heldOut = uncertainty.heldOut;
  result.covariance = uncertainty.covariance;
  result.drift = uncertainty.drift;
  result.centresStd = uncertainty.centresStd;
  result.radiiStd = uncertainty.radiiStd;
  result.repeatability = repeatability.value;
  result.repeatabilityFrom = repeatability.from;
  result.repeated = repeatability.repeated;
  result.figures = figuresOf(problem, fit, uncertainty, fit.sigma);
  result.before = nominalFigures(session, model, options, fit);
  for (int i = 0; i < problem.rowCount(); ++i)
    if (fit.weight[i] == 0.0 && problem.uses(problem.rows()[i].observation))
      result.outliers.push_back({i, fit.residuals[i]});
  return result;
}

}  // namespace

Method methodOf(const std::string& name) {
  if (name.empty() || name == "staged_mutation") return Method::kStagedMutation;
  if (name == "niching") return Method::kNiching;
  if (name == "least_squares") return Method::kLeastSquares;
  throw InputError("method '" + name + "' is not known; use staged_mutation, niching or least_squares");
}

std::string nameOf(Method method) {
  return method == Method::kStagedMutation ? "staged_mutation"
         : method == Method::kNiching      ? "niching"
                                           : "least_squares";
}

double CalibrationResult::std(int unknown) const {
  return std::sqrt(std::max(0.0, covariance(unknown, unknown)));
}

CalibrationResult calibrate(const Session& session, Model model, const CalibrateOptions& options,
                            const Eigen::VectorXd& given) {
  CalibrationResult result;
  Threads(options.threads).run([&] {
    // a law written as a formula says where it starts, and is believed unless the data contradict it
    const bool law = lawMayStateDatum(session, model);
    result = calibrateFrom(session, model, options, given, law ? Datum::kOfTheLaw : Datum::kFree);
    if (law && !result.cancelled && contradictsDatum(result))
      result = calibrateFrom(session, std::move(model), options, given, Datum::kFree);
  });
  return result;
}

}  // namespace mm
