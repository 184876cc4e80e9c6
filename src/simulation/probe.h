#pragma once
#include <Eigen/Core>

namespace mm {

/// A touch probe whose stylus carrier rests on seats: it trips later where the seats resist more (lobing).
class SeatedProbe {
 public:
  /// @param seats 2, 3 or 4. @param size m, amplitude of the harmonic of that order. @param phase rad about
  /// the stylus.
  void setLobing(int seats, double size, double phase);
  /// Pre-travel (m), less its mean, which a probe's calibration takes out. @param push direction of the push
  /// on the surface, axes of probe_tip, unit vector.
  double preTravel(const Eigen::Vector3d& push) const;

  double radiusError = 0.0;   // m, true less stated tip radius
  double wear = 0.0;          // m/s, of the radius
  double triggerDelay = 0.0;  // s from the contact to the latch

 private:
  static constexpr int kHarmonics = 4;
  int seats_ = 0;
  double phase_ = 0.0;
  double lobes_[kHarmonics] = {};  // m, of cos(m * seats * azimuth), m from 1
};

/// A one-dimensional laser probe: what it reads for a true distance.
struct LaserProbe {
  double scale = 0.0;      // 1: relative error of the reading
  double incidence = 0.0;  // m: reading error at grazing incidence, grows with the square of the angle's sine
  /// Reading (m) for the true distance (m) along the beam. @param cosine of the angle between beam and
  /// surface normal.
  double read(double distance, double cosine) const;
  /// The true distance (m) of a reading.
  double distanceOf(double reading, double cosine) const;
};

}  // namespace mm
