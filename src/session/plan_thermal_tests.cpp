// The tests of ISO 230-3: readings at regular times, for hours.
#include <algorithm>
#include <cmath>

#include "base/format.h"
#include "machine/linear_inverse.h"
#include "session/plan_test_sheet.h"

namespace mm {
namespace {

constexpr double kMinute = 60.0, kMinutesOfHour = 60.0;
constexpr double kRest = 0.25;  // of the hours of load: how long it is watched while it cools

/// How many readings there are in so many hours.
int readingsIn(const TestSheet& t, double hours) {
  return std::max(1, static_cast<int>(std::lround(hours * kMinutesOfHour / t.size.everyMin)));
}

/// To and fro between the ends for the time between two readings. @param taken s of that time, by reading.
void swing(TestSheet& t, int j, const Stretch& s, double taken) {
  const double once = 2.0 * s.length() / t.pace(j);
  t.script.repeat(std::max(1, static_cast<int>((t.size.everyMin * kMinute - taken) / once)), [&] {
    t.script.go(t.with(j, s.to));
    t.script.go(t.with(j, s.from));
  });
}

}  // namespace

void writeEtve(TestSheet& t) {
  t.head += "instrument: {thermal: {ambient: {swing_K: 1, swing_period_min: 1440}}}  # simulated room\n";
  t.script.position(t.middle, kTestDwell, t.test.name);
  t.script.repeat(readingsIn(t, t.size.hours),
                  [&] { t.script.position(t.middle, t.size.everyMin * kMinute, t.test.name); });
}

void writeSpindle(TestSheet& t) {
  const double from = 1.0, to = t.size.hours * kMinutesOfHour + from;  // min
  t.head += format(
      "instrument:  # simulated spindle\n"
      "  covariates: [{name: spindle, unit: rpm, mean: 10000, from_min: %.6g, to_min: %.6g}]\n"
      "  thermal: {heat: [{body: motor, power_W: 4, from_min: %.6g, to_min: %.6g}]}\n",
      from, to, from, to);
  const auto read = [&] { t.script.position(t.middle, t.size.everyMin * kMinute, t.test.name); };
  t.script.position(t.middle, kTestDwell, t.test.name);
  t.script.remark("start the spindle; its speed is recorded as covariate spindle, unit rpm");
  t.script.repeat(readingsIn(t, t.size.hours), read);
  t.script.remark("stop the spindle");
  t.script.repeat(readingsIn(t, kRest * t.size.hours), read);
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
    const double taken = 3.0 * kTestDwell, backAndForth = 2.0 * s.length() / t.pace(j);
    read(0.0);
    t.script.repeat(readingsIn(t, t.size.hours), [&] {
      swing(t, j, s, taken);
      read(0.0);
    });
    t.script.repeat(readingsIn(t, kRest * t.size.hours),
                    [&] { read(std::max(0.0, t.size.everyMin * kMinute - taken - backAndForth)); });
  }
}

void writeRotary(TestSheet& t) {
  for (const int j : t.rotaryJoints()) {
    const Stretch s = stretchOf(t, j);
    const auto read = [&] {
      t.script.go(t.with(j, t.middle[static_cast<std::size_t>(j)] - t.beyond(j)));
      t.script.position(t.middle, kTestDwell, t.joint(j).name);
    };
    read();
    t.script.repeat(readingsIn(t, t.size.hours), [&] {
      swing(t, j, s, kTestDwell);
      read();
    });
    t.script.repeat(readingsIn(t, kRest * t.size.hours),
                    [&] { t.script.position(t.middle, t.size.everyMin * kMinute, t.joint(j).name); });
  }
}

}  // namespace mm
