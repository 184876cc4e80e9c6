#pragma once
#include <vector>

#include "base/random.h"
#include "simulation/source.h"

namespace mm {

/// A joint that slowly wanders along its own motion and follows nothing that is recorded: a random walk whose
/// pace changes, and now and then a part that settles into its place. It goes on while the machine stands.
class Wander {
 public:
  /// @param rms m or rad, about the mean over `times` (s, of the measurements; none: an hour, evenly).
  Wander(int joint, double rms, const std::vector<double>& times, Random& random);
  void operator()(const Condition& condition, Distortion& distortion) const;  ///< a Source
  /// m or rad at a time in s; beyond a quarter more than the time asked for it stays where it is.
  double at(double time) const;

 private:
  int joint_;
  double spacing_ = 1.0;  // s, of the values
  std::vector<double> value_;
};

}  // namespace mm
