#include "workflow/recalibration.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/utc_now.h"
#include "effects/owned.h"
#include "effects/registry.h"
#include "estimation/network_learning.h"
#include "machine/machine_fit.h"
#include "model/observed_domain.h"
#include "session/session_hash.h"

namespace mm {
namespace {

bool angularOnly(const ResidualFigures& f) { return !std::isfinite(f.rms) && std::isfinite(f.rmsAngular); }

LedgerEntry entryOf(const std::string& action, const EffectSpec& effect, const ResidualFigures& before,
                    const ResidualFigures& after, const std::string& from, const Session& session) {
  LedgerEntry entry;
  entry.action = action;
  entry.effect = effect;
  entry.time = utcNow();
  const bool angular = angularOnly(after);
  entry.rmsBefore = angular ? before.rmsAngular : before.rms;
  entry.rmsAfter = angular ? after.rmsAngular : after.rms;
  entry.heldOutBefore = angular ? before.heldOutRmsAngular : before.heldOutRms;
  entry.heldOutAfter = angular ? after.heldOutRmsAngular : after.heldOutRms;
  entry.calibration = from;
  for (const Recording& r : session.recordings) entry.sessions.push_back(r.source);
  return entry;
}

std::string listOf(const std::vector<EffectSpec>& effects) {
  if (effects.empty()) return "it has no effects";
  std::string text;
  for (const EffectSpec& e : effects) text += (text.empty() ? "it has " : ", ") + e.yaml();
  return text;
}

/// What began with a session is found by one before it.
void checkSessions(const Session& session, EffectSpec effect) {
  const std::string text = effect.yaml();
  if (takeOwner(effect).fromSession > session.recordingCount())
    throw InputError(
        "effect " + text + ": 'from_session' counts several sessions, and there " +
        (session.recordingCount() == 1 ? "is one" : "are " + std::to_string(session.recordingCount())) +
        "; give the sessions before it as well");
}

auto findEffect(const Calibration& calibration, const EffectSpec& effect) {
  return std::find_if(calibration.effects.begin(), calibration.effects.end(),
                      [&](const EffectSpec& e) { return sameEffect(e, effect, calibration.domain); });
}

/// @param whose words behind "on another machine than". @throw InputError: what differs.
void refuseAnother(const Machine& machine, const Session& session, const std::string& whose,
                   const std::string& remedy) {
  const std::string difference = differenceOf(machine, session.machine, "in the session");
  if (!difference.empty())
    throw InputError(session.source + ": was measured on another machine ('" + session.machine.name() +
                     "') than " + whose + ": " + difference + "; use " + remedy);
}

/// The model as it is and the model as it shall be, both fitted to the same session.
Recalibration refit(const Session& session, const Calibration& calibration,
                    const std::vector<EffectSpec>& effects, const std::string& action,
                    const EffectSpec& effect, const CalibrateOptions& given) {
  checkMachine(calibration, session);
  const CalibrateOptions options = refitting(given, calibration);
  Model before = modelFor(session, calibration.effects);
  Model after = modelFor(session, effects);
  const Eigen::VectorXd beforeStart = startFrom(calibration, before);
  CalibrationResult base = calibrate(session, std::move(before), options, beforeStart);
  if (base.cancelled) throw Cancelled("stopped before the model was refitted; nothing was changed");

  Eigen::VectorXd start = startFrom(calibration, after);
  Recalibration done;
  done.result = calibrate(session, std::move(after), options, start);
  done.calibration = toCalibration(done.result, calibration.machineName);
  done.calibration.sessionSpace = calibration.sessionSpace;
  done.calibration.toldSpace = calibration.toldSpace;
  if (!calibration.sessionOrigin.empty()) done.calibration.sessionOrigin = calibration.sessionOrigin;
  done.calibration.ledger = calibration.ledger;
  done.calibration.ledger.push_back(
      entryOf(action, effect, base.figures, done.result.figures, calibration.id, session));
  return done;
}

CalibratedBy calibratedBy(const Artifact& artifact) {
  CalibratedBy by;
  by.name = artifact.name;
  by.serial = artifact.serial;
  by.features = static_cast<std::int64_t>(artifact.features.size());
  by.poseKnown = artifact.poseKnown;
  by.tipRadius = artifact.tipRadius;
  for (const Feature& f : artifact.features) {
    by.radiusStd = std::max(by.radiusStd, f.radiusStd);
    if (!f.known) continue;
    by.centreStd = std::max(by.centreStd, f.positionStd);
    for (const Feature& g : artifact.features)
      if (g.known) by.span = std::max(by.span, (f.position - g.position).norm());
  }
  return by;
}

/// Where the features are in the artifact's frame: as its file says, where nothing was estimated; with what
/// effects of the artifact do to them.
std::vector<FoundInArtifact> foundInArtifact(const CalibrationResult& result) {
  const Problem& problem = *result.problem;
  const Artifact& artifact = problem.session().artifact;
  const Model& model = problem.model();
  std::vector<FoundInArtifact> all;
  for (std::size_t i = 0; i < artifact.features.size(); ++i) {
    const int feature = static_cast<int>(i);
    const Feature& stated = artifact.features[i];
    FoundInArtifact f;
    f.name = stated.name;
    f.ball = stated.kind == FeatureKind::kBall;
    f.position = problem.featureInArtifact(feature, result.x);
    f.radius = stated.radius;
    Eigen::Vector3d variance = Eigen::Vector3d::Constant(std::pow(stated.positionStd, 2));
    f.radiusStd = stated.radiusStd;
    const auto varianceOf = [&](int unknown) {
      const auto u = static_cast<std::size_t>(unknown);
      return result.identifiability.fixed[u] != 0 ? 0.0 : result.covariance(unknown, unknown);
    };
    if (const int at = problem.find(UnknownKind::kFeature, feature); at >= 0) {
      f.free = true;
      for (int k = 0; k < 3; ++k) variance[k] = varianceOf(at + k);
    }
    if (const int at = problem.find(UnknownKind::kRadius, feature); at >= 0) {
      f.radius += result.x[at];
      f.radiusStd = std::sqrt(varianceOf(at));
    }
    for (int u = 0; u < model.parameterCount(); ++u) {
      const EffectSpec& effect = model.effects()[static_cast<std::size_t>(model.effectOf(u))]->spec();
      const bool position = effect.type == "artifact_position" && effect.text("feature") == f.name;
      const bool radius = effect.type == "ball_radius" && effect.text("ball") == f.name;
      if (!effect.text("from_session").empty() || (!position && !radius)) continue;
      f.free = true;
      const int k = u - model.offset(model.effectOf(u));
      (position ? f.position[k] : f.radius) += result.x[u];
      if (position)
        variance[k] += varianceOf(u);
      else
        f.radiusStd = std::hypot(f.radiusStd, std::sqrt(varianceOf(u)));
    }
    f.std = variance.cwiseSqrt();
    all.push_back(std::move(f));
  }
  return all;
}

}  // namespace

bool sameEffect(const EffectSpec& a, const EffectSpec& b, const Domain& domain) {
  if (a == b) return true;
  if (a.type != b.type) return false;
  try {  // defaults that one of them left out
    return createEffect(a, domain)->spec() == createEffect(b, domain)->spec();
  } catch (const InputError&) {
    return false;
  }
}

std::vector<std::string> doubtsOf(const CalibrationResult& result) {
  std::vector<std::string> doubts;
  if (!result.converged)
    doubts.push_back("not converged (" + result.stop + "); try another seed, or a simpler model");
  if (result.problem->rowCount() > 0 && result.figures.degreesOfFreedom == 0)
    doubts.push_back(std::to_string(result.problem->rowCount()) +
                     " residuals and as many free parameters (degrees of freedom 0): the fit is exact "
                     "whatever was measured, and its RMS says nothing; measure more points, or use a simpler "
                     "model");
  for (const LostDirection& l : result.identifiability.lost)
    if (l.lacking()) doubts.push_back("not determined by this session: " + l.inWords + "; " + l.wouldShow);
  return doubts;
}

CalibrateOptions refitting(CalibrateOptions options, const Calibration& calibration) {
  options.method = Method::kLeastSquares;
  // the noise that was declared for the calibration stays declared, unless it is stated anew
  if (options.repeatability <= 0.0 && calibration.repeatabilityFrom == "declared" &&
      calibration.repeatability > 0.0 && std::isfinite(calibration.rms))
    options.repeatability = calibration.repeatability;
  return options;
}

Model modelFor(const Session& session, const std::vector<EffectSpec>& effects) {
  return Model(session.machine, observedDomain(session), effects);
}

Model modelOf(const Calibration& calibration) {
  return Model(Machine(calibration.urdf, calibration.machineName), calibration.domain, calibration.effects,
               calibration.networks);
}

Eigen::VectorXd valuesOf(const Calibration& calibration) {
  Eigen::VectorXd values(static_cast<Eigen::Index>(calibration.values.size()));
  for (Eigen::Index i = 0; i < values.size(); ++i)
    values[i] = calibration.values[static_cast<std::size_t>(i)].value;
  return values;
}

Eigen::VectorXd startFrom(const Calibration& calibration, const Model& model) {
  Eigen::VectorXd start = model.start();
  for (int i = 0; i < model.parameterCount(); ++i) {
    const Effect& effect = *model.effects()[static_cast<std::size_t>(model.effectOf(i))];
    for (const Calibration::Value& v : calibration.values)
      if (!v.fixed && v.name == model.parameter(i).name &&
          sameEffect(calibration.effects[static_cast<std::size_t>(v.effect)], effect.spec(),
                     calibration.domain))
        start[i] = v.value;
  }
  return start;
}

Calibration toCalibration(const CalibrationResult& result, const std::string& machineName) {
  const Problem& problem = *result.problem;
  const Session& session = problem.session();
  const Model& model = problem.model();
  Calibration c;
  c.machineName = machineName.empty() ? model.machine().name() : machineName;
  c.urdf = model.machine().urdf();
  c.domain = model.domain();
  c.networks = model.networks();
  for (const EffectPtr& e : model.effects()) c.effects.push_back(e->spec());
  const int count = model.parameterCount();
  for (int i = 0; i < count; ++i) {
    const Parameter& p = model.parameter(i);
    const bool fixed = result.identifiability.fixed[static_cast<std::size_t>(i)] != 0;
    c.values.push_back(
        {model.effectOf(i), p.name, p.unit, p.toUnit, result.x[i], fixed ? 0.0 : result.std(i), fixed});
  }
  c.covariance = result.covariance.topLeftCorner(count, count);
  for (const Drift& d : result.drift)
    if (d.direction != "approach")
      c.drift.push_back({d.direction, d.std, d.timeConstant, d.smooth});  // that is the contact's
  c.artifact = calibratedBy(session.artifact);
  c.artifact->found = foundInArtifact(result);
  for (const Recording& r : session.recordings) c.sessionParts.push_back({r.source, r.hash});
  c.sessionSource = session.source;
  c.sessionHash = sessionHash(session);
  constexpr double kEarliest = 1.2e9;  // s; stamps from before 2008 have the made-up date of an import
  if (session.epoch > kEarliest) c.sessionEpoch = session.epoch;
  if (session.simulated) c.sessionOrigin = "simulated";
  c.compensation = session.compensation;
  c.method = nameOf(result.method);
  c.seed = result.seed;
  c.observations = static_cast<std::int64_t>(session.observations.size());
  c.rms = result.figures.rms;
  c.heldOutRms = result.figures.heldOutRms;
  c.rmsAngular = result.figures.rmsAngular;
  c.heldOutRmsAngular = result.figures.heldOutRmsAngular;
  c.chi2PerDof = result.figures.chi2PerDof;
  c.degreesOfFreedom = result.figures.degreesOfFreedom;
  c.repeatability = result.repeatability;
  c.repeatabilityFrom = result.repeatabilityFrom;
  return c;
}

Recalibration recalibrate(const Session& session, const ModelSpec& spec, const CalibrateOptions& given) {
  CalibrateOptions options = given;
  if (options.repeatability <= 0.0 && spec.repeatability > 0.0) options.repeatability = spec.repeatability;
  for (std::size_t i = 0; i < spec.effects.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (spec.effects[i] == spec.effects[j])
        throw InputError("the model names " + spec.effects[i].yaml() + " twice; remove one of them");
  for (const EffectSpec& effect : spec.effects) checkSessions(session, effect);
  Recalibration done;
  done.result = calibrate(session, modelFor(session, spec.effects), options);
  done.calibration = toCalibration(done.result, spec.machine);
  done.calibration.ledger = {entryOf("calibrate", {}, done.result.before, done.result.figures, {}, session)};
  return done;
}

Recalibration addEffect(const Session& session, const Calibration& calibration, const EffectSpec& effect,
                        const CalibrateOptions& options) {
  checkMachine(calibration, session);             // the effect's joints are those of the calibrated machine
  createEffect(effect, observedDomain(session));  // its own message comes first
  checkSessions(session, effect);
  if (findEffect(calibration, effect) != calibration.effects.end())
    throw InputError(effect.yaml() + " is in the model already (" + listOf(calibration.effects) +
                     "); add another effect, or remove this one first");
  std::vector<EffectSpec> effects = calibration.effects;
  effects.push_back(effect);
  return refit(session, calibration, effects, "add", effect, options);
}

Recalibration removeEffect(const Session& session, const Calibration& calibration, const EffectSpec& effect,
                           const CalibrateOptions& options) {
  const auto found = findEffect(calibration, effect);
  if (found == calibration.effects.end())
    throw InputError(effect.yaml() + " is not in the model (" + listOf(calibration.effects) +
                     "); name one of these");
  std::vector<EffectSpec> effects = calibration.effects;
  effects.erase(effects.begin() + (found - calibration.effects.begin()));
  return refit(session, calibration, effects, "remove", effect, options);
}

Recalibration updateNetworks(const Session& session, const Calibration& calibration,
                             CalibrateOptions options) {
  checkMachine(calibration, session);
  options.rejectOutliers = false;  // what the old networks do not know is no outlier
  UpdatedNetworks updated = updateNetworks(compareCalibration(session, calibration, options));
  Recalibration done;
  done.calibration = calibration;
  done.calibration.id.clear();
  done.calibration.created.clear();
  done.calibration.software.clear();
  done.calibration.domain = std::move(updated.domain);
  done.calibration.networks = std::move(updated.networks);
  LedgerEntry entry;
  entry.action = "update";
  for (const EffectSpec& effect : calibration.effects)
    if (effect.yaml() == updated.effects.front()) entry.effect = effect;
  entry.time = utcNow();
  entry.rmsBefore = entry.heldOutBefore = updated.before;
  entry.rmsAfter = updated.after;
  entry.heldOutAfter = updated.heldOut;
  entry.calibration = calibration.id;
  done.calibration.ledger.push_back(entry);
  done.result = compareCalibration(session, done.calibration, options);
  return done;
}

CalibrationResult compareCalibration(const Session& session, const Calibration& calibration,
                                     CalibrateOptions options) {
  checkMachine(calibration, session);
  options.method = Method::kLeastSquares;
  options.holdEffects = true;
  return calibrate(session, modelOf(calibration), options, valuesOf(calibration));
}

void checkMachine(const Calibration& calibration, const Session& session) {
  refuseAnother(Machine(calibration.urdf, calibration.machineName), session,
                "the one that was calibrated ('" + calibration.machineName + "')",
                "a session of the machine that was calibrated");
}

void checkMachine(const ModelSpec& model, const std::filesystem::path& folder, const Session& session) {
  if (model.machine.empty()) return;
  refuseAnother(Machine::load(model.machine, folder), session, "the model's ('" + model.machine + "')",
                "the model of the machine that measured");
}

}  // namespace mm
