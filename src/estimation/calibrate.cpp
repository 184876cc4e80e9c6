#include "estimation/calibrate.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/units.h"
#include "estimation/beam_start.h"
#include "estimation/datum.h"
#include "estimation/fitter.h"
#include "estimation/folds.h"
#include "estimation/genetic_start.h"
#include "estimation/linear_start.h"
#include "estimation/network_learning.h"
#include "estimation/noise_rows.h"
#include "estimation/nonlinear_start.h"
#include "estimation/polish.h"
#include "estimation/robust.h"
#include "estimation/thin_qr.h"
#include "estimation/whitened.h"
#include "thermal/thermal_network.h"

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

ResidualFigures figuresOf(const Problem& problem, const Eigen::VectorXd& r, const Eigen::VectorXd& heldOut,
                          const Eigen::VectorXd& sigma, const Eigen::VectorXd& weight, double dof,
                          double priorChi2) {
  ResidualFigures f;
  f.rms = rmsOf(problem, r, weight, false);
  f.rmsAngular = rmsOf(problem, r, weight, true);
  f.heldOutRms = rmsOf(problem, heldOut, weight, false);
  f.heldOutRmsAngular = rmsOf(problem, heldOut, weight, true);
  double chi2 = priorChi2;
  for (int i = 0; i < r.size(); ++i)
    if (weight[i] > 0.0) chi2 += weight[i] * r[i] * r[i] / (sigma[i] * sigma[i]);
  f.degreesOfFreedom = std::max(0, static_cast<int>(dof));
  f.chi2PerDof = dof > 0 ? chi2 / dof : 0.0;
  return f;
}

/// Held-out residuals (m, rad), covariance (SI) and degrees of freedom at x.
struct Summary {
  Eigen::VectorXd heldOut;
  Eigen::MatrixXd covariance;
  double dof = 0.0, priorChi2 = 0.0;

  /// Degrees of freedom that other unknowns take; at least one stays. The covariance grows with it.
  void takeFreedoms(int taken) {
    if (taken <= 0 || dof <= 0.0) return;
    const double left = std::max(1.0, dof - taken);
    covariance *= dof / left;
    dof = left;
  }
};

/// How the covariance of the unknowns is larger where the noise has memory, and what that memory is.
struct Memory {
  NoiseFitResult fit;
  LinearisedRows rows;
};

/// The noise of what a fit has left. @param q orthonormal columns of the fit, the last `shared` of which are
/// those of unknowns that all rows share.
Memory memoryOf(Problem& problem, const Fitter& fit, const WhitenedSystem& system, const Eigen::MatrixXd& q,
                int shared) {
  constexpr int kMostRows = 1500, kMostColumns = 40;
  problem.linearise(fit.x);
  std::vector<int> used;
  for (int i = 0; i < problem.rowCount(); ++i)
    if (fit.weight[i] > 0.0) used.push_back(i);
  const int n = static_cast<int>(used.size()), columns = std::min(shared, kMostColumns);
  RowMatrix base(n, columns);
  Eigen::VectorXd target(n);
  for (int i = 0; i < n; ++i) {
    base.row(i) = q.row(used[i]).tail(columns);
    target[i] = system.residuals[used[i]];
  }
  Memory memory;
  memory.rows = noiseRows(problem, used, fit.sigma, std::move(target), std::move(base));
  NoiseModel white;
  white.variance = Eigen::VectorXd::Ones(n);

  NoiseFitOptions options;
  options.driftPrice = 3.0;  // coverage under drift is what it should be with it, and too small with 5
  memory.fit = fitNoise(memory.rows.rows, {}, white, options, kMostRows);
  return memory;
}

/// @param drift not null: the covariance is that of noise with the memory that is found in the residuals,
/// which it tells.
Summary summarise(Problem& problem, const Fitter& fit, const std::vector<char>& fixed,
                  std::vector<Drift>* drift) {
  Summary s;
  const WhitenedSystem system(problem, fit.x, inverseOf(fit.sigma, fit.weight), fixed);
  const int columns = static_cast<int>(system.free.size()), rows = static_cast<int>(system.jacobian.rows());
  const int data = problem.rowCount();
  for (int i = data; i < rows; ++i) s.priorChi2 += system.residuals[i] * system.residuals[i];
  s.dof = static_cast<double>((fit.weight.array() > 0.0).count()) + (rows - data) - columns;
  s.covariance.setZero(problem.unknownCount(), problem.unknownCount());
  Eigen::MatrixXd q(rows, 0);
  if (columns > 0 && rows >= columns) {
    ThinQr qr = thinQr(system.jacobian, localBlocks(problem, system.jacobian, system.free), true);
    q = std::move(qr.q);
    Eigen::MatrixXd inverseR(columns, columns);  // its rows in the order of the unknowns
    const Eigen::MatrixXd inverse =
        qr.r.triangularView<Eigen::Upper>().solve(Eigen::MatrixXd::Identity(columns, columns));
    for (int k = 0; k < columns; ++k) inverseR.row(qr.order[k]) = inverse.row(k);
    const double chi2 = system.residuals.squaredNorm();
    const double variance = s.dof > 0 ? chi2 / s.dof : 1.0;
    Eigen::MatrixXd c = variance * inverseR * inverseR.transpose();
    constexpr int kFewestRows = 40;  // fewer do not tell a memory
    if (drift != nullptr && s.dof >= kFewestRows) {
      int local = 0;
      for (const LocalBlock& b : localBlocks(problem, system.jacobian, system.free))
        local += static_cast<int>(b.columns.size());
      const Memory memory = memoryOf(problem, fit, system, q, columns - local);
      if (!memory.fit.noise.drift.empty()) {
        // of least squares under noise V: R^-1 Q' V Q R^-T
        RowMatrix all(static_cast<Eigen::Index>(memory.rows.rows.time.size()), columns);
        for (int i = 0, k = 0; i < data; ++i)
          if (fit.weight[i] > 0.0) all.row(k++) = q.row(i);
        const TimeWhitener whitener(memory.rows.rows.time, memory.rows.rows.factors,
                                    memory.fit.noise.variance, memory.fit.noise.drift);
        Eigen::MatrixXd middle = Eigen::MatrixXd(all.transpose() * whitener.covarianceTimes(all));
        const auto priors = q.bottomRows(rows - data);
        middle += priors.transpose() * priors;
        middle *= memory.fit.white * memory.fit.white;
        c = inverseR * middle * inverseR.transpose();
        for (const DriftTerm& t : memory.fit.noise.drift)
          drift->push_back({memory.rows.directions[t.direction],
                            t.ratio * memory.fit.white * memory.rows.directionScale[t.direction], t.tau});
      }
    }
    for (int i = 0; i < columns; ++i)
      for (int j = 0; j < columns; ++j)
        s.covariance(system.free[i], system.free[j]) = c(i, j) * system.scale[i] * system.scale[j];
  }
  s.heldOut = heldOutResiduals(q, system.residuals, makeFolds(problem));
  for (int i = 0; i < data; ++i) s.heldOut[i] *= fit.sigma[i];
  return s;
}

/// Constants of the networks, which take degrees of freedom too: they are learned from the same residuals.
int networkUnknowns(const Model& model) {
  int count = 0;
  for (const LearnedNetwork& network : model.domain().networks)
    if (network.active) count += networkFromNumbers(network.numbers)->unknowns();
  return count;
}

/// Held-out residuals are those of networks that were learned without the rows that they are judged on.
void addNetworkShift(Problem& problem, const Eigen::VectorXd& x, const Eigen::MatrixXd& shift,
                     Eigen::VectorXd& heldOut) {
  problem.linearise(x);
  const Model& model = problem.model();
  Eigen::VectorXd gain = Eigen::VectorXd::Zero(shift.cols());
  for (std::size_t e = 0; e < model.effects().size(); ++e)
    if (model.effects()[e]->learned() && model.effects()[e]->parameterCount() == 1)
      gain[model.domain().findJoint(model.effects()[e]->spec().text("axis"))] =
          x[model.offset(static_cast<int>(e))];
  const ErrorLayout layout = model.machine().layout();
  for (int i = 0; i < problem.rowCount(); ++i)
    for (int j = 0; j < static_cast<int>(shift.cols()); ++j)
      heldOut[i] +=
          problem.slotGradients()(i, layout.axis(j)) * gain[j] * shift(problem.rows()[i].observation, j);
}

Noise noiseOf(const Problem& problem, const CalibrateOptions& options) {
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

/// Calibrates with the instrument's zeros as `datum` says.
CalibrationResult calibrateFrom(const Session& session, Model model, const CalibrateOptions& options,
                                const Eigen::VectorXd& given, Datum datum) {
  CalibrationResult result;
  Eigen::VectorXd start = given;
  Eigen::MatrixXd networkShift;
  if (!options.holdEffects && hasToLearn(model)) {
    LearnedModel learned = learnNetworks(session, model, options, start);
    model = std::move(learned.model);
    start = std::move(learned.start);
    networkShift = std::move(learned.heldOutShift);
  }
  result.method = options.method;
  result.seed = options.seed;
  const Machine machine = model.machine();
  const Domain domain = model.domain();
  result.problem = std::make_shared<Problem>(session, std::move(model), datum);
  const Problem& problem = *result.problem;
  const Noise noise = noiseOf(problem, options);

  Eigen::VectorXd x = problem.start();
  if (start.size() == problem.model().parameterCount()) x.head(start.size()) = start;
  const Eigen::VectorXd sigma0 = problem.sigmas(noise.linear, noise.angular), weight0 = usableWeight(problem);
  std::vector<char> held;
  if (options.holdEffects) {
    held.assign(static_cast<std::size_t>(problem.unknownCount()), 0);
    std::fill(held.begin(), held.begin() + problem.model().parameterCount(), 1);
  }
  result.identifiability = identify(problem, gaugePoint(problem, x), inverseOf(sigma0, weight0), true, held);
  const int free = freeCount(result.identifiability.fixed);
  if (static_cast<int>((weight0.array() > 0.0).count()) + problem.priorCount() +
          static_cast<int>(problem.unitVectors().size()) <
      free)
    throw NumericalError(session.source + ": " + std::to_string(problem.rowCount()) +
                         " residuals cannot determine " + std::to_string(free) +
                         " unknowns; measure more, or leave effects out of the model");

  if (start.size() == 0 && !options.holdEffects)
    beamStart(problem, x, result.identifiability.fixed, inverseOf(sigma0, weight0));
  nonlinearStart(*result.problem, x, result.identifiability.fixed, inverseOf(sigma0, weight0),
                 options.cancelled);
  std::vector<Eigen::VectorXd> starts = {x};
  if (options.method != Method::kLeastSquares) {
    result.genetic = geneticStart(problem, x, result.identifiability.fixed, sigma0, weight0, options);
    result.cancelled = result.genetic->stop == "cancelled";
    starts.push_back(x);
  }
  if (!options.holdEffects && !result.cancelled && hasNonlinearParameters(problem)) {
    for (std::size_t i = 0, given = starts.size(); i < given; ++i) {
      Eigen::VectorXd solved = starts[i];
      if (linearStart(problem, solved, result.identifiability.fixed, inverseOf(sigma0, weight0)))
        starts.push_back(solved);
    }
    x = bestPolished(problem, starts, result.identifiability.fixed, sigma0, weight0, options.cancelled);
  }
  Fitter fit(problem, options, noise);
  if (!options.rejectOutliers && options.weights.size() == problem.rowCount()) {
    fit.weight = options.weights;
    fit.fitOnce(x, result.identifiability.fixed);
  } else {
    fit.run(x, result.identifiability.fixed);
  }
  if (problem.model().parameterCount() > 0 && !options.holdEffects &&
      !fit.cancelled) {  // nonlinear parameters may turn out to be lost
    const Identifiability after = identify(problem, fit.x, inverseOf(fit.sigma, fit.weight), false);
    for (const LostDirection& l : after.lost)
      if (!result.identifiability.fixed[l.fixedUnknown] &&
          after.lost.size() > result.identifiability.lost.size() && l.ofTheModel) {
        result.identifiability.fixed[l.fixedUnknown] = 1;
        result.identifiability.lost.push_back(l);
        --result.identifiability.rank;
      }
  }
  if (options.progress) options.progress("uncertainty", 0.0);
  const std::vector<char>& fixed = result.identifiability.fixed;
  Summary summary = summarise(*result.problem, fit, fixed, options.whiteNoise ? nullptr : &result.drift);
  if (!options.holdEffects) summary.takeFreedoms(networkUnknowns(problem.model()));
  if (networkShift.size() > 0) addNetworkShift(*result.problem, fit.x, networkShift, summary.heldOut);
  result.x = fit.x;
  result.residuals = fit.residuals;
  result.weight = fit.weight;
  result.heldOut = summary.heldOut;
  result.covariance = summary.covariance;
  result.polishIterations = fit.iterations;
  result.converged = fit.converged;
  result.cancelled |= fit.cancelled;
  result.stop = fit.stop;

  const bool angularOnly = !has(problem, false);
  double repeatability = angularOnly ? fit.noise.angular : fit.noise.linear;
  result.repeatabilityFrom = noise.from;
  if (noise.from == "estimated") {
    result.repeated = repeatedMeasurements(problem, fit.residuals, angularOnly);
    if (result.repeated.dof > 0.0) {
      result.repeatabilityFrom = "repeated";
      repeatability = result.repeated.value;
    } else {
      const double rms = rmsOf(problem, fit.residuals, fit.weight, angularOnly);
      const double used = (fit.weight.array() > 0.0).count();
      repeatability = rms * std::sqrt(used / std::max(1.0, summary.dof));
    }
    const double factor = repeatability / (angularOnly ? fit.noise.angular : fit.noise.linear);
    fit.noise.linear *= factor;
    fit.noise.angular *= factor;
    fit.sigma = problem.sigmas(fit.noise.linear, fit.noise.angular);
  }
  result.sigma = fit.sigma;
  result.repeatability = repeatability;
  result.figures = figuresOf(problem, fit.residuals, summary.heldOut, fit.sigma, fit.weight, summary.dof,
                             summary.priorChi2);
  for (int i = 0; i < problem.rowCount(); ++i)
    if (fit.weight[i] == 0.0 && problem.uses(problem.rows()[i].observation))
      result.outliers.push_back({i, fit.residuals[i]});

  // the nominal machine on the same rows, for "before"
  Problem nominal(session, Model(machine, domain, std::vector<EffectPtr>{}));
  CalibrateOptions plain = options;
  plain.rejectOutliers = false;
  plain.progress = {};
  const Identifiability gauge = identify(nominal, nominal.start(), inverseOf(fit.sigma, fit.weight), false);
  Fitter before(nominal, plain, fit.noise);
  before.weight = fit.weight;
  before.fitOnce(nominal.start(), gauge.fixed);
  const Summary beforeSummary = summarise(nominal, before, gauge.fixed, nullptr);
  result.before = figuresOf(nominal, before.residuals, beforeSummary.heldOut, fit.sigma, fit.weight,
                            beforeSummary.dof, 0.0);
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
  if (!lawMayStateDatum(session, model))
    return calibrateFrom(session, std::move(model), options, given, Datum::kFree);
  // a law written as a formula says where it starts, and is believed unless the data contradict it
  CalibrationResult byLaw = calibrateFrom(session, model, options, given, Datum::kOfTheLaw);
  if (byLaw.cancelled || !contradictsDatum(byLaw)) return byLaw;
  return calibrateFrom(session, std::move(model), options, given, Datum::kFree);
}

}  // namespace mm
