#include "simulation/probe.h"

#include <cmath>

#include "base/units.h"

namespace mm {
namespace {

/// Lever from the stylus' axis to the edge between two seats over which the carrier tips when it is pushed to
/// `azimuth`.
double seatLever(int seats, double azimuth) {
  if (seats == 2) return std::sqrt(1.0 + 0.6 * std::cos(2.0 * azimuth));
  const double sector = 2.0 * kPi / seats;
  return std::cos(0.5 * sector) / std::cos(std::remainder(azimuth, sector));
}

}  // namespace

void SeatedProbe::setLobing(int seats, double size, double phase) {
  seats_ = seats;
  phase_ = phase;
  constexpr int kSteps = 720;
  double cosines[kHarmonics] = {};
  for (int i = 0; i < kSteps; ++i) {
    const double azimuth = 2.0 * kPi * i / kSteps;
    for (int m = 0; m < kHarmonics; ++m)
      cosines[m] += seatLever(seats, azimuth) * std::cos((m + 1) * seats * azimuth);
  }
  // The carrier yields a little before it tips, which rounds the lobes: a mean over the neighbouring
  // directions.
  constexpr double kRounding = 25.0 * kDegree;
  for (int m = 0; m < kHarmonics; ++m) {
    const double width = (m + 1) * seats * kRounding;
    lobes_[m] = cosines[m] * std::sin(width) / width;
  }
  const double first = std::abs(lobes_[0]);
  for (double& lobe : lobes_) lobe *= size / first;
}

double SeatedProbe::preTravel(const Eigen::Vector3d& push) const {
  const double across = std::hypot(push.x(), push.y());  // cosine of the elevation
  constexpr double kAxial = 1e-12;                       // cosine: a push along the stylus has no azimuth
  if (seats_ == 0 || across < kAxial) return 0.0;
  // The force that lifts the carrier off its seats bends the stylus; an axial push lifts it at once.
  const double azimuth = std::atan2(push.y(), push.x()) - phase_;
  double sum = 0.0;
  for (int m = 0; m < kHarmonics; ++m) sum += lobes_[m] * std::cos((m + 1) * seats_ * azimuth);
  return across * sum;
}

double LaserProbe::read(double distance, double cosine) const {
  return (distance - incidence * (1.0 - cosine * cosine)) / (1.0 + scale);
}

double LaserProbe::distanceOf(double reading, double cosine) const {
  return reading * (1.0 + scale) + incidence * (1.0 - cosine * cosine);
}

}  // namespace mm
