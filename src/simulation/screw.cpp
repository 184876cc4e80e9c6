#include "simulation/screw.h"

#include <algorithm>
#include <cmath>

#include "base/units.h"

namespace mm {

double Play::after(double drive) const { return std::clamp(slide_, drive - 0.5 * gap_, drive + 0.5 * gap_); }

Source periodicLead(int joint, double amplitude, double period, double phase) {
  const double rate = amplitude * 2.0 * kPi / period, wave = 2.0 * kPi / period;
  return [=](const Condition& c, Distortion& d) {
    // d(error)/dq = rate * (cos(wave q + phase) + 0.2 cos(2 wave q)), integrated from 0 to q
    constexpr double kSecond = 0.2;
    const double turn = wave * c.drive[joint];
    d.travel[joint] +=
        rate / wave * (std::sin(turn + phase) - std::sin(phase) + 0.5 * kSecond * std::sin(2.0 * turn));
  };
}

}  // namespace mm
