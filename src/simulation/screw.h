#pragma once
#include "simulation/source.h"

namespace mm {

/// Backlash as a play operator: the slide stands still until the drive has taken up the clearance, then
/// follows it.
class Play {
 public:
  explicit Play(double gap = 0.0) : gap_(gap) {}  ///< gap in m or rad
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
/// travel. @param amplitude m, of the position error. @param period m of travel. @param phase rad.
Source periodicLead(int joint, double amplitude, double period, double phase);

}  // namespace mm
