#include "model/session_states.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.h"
#include "model/smoothed_series.h"

namespace mm {
namespace {

const Series* findSeries(const std::vector<Series>& logged, const std::string& name) {
  const auto found =
      std::find_if(logged.begin(), logged.end(), [&](const Series& s) { return s.name == name; });
  return found == logged.end() ? nullptr : &*found;
}

std::vector<const Series*> inOrder(const std::vector<Series>& logged, const std::vector<std::string>& names) {
  std::vector<const Series*> ordered;
  for (const std::string& name : names) ordered.push_back(findSeries(logged, name));
  return ordered;
}

std::vector<double> valuesAt(const std::vector<const Series*>& logged, double time) {
  std::vector<double> values;
  values.reserve(logged.size());
  for (const Series* series : logged) values.push_back(series == nullptr ? kNotMeasured : series->at(time));
  return values;
}

std::string names(const std::vector<Joint>& joints) {
  std::string text;
  for (const Joint& joint : joints) text += (text.empty() ? "" : ", ") + joint.name;
  return text;
}

void checkJoints(const Session& session, const Domain& domain) {
  const std::vector<Joint>& own = session.machine.joints();
  const bool same =
      own.size() == domain.joints.size() &&
      std::equal(own.begin(), own.end(), domain.joints.begin(),
                 [](const Joint& a, const Joint& b) { return a.name == b.name && a.kind == b.kind; });
  if (!same)
    throw InputError(session.source + ": the session's machine has the joints " + names(own) +
                     ", the model's " + names(domain.joints) +
                     "; use a session of the machine that was calibrated");
}

/// Whether an observation may show the error of a joint: deviations are those of the joints they are told of.
bool sees(const Observation& o, std::size_t joint) {
  return o.kind != ObservationKind::kDeviation ||
         (joint < o.deviation.size() && !std::isnan(o.deviation[joint]));
}

/// Before a joint first moved its direction of travel is not known. Where nothing is measured along it, as in
/// the runs of the other axes, it does not matter: the direction of its first motion stands for it.
void whereTravelDoesNotMatter(const Session& session, std::vector<State>& states) {
  for (std::size_t j = 0; j < session.machine.joints().size(); ++j) {
    std::size_t first = 0;
    while (first < states.size() && states[first].travel[j] == 0.0) ++first;
    if (first == states.size()) continue;
    for (std::size_t o = 0; o < first; ++o)
      if (!sees(session.observations[o], j)) states[o].travel[j] = states[first].travel[j];
  }
}

/// The way since a reversal, by the rows: from the last one before it, and at first from where a joint began
/// to move. How it came to where it stood before, nobody knows; between two touches the probe went back and
/// forth.
void sinceReversals(const Session& session, std::vector<State>& states) {
  const std::size_t joints = session.machine.joints().size();
  for (State& state : states) state.sinceReversal.assign(joints, std::numeric_limits<double>::infinity());
  for (std::size_t j = 0; j < joints; ++j) {
    double turn = states.front().position[j];
    std::size_t first = states.size();  // that is reached by a motion
    for (std::size_t o = 1; o < states.size(); ++o) {
      State& state = states[o];
      const bool turned = state.travel[j] * states[o - 1].travel[j] < 0.0;
      if (turned) turn = states[o - 1].position[j];
      if (turned || state.position[j] != turn) first = std::min(first, o);
      if (o >= first) state.sinceReversal[j] = std::abs(state.position[j] - turn);
    }
    if (first == states.size()) continue;
    for (std::size_t o = 0; o < first; ++o)
      if (sees(session.observations[o], j)) states[o].sinceReversal[j] = kNotMeasured;
  }
  for (std::size_t o = 0; o < states.size(); ++o) {
    const Observation& at = session.observations[o];
    if (at.kind == ObservationKind::kContact && at.feature >= 0 && std::isnan(at.laserReading))
      states[o].sinceReversal.assign(joints, kNotMeasured);
  }
}

}  // namespace

std::vector<Series> temperaturesOf(const Session& session, const Domain& domain) {
  std::vector<Series> ordered;
  for (const std::string& sensor : domain.sensors) {
    const Series* series = findSeries(session.temperatures, sensor);
    ordered.push_back(series == nullptr ? Series{} : *series);
    ordered.back().name = sensor;
  }
  return ordered;
}

SessionStates::SessionStates(const Session& session, const Domain& domain, Temperatures temperatures) {
  checkJoints(session, domain);
  std::vector<Series> courses = temperaturesOf(session, domain);
  if (temperatures == Temperatures::kSmoothed)
    for (Series& s : courses) s = smoothed(std::move(s));
  const std::vector<const Series*> covariates = inOrder(session.covariates, domain.covariates);
  history_ = std::make_shared<SeriesHistory>(courses);
  std::vector<int> featureOf;
  for (const Feature& feature : session.artifact.features)
    featureOf.push_back(domain.findFeature(feature.name));

  states_.reserve(session.observations.size());
  for (const Observation& o : session.observations) {
    State state;
    state.time = o.time;
    state.position = o.position;
    state.velocity = o.velocity;
    state.velocity.resize(o.position.size(), kNotMeasured);
    state.travel = o.travel;
    state.travel.resize(o.position.size(), 0.0);
    for (std::size_t s = 0; s < courses.size(); ++s) state.temperature.push_back(courses[s].at(o.time));
    state.covariate = valuesAt(covariates, o.time);
    state.laserReading = o.laserReading;
    state.history = history_.get();
    if (o.feature >= 0) {
      const Feature& feature = session.artifact.features[o.feature];
      state.feature = featureOf[o.feature];
      state.featurePosition = feature.position;
      state.featureRadius = feature.radius;
    }
    // The lever is that of the probe itself: the machine adds the reach of a laser's beam.
    const ProbePose nominal = session.machine.nominal(o.position.data(), kNotMeasured);
    state.tip = nominal.position;
    state.orientation = nominal.orientation;
    const bool laser = !std::isnan(o.laserReading);
    const bool recorded = o.approach.allFinite();
    if (laser)
      state.approach = nominal.orientation.col(2);
    else if (recorded)
      state.approach = o.approach;
    // The direction from a tip to a point that it reached would be noise.
    const bool ball = o.feature >= 0 && session.artifact.features[o.feature].kind == FeatureKind::kBall;
    aimAt_.push_back(ball && !laser && !recorded && o.kind == ObservationKind::kContact ? o.feature : -1);
    surfaceOf_.push_back(laser && ball ? o.feature : -1);
    states_.push_back(std::move(state));
  }
  whereTravelDoesNotMatter(session, states_);
  if (!states_.empty()) sinceReversals(session, states_);
}

void SessionStates::aim(const std::vector<Eigen::Vector3d>& centres) {
  for (std::size_t i = 0; i < states_.size(); ++i) {
    if (surfaceOf_[i] >= 0) {
      const Eigen::Vector3d spot = states_[i].tip + states_[i].orientation.col(2) * states_[i].laserReading;
      states_[i].surfaceNormal = (spot - centres[surfaceOf_[i]]).normalized();
    }
    if (aimAt_[i] < 0) continue;
    const Eigen::Vector3d towards = centres[aimAt_[i]] - states_[i].tip;
    const double distance = towards.norm();
    if (distance > 0.0) states_[i].approach = towards / distance;
  }
}

}  // namespace mm
