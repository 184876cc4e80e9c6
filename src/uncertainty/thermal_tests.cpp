#include "uncertainty/thermal_tests.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <map>
#include <tuple>

#include "base/erase_if.h"
#include "base/format.h"
#include "base/range.h"
#include "base/units.h"
#include "machine/joint_units.h"
#include "uncertainty/positioning_figures.h"
#include "uncertainty/setup_rows.h"

namespace mm {
namespace {

constexpr double kSecondsPerHour = 3600.0;
constexpr std::size_t kFewestReadings = 5;   // at one place
constexpr double kShortestTest = 600.0;      // s, while a temperature changes
constexpr double kShortestAlone = 3540.0;    // s, without one: an hour less a minute
constexpr double kSeenWarming = 0.5;         // K
constexpr std::size_t kMostPlacesAlone = 4;  // ISO 230-2 has five targets or more

using Rows = std::vector<int>;                                  // observations, in the order of time
using Key = std::tuple<int, int, int, int, std::vector<bool>>;  // recording, setup, placement, kind, measured

std::vector<double> measuredBy(const Observation& o) {
  if (o.kind == ObservationKind::kDeviation) return o.deviation;
  if (o.kind != ObservationKind::kPosition) return {};
  return {o.reference.x(), o.reference.y(), o.reference.z()};
}

/// Rows of one instrument that measured the same components with the same zero.
std::map<Key, Rows> rowsOfOneKind(const Session& session) {
  std::map<Key, Rows> groups;
  for (std::size_t i = 0; i < session.observations.size(); ++i) {
    const Observation& o = session.observations[i];
    std::vector<bool> has;
    for (const double v : measuredBy(o)) has.push_back(std::isfinite(v));
    if (std::find(has.begin(), has.end(), true) == has.end()) continue;
    groups[{o.recording, o.setup, o.placement, static_cast<int>(o.kind), has}].push_back(i);
  }
  return groups;
}

/// The rotary joint that travelled while the rows stay in one place; -1: none.
int swungJoint(const Session& session, const Rows& rows) {
  const std::vector<Joint>& joints = session.machine.joints();
  const int setup = session.observations[rows.front()].setup;
  const std::string named = setup >= 0 ? session.setups[setup] : "";
  std::vector<int> travelled;
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const bool travels = std::any_of(rows.begin(), rows.end(),
                                     [&](int i) { return session.observations[i].travel[j] != 0.0; });
    if (travels && joints[j].name == named && joints[j].kind == JointKind::kRotary) return j;
    if (travels) travelled.push_back(j);
  }
  return singleRotary(session, travelled);
}

bool isSpeed(const Series& s) { return s.unit == "rpm" || s.unit == "1/min"; }

/// The covariate of a spindle that turned between two times (s); null: none did.
const Series* turningSpindle(const Session& session, double from, double to) {
  for (const Series& s : session.covariates)
    for (std::size_t i = 0; isSpeed(s) && i < s.time.size(); ++i)
      if (s.time[i] >= from && s.time[i] <= to && s.value[i] > 0.0) return &s;
  return nullptr;
}

/// From the last value at rest before it turned to the last that is not at rest.
HeatedTime turningTime(const Series& speed, double from, double to) {
  double begin = kNotMeasured, rest = from, end = to;
  for (std::size_t i = 0; i < speed.time.size(); ++i) {
    if (speed.time[i] < from || speed.time[i] > to) continue;
    const bool turns = speed.value[i] > 0.0;
    if (turns && std::isnan(begin)) begin = rest;
    if (turns) end = speed.time[i];
    if (!turns && std::isnan(begin)) rest = speed.time[i];
  }
  return {begin / kSecondsPerHour, end / kSecondsPerHour};
}

bool warms(const Session& session, double from, double to) {
  return std::any_of(session.temperatures.begin(), session.temperatures.end(), [&](const Series& s) {
    Range range;
    for (std::size_t i = 0; i < s.time.size(); ++i)
      if (s.time[i] >= from && s.time[i] <= to) range.add(s.value[i]);
    return range.any() && range.size() >= kSeenWarming;
  });
}

/// Rows that were reached from the side from which most were: play is no drift.
Rows fromOneSide(const Session& session, const Rows& rows, std::size_t joint) {
  Rows forward, backward;
  for (const int i : rows) {
    const double travel = session.observations[i].travel[joint];
    if (travel >= 0.0) forward.push_back(i);
    if (travel <= 0.0) backward.push_back(i);
  }
  return forward.size() >= backward.size() ? forward : backward;
}

/// Rows by the place of one joint, ascending, each in the order of time; those of few readings are left out.
std::vector<Rows> placesAlong(const Session& session, Rows rows, std::size_t joint) {
  const auto at = [&](int i) { return session.observations[i].position[joint]; };
  std::stable_sort(rows.begin(), rows.end(), [&](int a, int b) { return at(a) < at(b); });
  const double tolerance = kSameTarget * (at(rows.back()) - at(rows.front()));
  std::vector<Rows> places;
  double first = 0.0;
  for (const int i : rows) {
    if (places.empty() || at(i) - first > tolerance) {
      places.emplace_back();
      first = at(i);
    }
    places.back().push_back(i);
  }
  for (Rows& place : places) {
    std::sort(place.begin(), place.end());
    place = fromOneSide(session, place, joint);
  }
  eraseIf(places, [](const Rows& place) { return place.size() < kFewestReadings; });
  return places;
}

/// The same without the first that is finite.
std::vector<double> fromTheFirst(std::vector<double> values) {
  const auto first = std::find_if(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
  const double zero = first != values.end() ? *first : 0.0;
  for (double& v : values) v -= zero;
  return values;
}

/// One component at one place. Of a position it is that beside the nominal one, so that readings that differ
/// by their noise do not count.
ThermalCourse courseAt(const Session& session, const Rows& place, int component, bool angular,
                       const ResidualOf& left) {
  ThermalCourse course;
  const double unit = angular ? kArcsecond : kMicrometre;
  for (const int i : place) {
    const Observation& o = session.observations[i];
    double value = measuredBy(o)[component];
    if (o.kind == ObservationKind::kPosition) value -= session.nominalProbe(o).position[component];
    course.measured.hours.push_back(o.time / kSecondsPerHour);
    course.measured.value.push_back(value / unit);
    if (left) course.left.push_back(left(i, component) / unit);
  }
  course.measured.value = fromTheFirst(std::move(course.measured.value));
  course.left = fromTheFirst(std::move(course.left));
  return course;
}

/// The farther place minus the nearer one, at the times of the nearer: along the straight line through two
/// readings of the farther, which are no more than a step away.
ThermalCourse differenceOf(const ThermalCourse& near, const ThermalCourse& far) {
  ThermalCourse course;
  course.direction = near.direction;
  course.between = true;
  const std::vector<double>& hours = far.measured.hours;
  const auto mixed = [](const std::vector<double>& values, std::size_t next, double w) {
    return w * values[next - 1] + (1.0 - w) * values[next];
  };
  for (std::size_t i = 0; i < near.measured.hours.size(); ++i) {
    const double hour = near.measured.hours[i];
    const auto found = std::upper_bound(hours.begin(), hours.end() - 1, hour) - hours.begin();
    const auto next = std::max<std::size_t>(1, found);
    const double step = hours[next] - hours[next - 1];
    const double w = step > 0.0 ? (hours[next] - hour) / step : 1.0;
    if (w < -1.0 || w > 2.0) continue;
    course.measured.hours.push_back(hour);
    course.measured.value.push_back(mixed(far.measured.value, next, w) - near.measured.value[i]);
    if (!near.left.empty()) course.left.push_back(mixed(far.left, next, w) - near.left[i]);
  }
  course.measured.value = fromTheFirst(std::move(course.measured.value));
  course.left = fromTheFirst(std::move(course.left));
  return course;
}

std::string directionOf(const Session& session, bool position, int component) {
  constexpr std::array<const char*, 3> kAxes = {"x", "y", "z"};
  return position ? kAxes[component] : session.machine.joints()[component].name;
}

std::string placeText(const ThermalTest& test, double at) {
  return format("%.4g %s", std::abs(at) < 1e-9 ? 0.0 : at, test.rotary ? "deg" : "mm");
}

/// The difference of the first and last place along the direction in which the joint moves most.
void addExpansion(ThermalTest& test, const Session& session, const std::vector<Rows>& places, bool position) {
  const auto probe = [&](const Rows& rows) {
    return session.nominalProbe(session.observations[rows.front()]).position;
  };
  int along = 0;
  (probe(places.back()) - probe(places.front())).cwiseAbs().maxCoeff(&along);
  const std::string direction = position ? directionOf(session, true, along) : test.joint;
  const auto is = [&](const ThermalCourse& c) { return c.direction == direction; };
  const auto first = std::find_if(test.courses.begin(), test.courses.end(), is);
  const auto last = std::find_if(test.courses.rbegin(), test.courses.rend(), is);
  if (first == test.courses.end() || &*first == &*last) return;
  ThermalCourse course = differenceOf(*first, *last);
  course.name = "between " + placeText(test, first->at) + " and " + placeText(test, last->at);
  if (course.measured.hours.size() >= kFewestReadings) test.courses.push_back(std::move(course));
}

/// Up to the largest displacement of the course that moves most.
HeatedTime heatedTimeOf(const std::vector<ThermalCourse>& courses) {
  const ThermalCourse* most = nullptr;
  double largest = -1.0;
  for (const ThermalCourse& c : courses) {
    Range range;
    for (const double v : c.measured.value) range.add(v);
    if (range.size() <= largest) continue;
    largest = range.size();
    most = &c;
  }
  return most == nullptr ? HeatedTime{} : heatedTime(most->measured);
}

/// Courses of each component at the first, the middle and the last place.
void addCourses(ThermalTest& test, const Session& session, const std::vector<Rows>& places, int joint,
                const ResidualOf& left) {
  std::vector<std::size_t> shown = {0, places.size() / 2, places.size() - 1};
  shown.erase(std::unique(shown.begin(), shown.end()), shown.end());
  const Observation& any = session.observations[places.front().front()];
  const bool position = any.kind == ObservationKind::kPosition;
  const std::vector<double> values = measuredBy(any);
  const auto isAngular = [&](int k) {
    return !position && session.machine.joints()[k].kind == JointKind::kRotary;
  };
  std::vector<int> components;
  for (int k = 0; k < static_cast<int>(values.size()); ++k)
    if (std::isfinite(values[k])) components.push_back(k);
  test.angular = std::all_of(components.begin(), components.end(), isAngular);
  for (const std::size_t p : shown)
    for (const int k : components) {
      if (isAngular(k) != test.angular) continue;
      ThermalCourse course = courseAt(session, places[p], k, test.angular, left);
      course.direction = directionOf(session, position, k);
      course.name = course.direction;
      for (char& c : course.name) c = position ? static_cast<char>(std::toupper(c)) : c;
      if (joint >= 0 && shown.size() > 1) {
        const Joint& moving = session.machine.joints()[joint];
        course.at = session.observations[places[p].front()].position[joint] / readingUnit(moving).factor;
        course.name = (components.size() > 1 ? course.name + " at " : "") + placeText(test, course.at);
      }
      test.courses.push_back(std::move(course));
    }
  if (test.kind == ThermalTestKind::kLinearAxis && shown.size() > 1)
    addExpansion(test, session, places, position);
}

}  // namespace

std::vector<ThermalTest> thermalTests(const Session& session, const ResidualOf& left) {
  std::vector<ThermalTest> tests;
  for (const auto& [key, rows] : rowsOfOneKind(session)) {
    const std::vector<int> moved = movedJoints(session, rows);
    if (moved.size() > 1 || rows.size() < kFewestReadings) continue;
    const double from = session.observations[rows.front()].time;
    const double to = session.observations[rows.back()].time;
    const bool warming = warms(session, from, to);
    if (to - from < (warming ? kShortestTest : kShortestAlone)) continue;
    const Series* speed = moved.empty() ? turningSpindle(session, from, to) : nullptr;
    const int joint = !moved.empty() ? moved.front() : speed == nullptr ? swungJoint(session, rows) : -1;
    const std::vector<Rows> places =
        moved.empty() ? std::vector<Rows>{rows} : placesAlong(session, rows, joint);
    if (places.empty() || (!moved.empty() && !warming && places.size() > kMostPlacesAlone)) continue;
    ThermalTest test;
    test.rotary = joint >= 0 && session.machine.joints()[joint].kind == JointKind::kRotary;
    test.kind = speed != nullptr ? ThermalTestKind::kSpindle
                : joint < 0      ? ThermalTestKind::kEnvironment
                : test.rotary    ? ThermalTestKind::kRotaryAxis
                                 : ThermalTestKind::kLinearAxis;
    if (joint >= 0) test.joint = session.machine.joints()[joint].name;
    if (speed != nullptr) test.spindle = speed->name;
    const int setup = std::get<1>(key);
    if (setup >= 0) test.setup = session.setups[setup];
    for (const Rows& place : places) test.readings += place.size();
    test.places = places.size();
    test.from = from / kSecondsPerHour;
    test.to = to / kSecondsPerHour;
    addCourses(test, session, places, joint, left);
    test.heated = speed != nullptr ? turningTime(*speed, from, to) : heatedTimeOf(test.courses);
    tests.push_back(std::move(test));
  }
  std::stable_sort(tests.begin(), tests.end(),
                   [](const ThermalTest& a, const ThermalTest& b) { return a.from < b.from; });
  return tests;
}

std::string inWords(const ThermalTest& test) {
  const std::array<std::string, 4> kinds = {
      "ETVE (idle machine)", "spindle " + format("turning for %.1f h", test.heated.to - test.heated.from),
      "linear axis " + test.joint, "rotary axis " + test.joint};
  // so many targets are those of a positioning test, of which the course in time is seen beside it
  const bool positioning = test.places > static_cast<int>(kMostPlacesAlone);
  return (positioning ? "ISO 230-2, " : "ISO 230-3, ") + kinds[static_cast<std::size_t>(test.kind)] + ": " +
         (positioning ? "displacement against time as in ISO 230-3 from " : "") +
         std::to_string(test.readings) + " readings at " +
         (test.places == 1 ? "one position" : std::to_string(test.places) + " positions") +
         format(" over %.1f h", test.to - test.from);
}

}  // namespace mm
