#include "simulation/probe.h"

#include <cmath>

#include "machine/units.h"

namespace mm {

double SeatedProbe::resistance(double azimuth) const {
  // Lever from the stylus' axis to the edge between two seats over which the carrier tips, in the direction
  // pushed.
  if (seats_ == 2) return std::sqrt(1.0 + 0.6 * std::cos(2.0 * azimuth));
  const double sector = 2.0 * kPi / seats_;
  const double fromEdge = std::remainder(azimuth, sector);
  return std::cos(0.5 * sector) / std::cos(fromEdge);
}

void SeatedProbe::setLobing(int seats, double size, double phase) {
  seats_ = seats;
  phase_ = phase;
  constexpr int kSteps = 720;
  double cosine = 0.0;
  mean_ = 0.0;
  for (int i = 0; i < kSteps; ++i) {
    const double azimuth = 2.0 * kPi * i / kSteps;
    mean_ += resistance(azimuth) / kSteps;
    cosine += 2.0 * resistance(azimuth) * std::cos(seats * azimuth) / kSteps;
  }
  size_ = size / std::abs(cosine);
}

double SeatedProbe::preTravel(const Eigen::Vector3d& push) const {
  const double across = std::hypot(push.x(), push.y());  // cosine of the elevation
  if (seats_ == 0 || across < 1e-12) return 0.0;
  // The force that lifts the carrier off its seats bends the stylus; an axial push lifts it at once.
  return size_ * across * (resistance(std::atan2(push.y(), push.x()) - phase_) - mean_);
}

double LaserProbe::read(double distance, double cosine) const {
  return (distance - incidence * (1.0 - cosine * cosine)) / (1.0 + scale);
}

double LaserProbe::distanceOf(double reading, double cosine) const {
  return reading * (1.0 + scale) + incidence * (1.0 - cosine * cosine);
}

void LaserMount::apply(const Condition&, Distortion& distortion) const {
  distortion.probeShift += zero_;
  distortion.beamTilt += beam_;
}

}  // namespace mm
