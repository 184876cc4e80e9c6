#pragma once
#include "simulation/profile.h"
#include "simulation/source.h"

namespace mm {

/// Backlash as a play operator: the slide stands still until the drive has taken up the clearance, then
/// follows it.
class Play {
 public:
  explicit Play(double gap = 0.0) : gap_(gap) {}  ///< gap in m or rad
  double gap() const { return gap_; }             ///< m or rad
  double slide() const { return slide_; }         ///< where the slide is, m or rad
  /// Puts the slide in the middle of its clearance.
  void centre(double drive) { slide_ = drive; }
  /// Where the slide is after the drive has gone straight (monotonically) to `drive`; the state is kept.
  double after(double drive) const;
  void follow(double drive) { slide_ = after(drive); }

 private:
  double gap_;  // full reversal, m or rad
  double slide_ = 0.0;
};

/// Periodic lead variation: the lead's deviation along the screw, with a second harmonic, summed up over the
/// travel.
class PeriodicLead : public Source {
 public:
  /// @param amplitude m, of the position error; @param period m of travel.
  PeriodicLead(int joint, double amplitude, double period, double phase);
  void apply(const Condition& condition, Distortion& distortion) const override;

 private:
  int joint_;
  double rate_, wave_, phase_;
};

/// Slow cumulated lead error of a screw or scale: the integral of a wandering lead.
class CumulatedLead : public Source {
 public:
  CumulatedLead(int joint, Profile profile) : joint_(joint), profile_(std::move(profile)) {}
  void apply(const Condition& condition, Distortion& distortion) const override;

 private:
  int joint_;
  Profile profile_;
};

/// Wrong mean lead, or scale.
class ScaleError : public Source {
 public:
  ScaleError(int joint, double scale) : joint_(joint), scale_(scale) {}
  void apply(const Condition& condition, Distortion& distortion) const override;

 private:
  int joint_;
  double scale_;
};

}  // namespace mm
