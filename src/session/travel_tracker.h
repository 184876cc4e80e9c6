#pragma once
#include <cstdint>
#include <vector>

#include "machine/machine.h"
#include "session/session.h"

namespace mm {

/// A joint slower than this (m/s or rad/s) is at rest: an encoder that stands still says a few nm/s.
inline constexpr double kStandstill = 1e-6;

/// -1 or +1, the sign of a velocity of a joint that moves; 0 at rest, and where it is not known (NaN).
double directionOf(double velocity);

/// By how much a joint must come back before its direction of travel has changed: 1 um, or 10 urad.
double travelDeadband(JointKind kind);

/// Fills `travel` of each observation in the order of time: the sign of the velocity; at standstill what the
/// reader already put there, else the direction of that joint's last motion in earlier rows; 0 where never
/// known. @param byTheWay a joint that was elsewhere in the row before came straight from there; else it is
/// not known how it came.
void deriveTravel(std::vector<Observation>& observations, int joints, bool byTheWay = false);

/// Direction of travel of one joint, from its readings as they come. It is that of the motion, never of the
/// sign of a velocity alone: a reversal counts when the joint has come back from its farthest reading by more
/// than the deadband. Where readings are further apart than a motion lasts (a log, a simulation's turning
/// points), the velocity of a joint that moves counts, as the readings cannot show what was between them.
class TravelTracker {
 public:
  explicit TravelTracker(double deadband) : deadband_(deadband) {}  ///< m or rad

  /// @param stamp ns, ascending. @param position m or rad; not a number: nothing is learned.
  /// @param velocity m/s or rad/s; NaN: not known. @return true when the direction changed.
  bool take(std::int64_t stamp, double position, double velocity);
  /// As another tells it (-1 or +1), who saw the joint move until `stamp`: a reversal that was seen here
  /// after that stays.
  void tell(std::int64_t stamp, double direction);
  void forget() { *this = TravelTracker(deadband_); }  ///< knows nothing any more
  /// The next reading counts from another zero, after a homing: between them nothing moved.
  void countAnew() { anotherZero_ = started_; }

  double direction() const { return direction_; }  ///< -1, +1; 0: not known
  /// m or rad from the last reversal, or from where this began to look: so much at the least. NaN: it was not
  /// seen to move.
  double sinceReversal() const;
  /// m or rad that it has come back from its farthest reading, within the deadband: noise, or the beginning
  /// of a reversal.
  double back() const;

 private:
  bool turn(double direction, double from);

  double deadband_;
  std::int64_t last_ = 0, turned_ = 0;  // stamps of the last reading and of the last reversal
  bool started_ = false, anotherZero_ = false;
  double direction_ = 0.0, position_ = 0.0, farthest_ = 0.0, turn_ = 0.0;
  double low_ = 0.0, high_ = 0.0;  // while no direction is known
};

}  // namespace mm
