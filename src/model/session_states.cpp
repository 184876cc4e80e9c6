#include "model/session_states.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.h"
#include "base/names_of.h"
#include "base/text.h"
#include "model/smoothed_series.h"

namespace mm {
namespace {

const Series* findSeries(const std::vector<Series>& logged, const std::string& name) {
  const auto found =
      std::find_if(logged.begin(), logged.end(), [&](const Series& s) { return s.name == name; });
  return found == logged.end() ? nullptr : &*found;
}

/// What was logged during one recording, by its own time.
Series ofRecording(const Session& session, const Series& whole, int recording) {
  if (session.recordings.empty()) return whole;
  const auto r = static_cast<std::size_t>(recording);
  const double begin = session.recordings[r].begin;
  const double end = r + 1 < session.recordings.size() ? session.recordings[r + 1].begin
                                                       : std::numeric_limits<double>::infinity();
  Series part{whole.name, whole.unit, {}, {}};
  for (std::size_t i = 0; i < whole.time.size(); ++i) {
    if (whole.time[i] < begin || whole.time[i] >= end) continue;
    part.time.push_back(whole.time[i] - begin);
    part.value.push_back(whole.value[i]);
  }
  return part;
}

std::vector<double> valuesAt(const std::vector<Series>& courses, double time) {
  std::vector<double> values;
  values.reserve(courses.size());
  for (const Series& series : courses) values.push_back(series.at(time));
  return values;
}

void checkJoints(const Session& session, const Domain& domain) {
  const std::vector<Joint>& own = session.machine.joints();
  const bool same =
      own.size() == domain.joints.size() &&
      std::equal(own.begin(), own.end(), domain.joints.begin(),
                 [](const Joint& a, const Joint& b) { return a.name == b.name && a.kind == b.kind; });
  if (!same)
    throw InputError(session.source + ": the session's machine has the joints " +
                     joined(allNames(own), ", ") + ", the model's " + joined(allNames(domain.joints), ", ") +
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

/// The way since a reversal, by the rows first … end of one recording: from the last one before it, and at
/// first from where a joint began to move. How it came to where it stood before, nobody knows; between two
/// touches the probe went back and forth.
void sinceReversals(const Session& session, std::size_t first, std::size_t end, std::vector<State>& states) {
  const std::size_t joints = session.machine.joints().size();
  for (std::size_t o = first; o < end; ++o)
    states[o].sinceReversal.assign(joints, std::numeric_limits<double>::infinity());
  for (std::size_t j = 0; j < joints; ++j) {
    double turn = states[first].position[j];
    std::size_t moved = end;  // the first that is reached by a motion
    for (std::size_t o = first + 1; o < end; ++o) {
      State& state = states[o];
      const bool turned = state.travel[j] * states[o - 1].travel[j] < 0.0;
      if (turned) turn = states[o - 1].position[j];
      if (turned || state.position[j] != turn) moved = std::min(moved, o);
      if (o >= moved) state.sinceReversal[j] = std::abs(state.position[j] - turn);
    }
    if (moved == end) continue;
    for (std::size_t o = first; o < moved; ++o)
      if (sees(session.observations[o], j)) states[o].sinceReversal[j] = kNotMeasured;
  }
  for (std::size_t o = first; o < end; ++o) {
    const Observation& at = session.observations[o];
    if (at.kind == ObservationKind::kContact && at.feature >= 0 && std::isnan(at.laserReading))
      states[o].sinceReversal.assign(joints, kNotMeasured);
  }
}

/// The session's temperatures in the order of the domain's sensors, those of one recording by its own time;
/// empty series for those it does not have.
std::vector<Series> temperaturesOf(const Session& session, const Domain& domain, int recording) {
  std::vector<Series> ordered;
  for (const std::string& sensor : domain.sensors) {
    const Series* series = findSeries(session.temperatures, sensor);
    ordered.push_back(series == nullptr ? Series{} : ofRecording(session, *series, recording));
    ordered.back().name = sensor;
  }
  return ordered;
}

/// Courses of one recording.
struct Courses {
  std::vector<Series> temperatures, covariates;
};

Courses coursesOf(const Session& session, const Domain& domain, int recording, bool smooth) {
  Courses courses{temperaturesOf(session, domain, recording), {}};
  if (smooth)
    for (Series& s : courses.temperatures) s = smoothed(std::move(s));
  for (const std::string& name : domain.covariates) {
    const Series* series = findSeries(session.covariates, name);
    courses.covariates.push_back(series == nullptr ? Series{} : ofRecording(session, *series, recording));
  }
  return courses;
}

}  // namespace

SessionStates::SessionStates(const Session& session, const Domain& domain, Temperatures temperatures) {
  checkJoints(session, domain);
  std::vector<Courses> courses;
  for (int r = 0; r < session.recordingCount(); ++r) {
    courses.push_back(coursesOf(session, domain, r, temperatures == Temperatures::kSmoothed));
    histories_.push_back(std::make_shared<SeriesHistory>(courses.back().temperatures));
  }
  std::vector<int> featureOf, stylusOf;
  for (const Feature& feature : session.artifact.features)
    featureOf.push_back(domain.findFeature(feature.name));
  for (const Stylus& stylus : session.artifact.styli) stylusOf.push_back(domain.findStylus(stylus.name));

  states_.reserve(session.observations.size());
  for (const Observation& o : session.observations) {
    const auto recording = static_cast<std::size_t>(o.recording);
    State state;
    const double time = session.ownTime(o);
    state.time = session.timed(o) ? time : kNotMeasured;
    // a session that is none of those of the domain is taken as later than them
    if (session.recordingCount() == domain.recordings) state.recording = o.recording;
    if (!stylusOf.empty()) state.stylus = stylusOf[static_cast<std::size_t>(o.stylus)];
    state.position = o.position;
    state.velocity = o.velocity;
    state.velocity.resize(o.position.size(), kNotMeasured);
    state.travel = o.travel;
    state.travel.resize(o.position.size(), 0.0);
    state.temperature = valuesAt(courses[recording].temperatures, time);
    state.covariate = valuesAt(courses[recording].covariates, time);
    state.laserReading = o.laserReading;
    state.history = histories_[recording].get();
    if (o.kind == ObservationKind::kContact && o.feature >= 0) {  // a length touches nothing
      const Feature& feature = session.artifact.features[o.feature];
      state.feature = featureOf[o.feature];
      state.featurePosition = feature.position;
      state.featureRadius = feature.radius;
    }
    // The lever is that of the probe itself: the machine adds the reach of a laser's beam, or of a stylus.
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
    const bool aims = ball && !laser && !recorded && o.kind == ObservationKind::kContact;
    seen_.push_back({aims ? o.feature : -1, laser && ball ? o.feature : -1, o.placement, o.stylus});
    states_.push_back(std::move(state));
  }
  whereTravelDoesNotMatter(session, states_);
  for (std::size_t first = 0, end = 0; first < states_.size(); first = end) {
    while (end < states_.size() &&
           session.observations[end].recording == session.observations[first].recording)
      ++end;
    sinceReversals(session, first, end, states_);
  }
}

void SessionStates::aim(const GeometricStart& start) {
  for (std::size_t i = 0; i < states_.size(); ++i) {
    const Seen& seen = seen_[i];
    const Eigen::Matrix3d& orientation = states_[i].orientation;
    if (seen.surfaceOf >= 0) {
      const Eigen::Vector3d spot = states_[i].tip + orientation.col(2) * states_[i].laserReading;
      states_[i].surfaceNormal = (spot - start.inWorkpiece(seen.surfaceOf, seen.placement)).normalized();
    }
    if (seen.aimAt < 0) continue;
    const Eigen::Vector3d tip =
        states_[i].tip + orientation * start.offsets[static_cast<std::size_t>(seen.stylus)];
    const Eigen::Vector3d towards = start.inWorkpiece(seen.aimAt, seen.placement) - tip;
    const double distance = towards.norm();
    if (distance > 0.0) states_[i].approach = towards / distance;
  }
}

}  // namespace mm
