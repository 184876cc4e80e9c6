#include "session/session.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "base/erase_if.h"
#include "base/error.h"
#include "session/geometric_start.h"
#include "session/gross_rows.h"
#include "session/travel_tracker.h"

namespace mm {
namespace {

/// Where a value came from, in words for people.
std::string place(const Session& session, const Observation& o) {
  const bool own = std::filesystem::path(session.source).filename() == session.rowFile;
  return session.source + ": " +
         (own ? "line " + std::to_string(o.row) : session.rowText(o.row, o.recording));
}

void fail(const Session& session, const Observation& o, const std::string& what) {
  throw InputError(place(session, o) + ": " + what);
}

/// True when every value is a number or NaN for "not measured"; an infinite one is never meant.
template <typename Range>
bool anyInfinite(const Range& values) {
  return std::any_of(values.begin(), values.end(), [](double v) { return std::isinf(v); });
}

void checkSizes(const Session& session, Observation& o) {
  const std::size_t joints = session.machine.joints().size();
  if (o.position.size() != joints)
    fail(session, o,
         std::to_string(o.position.size()) + " joint readings, but machine '" + session.machine.name() +
             "' has " + std::to_string(joints) + " joints");
  if (o.velocity.empty()) o.velocity.assign(joints, kNotMeasured);
  if (o.velocity.size() != joints) fail(session, o, "as many velocities as joints are needed, or none");
  if (o.kind == ObservationKind::kDeviation) {
    if (o.deviation.size() != joints) fail(session, o, "one deviation a joint is needed (NaN: not measured)");
    if (o.deviationStd.empty()) o.deviationStd.assign(joints, kNotMeasured);
    if (o.deviationStd.size() != joints)
      fail(session, o, "as many deviation_std as joints are needed, or none");
  }
}

void checkValues(const Session& session, const Observation& o) {
  if (!std::isfinite(o.time)) fail(session, o, "the time is not a number");
  for (std::size_t j = 0; j < o.position.size(); ++j)
    if (!std::isfinite(o.position[j]))
      fail(session, o, "the reading of joint '" + session.machine.joints()[j].name + "' is not a number");
  if (anyInfinite(o.velocity)) fail(session, o, "a velocity is infinite");
  if (std::isinf(o.laserReading)) fail(session, o, "the laser's reading is infinite");
  if (o.setup >= static_cast<int>(session.setups.size())) fail(session, o, "its setup is not in the session");
  if (o.placement < 0 || o.placement >= session.placementCount())
    fail(session, o, "its placement is not in the session");
  if (o.stylus < 0 || (o.stylus > 0 && o.stylus >= static_cast<int>(session.artifact.styli.size())))
    fail(session, o, "its stylus is not in artifact '" + session.artifact.name + "'");
  switch (o.kind) {
    case ObservationKind::kLength:
      if (!std::isfinite(o.length)) fail(session, o, "a length is not a number");
      if (o.setup < 0 && o.length <= 0.0) fail(session, o, "a length without a setup must be above 0");
      [[fallthrough]];
    case ObservationKind::kContact:
      if (o.feature < 0 || o.feature >= static_cast<int>(session.artifact.features.size()))
        fail(session, o, "its feature is not in artifact '" + session.artifact.name + "'");
      break;
    case ObservationKind::kPosition:
      if (anyInfinite(o.reference)) fail(session, o, "a reference position is infinite");
      if (o.reference.array().isNaN().all()) fail(session, o, "no component of the reference was measured");
      break;
    case ObservationKind::kDeviation:
      if (anyInfinite(o.deviation)) fail(session, o, "a deviation is infinite");
      if (std::all_of(o.deviation.begin(), o.deviation.end(), [](double v) { return std::isnan(v); }))
        fail(session, o, "no deviation was measured");
      for (const double std : o.deviationStd)
        if (std <= 0.0 || std::isinf(std))
          fail(session, o, "a deviation's standard deviation must be above 0");
      break;
  }
}

template <typename Named>
int indexOf(const std::string& name, const std::vector<Named>& all) {
  const auto at = std::find_if(all.begin(), all.end(), [&](const Named& n) { return n.name == name; });
  return at == all.end() ? -1 : static_cast<int>(at - all.begin());
}

void checkSeries(const Session& session, const Series& series) {
  if (series.time.size() != series.value.size())
    throw InputError(session.source + ": series '" + series.name +
                     "' has unequal numbers of times and values");
  if (!std::is_sorted(series.time.begin(), series.time.end()))
    throw InputError(session.source + ": series '" + series.name + "' is not ascending in time");
  for (std::size_t i = 0; i < series.time.size(); ++i)
    if (!std::isfinite(series.time[i]) || !std::isfinite(series.value[i]))
      throw InputError(session.source + ": series '" + series.name + "': value " + std::to_string(i + 1) +
                       " is not a number");
}

/// Names in the order in which observations first have them. @param index of an observation in the names; -1:
/// it has none.
void numberAsTheyOccur(std::vector<Observation>& all, int Observation::*index,
                       std::vector<std::string>& names) {
  std::vector<int> renumbered(names.size(), -1);
  std::vector<std::string> occurred;
  for (Observation& o : all) {
    if (o.*index < 0) continue;
    int& number = renumbered[static_cast<std::size_t>(o.*index)];
    if (number < 0) {
      number = static_cast<int>(occurred.size());
      occurred.push_back(names[static_cast<std::size_t>(o.*index)]);
    }
    o.*index = number;
  }
  names = std::move(occurred);
}

/// One order whatever the session was read from: observations by time (at equal times contacts come first:
/// which of two topics speaks first is chance), series by name, setups and placements as they first occur.
void order(Session& session) {
  const auto earlier = [](const Observation& a, const Observation& b) {
    if (a.time != b.time) return a.time < b.time;
    return a.kind == ObservationKind::kContact && b.kind != ObservationKind::kContact;
  };
  auto& all = session.observations;
  if (!std::is_sorted(all.begin(), all.end(), earlier)) std::stable_sort(all.begin(), all.end(), earlier);
  for (auto* series : {&session.temperatures, &session.covariates}) {
    eraseIf(*series, [](const Series& s) { return s.time.empty(); });
    std::stable_sort(series->begin(), series->end(),
                     [](const Series& a, const Series& b) { return a.name < b.name; });
  }
  numberAsTheyOccur(all, &Observation::setup, session.setups);
  if (session.placements.empty()) return;
  numberAsTheyOccur(all, &Observation::placement, session.placements);
  if (session.placements.size() == 1 && session.placements[0].empty()) session.placements.clear();
}

}  // namespace

int Artifact::findFeature(const std::string& name) const { return indexOf(name, features); }

int Artifact::findStylus(const std::string& name) const { return indexOf(name, styli); }

double Artifact::tipRadiusOf(int stylus) const {
  return styli.empty() ? tipRadius : styli[static_cast<std::size_t>(stylus)].tipRadius;
}

double Series::at(double t) const {
  if (time.empty()) return kNotMeasured;
  const auto after = std::lower_bound(time.begin(), time.end(), t);
  if (after == time.end()) return value.back();
  const std::size_t i = after - time.begin();
  if (i == 0 || time[i] == t) return value[i];
  const double part = (t - time[i - 1]) / (time[i] - time[i - 1]);
  return value[i - 1] + part * (value[i] - value[i - 1]);
}

std::string Session::rowText(std::int64_t row, int recording) const {
  const std::string number = std::to_string(row);
  if (recordings.empty()) return rowFile.empty() ? "row " + number : "line " + number + " of " + rowFile;
  const Recording& r = recordings[static_cast<std::size_t>(recording)];
  if (!r.rowFile.empty()) return "line " + number + " of " + r.rowFile;
  return "row " + number + " of " + std::filesystem::path(r.source).filename().string();
}

bool Session::poseFree(int placement) const {
  const bool named = !placements.empty() && !placements[static_cast<std::size_t>(placement)].empty();
  return named || !artifact.poseKnown || (artifact.name.empty() && artifact.features.empty());
}

int Session::placementOf(int feature) const {
  for (const Observation& o : observations)
    if (o.feature == feature) return o.placement;
  return 0;
}

int Session::outward(const Observation& o) const {
  if (o.kind == ObservationKind::kLength) return -1;
  const bool contact = o.kind == ObservationKind::kContact;
  return contact && artifact.features[static_cast<std::size_t>(o.feature)].kind == FeatureKind::kBall ? 1 : 0;
}

double Session::ownTime(const Observation& o) const {
  return recordings.empty() ? o.time : o.time - recordings[static_cast<std::size_t>(o.recording)].begin;
}

bool Session::timed(const Observation& o) const {
  return (recordings.empty() ? timesAssumed : recordings[static_cast<std::size_t>(o.recording)].timesAssumed)
      .empty();
}

ProbePose Session::nominalProbe(const Observation& o) const {
  ProbePose pose = machine.nominal(o.position.data(), o.laserReading);
  if (artifact.styli.empty()) return pose;
  const Eigen::Vector3d& offset = artifact.styli[static_cast<std::size_t>(o.stylus)].offset;
  if (offset.allFinite()) pose.position += pose.orientation * offset;
  return pose;
}

void Session::prepare() {
  takeBackGrossRows(*this);
  for (Observation& o : observations) {
    checkSizes(*this, o);
    checkValues(*this, o);
  }
  if (observations.empty()) throw InputError(source + ": the session is empty: no contact, no reference");
  for (const Series& s : temperatures) checkSeries(*this, s);
  for (const Series& s : covariates) checkSeries(*this, s);
  order(*this);
  setGrossRowsAside(*this);
  deriveTravel(observations, machine.jointCount());
  startFreeFeatures(*this);
}

bool Session::hasLaser() const {
  return std::any_of(observations.begin(), observations.end(),
                     [](const Observation& o) { return !std::isnan(o.laserReading); });
}

}  // namespace mm
