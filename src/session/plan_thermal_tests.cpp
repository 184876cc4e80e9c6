// The tests of ISO 230-3: readings at regular times, for hours.
#include <algorithm>
#include <cmath>
#include <functional>

#include "base/format.h"
#include "base/tiny.h"
#include "machine/linear_inverse.h"
#include "session/plan_test_sheet.h"

namespace mm {
namespace {

constexpr double kMinute = 60.0, kMinutesOfHour = 60.0;
constexpr double kRest = 0.25;  // of the hours of load: how long it is watched while it cools

/// Readings that fill so many hours: as often as said, or a little less.
struct Schedule {
  int count = 0;
  double interval = 0.0;  // s
};

Schedule scheduleOf(const TestSheet& t, double hours) {
  const double minutes = hours * kMinutesOfHour;
  const int count = std::max(1, static_cast<int>(minutes / t.size.everyMin + kOfAWhole));
  return {count, minutes * kMinute / count};
}

/// A reading, and another after each interval of load, in which the joint goes to and fro as often as there
/// is time. @param taken s of the interval, by the reading. @param read one, after a wait (s).
void readUnderLoad(TestSheet& t, int j, double taken, const std::function<void(double)>& read) {
  const Stretch s = stretchOf(t, j);
  const Schedule load = scheduleOf(t, t.size.hours);
  const double once = 2.0 * s.length() / t.pace(j);  // s to and fro
  const int swings = static_cast<int>((load.interval - taken) / once + kOfAWhole);
  if (swings < 1) {
    const double shortest = std::ceil((taken + once) / kMinute * 10.0) / 10.0;
    t.refuse(format("needs %s or more: a reading and once to and fro of joint %s take %.4g min",
                    t.size.everyMin < shortest ? format("--every-min %.4g", shortest).c_str()
                                               : format("--hours %.4g", shortest / kMinutesOfHour).c_str(),
                    t.joint(j).name.c_str(), (taken + once) / kMinute));
  }
  read(0.0);
  t.script.repeat(load.count, [&] {
    t.script.repeat(swings, [&] {
      t.script.go(t.with(j, s.to));
      t.script.go(t.with(j, s.from));
    });
    read(std::max(0.0, load.interval - taken - swings * once));
  });
}

/// Readings in the middle, for so many hours.
void readFor(TestSheet& t, double hours) {
  const Schedule readings = scheduleOf(t, hours);
  t.script.repeat(readings.count, [&] { t.script.position(t.middle, readings.interval, t.test.name); });
}

}  // namespace

void writeEtve(TestSheet& t) {
  t.head += "instrument: {thermal: {ambient: {swing_K: 1, swing_period_min: 1440}}}  # simulated room\n";
  t.script.position(t.middle, kTestDwell, t.test.name);
  readFor(t, t.size.hours);
}

void writeSpindle(TestSheet& t) {
  const double from = 1.0, to = t.size.hours * kMinutesOfHour + from;  // min
  t.head += format(
      "instrument:  # simulated spindle\n"
      "  covariates: [{name: spindle, unit: rpm, mean: 10000, from_min: %.6g, to_min: %.6g}]\n"
      "  thermal: {heat: [{body: motor, power_W: 4, from_min: %.6g, to_min: %.6g}]}\n",
      from, to, from, to);
  t.script.position(t.middle, kTestDwell, t.test.name);
  t.script.remark("start the spindle; its speed is recorded as covariate spindle, unit rpm");
  readFor(t, t.size.hours);
  t.script.remark("stop the spindle");
  readFor(t, kRest * t.size.hours);
}

void writeLinear(TestSheet& t) {
  const std::vector<int> axes = linearJoints(t.machine.joints());
  if (axes.empty()) t.refuse("needs a linear axis, and the machine has none");
  t.rapid = t.slowest(JointKind::kLinear);
  for (const int j : axes) {
    const Stretch s = stretchOf(t, j);
    const auto read = [&](double wait) {
      t.script.go(t.with(j, s.from - t.beyond(j)), wait);
      for (const double share : {0.0, 0.5, 1.0})
        t.script.deviation(j, t.with(j, s.at(share)), kTestDwell, t.joint(j).name);
    };
    // A reading ends at the far end; the ways to and from it are once to and fro, of the swings or of it
    // alone.
    const double taken = 3.0 * kTestDwell + 2.0 * t.beyond(j) / t.pace(j),
                 once = 2.0 * s.length() / t.pace(j);
    readUnderLoad(t, j, taken, read);
    const Schedule cooling = scheduleOf(t, kRest * t.size.hours);
    t.script.repeat(cooling.count, [&] { read(std::max(0.0, cooling.interval - taken - once)); });
  }
}

void writeRotary(TestSheet& t) {
  for (const int j : t.rotaryJoints()) {
    const auto read = [&](double wait) {
      t.script.go(t.with(j, t.middle[static_cast<std::size_t>(j)] - t.beyond(j)), wait);
      t.script.position(t.middle, kTestDwell, t.joint(j).name);
    };
    readUnderLoad(t, j, kTestDwell, read);
    const Schedule cooling = scheduleOf(t, kRest * t.size.hours);
    t.script.repeat(cooling.count, [&] { t.script.position(t.middle, cooling.interval, t.joint(j).name); });
  }
}

}  // namespace mm
