#pragma once
#include <vector>

#include "base/random.h"

namespace mm {

/// A smooth random curve over a range of travel, as a guideway or a screw is left by its grinding: a few long
/// waves of falling amplitude, tabulated finely. Beyond the range it goes on with its last value.
class Profile {
 public:
  /// Waves over [lower, upper] (m or rad of travel), without a trend. @param size largest magnitude within
  /// the range.
  static Profile waves(double lower, double upper, double size, Random& random);
  /// The integral along the travel of such a curve, as a pitch error is that of the lead's; its trend is
  /// removed.
  static Profile integratedWaves(double lower, double upper, double size, Random& random);
  /// From -size to +size along the travel, mostly straight, a little wavy.
  static Profile rise(double lower, double upper, double size, Random& random);

  double at(double travel) const;  ///< m; travel in m or rad

 private:
  /// Takes the trend off the values, then makes the largest of them `size`.
  Profile(double lower, double upper, std::vector<double> values, double size);

  double lower_ = 0.0, upper_ = 0.0;
  std::vector<double> values_;
};

}  // namespace mm
