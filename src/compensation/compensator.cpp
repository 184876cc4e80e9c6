#include "compensation/compensator.h"

#include <cmath>

#include "base/error.h"
#include "base/format.h"
#include "base/names_of.h"
#include "base/quantity_words.h"
#include "base/rotation.h"
#include "base/units.h"
#include "effects/inputs.h"
#include "session/session.h"

namespace mm {
namespace {

constexpr double kPastSeen = 1e-9;  // m: less is no news

}  // namespace

Eigen::Vector3d motionAlong(const std::string& direction, const Domain& domain,
                            const Eigen::Matrix<double, 6, Eigen::Dynamic>& jacobian) {
  const int joint = domain.findJoint(direction);
  if (joint >= 0) return jacobian.block<3, 1>(0, joint);
  for (int k = 0; k < 3; ++k)
    if (direction == std::string(1, "xyz"[k])) return Eigen::Vector3d::Unit(k);
  return Eigen::Vector3d::Zero();
}

Compensator::Compensator(const Calibration& calibration, Options options)
    : id_(calibration.id),
      options_(options),
      model_(Machine(calibration.urdf, calibration.machineName), calibration.domain, calibration.effects,
             calibration.networks),
      drift_(calibration.drift) {
  if (!(options_.margin >= 0.0))
    throw InputError("margin of the calibrated volume is " + std::to_string(options_.margin) +
                     "; it must be 0 or more (0.1 is a tenth of the range)");
  const std::string name = "calibration '" + id_ + "'";
  if (allNames(model_.machine().joints()) != allNames(calibration.domain.joints))
    throw InputError(name + ": its URDF and its ranges disagree on the joints; calibrate again");
  if (model_.parameterCount() != static_cast<int>(calibration.values.size()) ||
      calibration.covariance.rows() != model_.parameterCount() ||
      calibration.covariance.cols() != model_.parameterCount())
    throw InputError(name + ": its effects have " + std::to_string(model_.parameterCount()) +
                     " parameters, it holds " + std::to_string(calibration.values.size()) + " (software " +
                     calibration.software + "); calibrate again");
  for (int p = 0; p < model_.parameterCount(); ++p) {
    const Calibration::Value& v = calibration.values[p];
    if (v.name != model_.parameter(p).name || v.effect != model_.effectOf(p))
      throw InputError(name + ": parameter " + std::to_string(p + 1) + " is '" + v.name +
                       "', its effect has '" + model_.parameter(p).name + "' there (software " +
                       calibration.software + "); calibrate again");
    if (!std::isfinite(v.value))
      throw InputError(name + ": parameter '" + v.name + "' is not a finite number; calibrate again");
  }
  for (const EffectPtr& effect : model_.effects()) {
    ofTime_.push_back(inputsOf(*effect, model_.domain()).time);
    if (ofTime_.back()) timed_ += (timed_.empty() ? "" : ", ") + effect->spec().type;
  }
  all_ = partOf(calibration, true);
  timeless_ = timed_.empty() ? all_ : partOf(calibration, false);
  limits_ = std::make_unique<CalibratedLimits>(*all_.model, options_.margin);
}

Compensator::Part Compensator::partOf(const Calibration& calibration, bool timed) const {
  std::vector<EffectPtr> effects;
  std::vector<int> kept;
  for (int p = 0; p < model_.parameterCount(); ++p)
    if (timed || !ofTime_[model_.effectOf(p)]) kept.push_back(p);
  for (std::size_t e = 0; e < model_.effects().size(); ++e)
    if (timed || !ofTime_[e]) effects.push_back(model_.effects()[e]);
  Part part;
  part.model = std::make_shared<const Model>(model_.machine(), model_.domain(), std::move(effects));
  part.parameters.resize(static_cast<Eigen::Index>(kept.size()));
  for (std::size_t i = 0; i < kept.size(); ++i)
    part.parameters[static_cast<Eigen::Index>(i)] = calibration.values[kept[i]].value;
  part.covariance = calibration.covariance(kept, kept);
  return part;
}

State Compensator::blankState() const {
  const Domain& d = model_.domain();
  State state;
  state.position.assign(d.joints.size(), 0.0);
  state.velocity.assign(d.joints.size(), kNotMeasured);
  state.travel.assign(d.joints.size(), 0.0);
  state.temperature.assign(d.sensors.size(), kNotMeasured);
  state.covariate.assign(d.covariates.size(), kNotMeasured);
  state.laserReading = kNotMeasured;
  return state;
}

State middleState(const Compensator& compensator) {
  const Domain& d = compensator.model().domain();
  State state = compensator.blankState();
  for (std::size_t j = 0; j < d.joints.size(); ++j) {
    state.position[j] = 0.5 * (d.lower[j] + d.upper[j]);
    state.velocity[j] = 0.0;
  }
  for (std::size_t s = 0; s < d.sensors.size(); ++s)
    state.temperature[s] = 0.5 * (d.sensorLower[s] + d.sensorUpper[s]);
  for (std::size_t c = 0; c < d.covariates.size(); ++c)
    state.covariate[c] = 0.5 * (d.covariateLower[c] + d.covariateUpper[c]);
  if (d.laser) state.laserReading = 0.5 * (d.readingLower + d.readingUpper);
  return state;
}

void Compensator::judge(const State& state, const Part& part, Correction& c) const {
  const bool finite =
      c.corrected.position.allFinite() && c.corrected.orientation.allFinite() && c.covariance.allFinite();
  if (!finite) {
    c.inputLost = limits_->lost(state);
    c.reason = limits_->missing(state);
    if (c.reason.empty()) c.reason = "the correction is not a finite number";
    return;
  }
  c.reason = limits_->jointOutside(state);
  if (c.reason.empty()) c.reason = limits_->inputOutside(state);
  for (std::size_t e = 0; c.reason.empty() && e < part.model->effects().size(); ++e)
    c.reason = part.model->effects()[e]->outside(state, options_.margin);
  c.extrapolating = !c.reason.empty();
  c.valid = c.reason.empty();
  if (c.valid) c.note = limits_->unusual(state);
}

/// Between a reversal and the end of the play the slide has not followed yet: the model, which knows the two
/// ends alone, may be off by what is left of the difference between them, and, while a reversal is too short
/// to be called one, by the way back. Taken as its standard deviation.
void Compensator::addPlay(const State& state, const MovingState& moved, const Part& part, Workspace& work,
                          Correction& c) const {
  if (!c.corrected.position.allFinite()) return;
  for (std::size_t j = 0; j < state.travel.size(); ++j) {
    if (!limits_->usesTravel(j) || state.travel[j] == 0.0) continue;
    const double since = state.sinceReversalOf(static_cast<int>(j));
    const double back = j < moved.back.size() ? moved.back[j] : 0.0;
    if (!std::isfinite(since) && !(back > 0.0)) continue;
    State other = state;
    other.travel[j] = -state.travel[j];
    const Eigen::Vector3d play =
        part.model->corrected(other, part.parameters.data(), work.model).position - c.corrected.position;
    const double left = std::isnan(since) ? 0.0 : play.norm() - since;
    const double open = std::max(left, std::min(back, play.norm()));
    if (!(open > 0.0)) continue;
    const Eigen::Vector3d off = play * (open / play.norm());
    c.covariance += off * off.transpose();
    if (left > 0.0)
      c.note += (c.note.empty() ? "" : "; ") + std::string("backlash of ") +
                model_.machine().joints()[j].name + " is being taken up: " + errorInWords(left, false) +
                " of " + errorInWords(play.norm(), false) + " remain";
  }
}

/// What the temperatures were before they were first heard decides what lags behind them, until that has
/// decayed. Taken as the difference that the other past makes, as a standard deviation.
void Compensator::addPast(const State& state, const Part& part, Workspace& work, Correction& c) const {
  const auto* young = dynamic_cast<const YoungHistory*>(state.history);
  const TemperatureHistory* past = young == nullptr ? nullptr : young->otherPast();
  if (past == nullptr || !c.corrected.position.allFinite()) return;
  State other = state;
  other.history = past;
  const Eigen::Vector3d off =
      part.model->corrected(other, part.parameters.data(), work.model).position - c.corrected.position;
  if (!(off.norm() > kPastSeen)) return;
  c.pastUnknown = true;
  c.covariance += off * off.transpose();
  c.note +=
      (c.note.empty() ? "" : "; ") +
      format(
          "thermal effects with a time lag may be wrong by %.3g um (one standard deviation): temperatures "
          "have not been received for long enough",
          off.norm() / kMicrometre);
}

Correction Compensator::apply(const State& state, const MovingState* moved, Workspace& work) const {
  Correction c;
  const Domain& d = model_.domain();
  if (state.position.size() != d.joints.size() || state.velocity.size() != d.joints.size() ||
      state.travel.size() != d.joints.size() || state.temperature.size() != d.sensors.size() ||
      state.covariate.size() != d.covariates.size())
    throw InputError("a state must have the joints, sensors and covariates of calibration '" + id_ + "'");
  c.tooOld = !timed_.empty() && (state.time > d.duration || state.time < 0.0);
  const Part& part = c.tooOld ? timeless_ : all_;
  const double beam = d.laser ? state.laserReading : kNotMeasured;
  c.nominal = {state.tip, state.orientation};  // as Model::place set them
  if (!std::isnan(beam)) c.nominal.position += state.orientation.col(2) * beam;
  c.corrected = options_.sigma ? part.model->correctedWithCovariance(
                                     state, part.parameters.data(), part.covariance, work.model, c.covariance)
                               : part.model->corrected(state, part.parameters.data(), work.model);
  c.displacement = c.corrected.position - c.nominal.position;
  if (c.corrected.orientation != c.nominal.orientation)
    c.rotation = rotationVectorOf(c.corrected.orientation * c.nominal.orientation.transpose());
  if (options_.sigma) {
    if (!drift_.empty()) {
      const auto jacobian = model_.machine().jacobian(state.position.data(), beam);
      for (const Wandering& w : drift_) {
        const Eigen::Vector3d along = motionAlong(w.direction, d, jacobian);
        c.covariance += w.std * w.std * along * along.transpose();
      }
    }
    if (moved != nullptr) addPlay(state, *moved, part, work, c);
    addPast(state, part, work, c);
    c.sigma = std::sqrt(std::max(0.0, c.covariance.trace() / 3.0));
  }
  const std::string past = c.note;
  c.note.clear();
  judge(state, part, c);
  const auto note = [&](const std::string& more) {
    if (!more.empty()) c.note += (c.note.empty() ? "" : "; ") + more;
  };
  if (c.valid) note(past);
  if (c.tooOld) {
    c.note =
        format("time %.6g s is outside the calibrated 0 to %.6g s: not applied: ", state.time, d.duration) +
        timed_;
    if (c.valid) note(past);
  }
  return c;
}

Correction Compensator::apply(const State& state) const {
  Workspace work;
  return apply(state, nullptr, work);
}

Correction Compensator::apply(const MovingState& state) const {
  Workspace work;
  return apply(state, &state, work);
}

}  // namespace mm
