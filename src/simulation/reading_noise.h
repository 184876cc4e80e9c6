#pragma once
#include <vector>

#include "base/random.h"
#include "simulation/instrument_settings.h"

namespace mm {

/// Random errors of what the instrument reads: white, or rougher than that. Each channel (a joint's reading,
/// the laser's …) has a memory of its own. The same seed and the same calls give the same bits.
class ReadingNoise {
 public:
  ReadingNoise(const NoiseSettings& noise, const Roughness& rough, std::uint64_t seed, int channels);

  /// The next error of a channel. @param size m or rad: the repeatability.
  double next(int channel, double size);
  /// 0, or for a few readings by how many repeatabilities they are off.
  double wild();
  /// A value as it is read. @param size m or rad: the repeatability.
  double read(double value, double size) const;
  /// What else is random at a contact.
  Random& random() { return random_; }

 private:
  double dof_;  // 0: normal
  Roughness rough_;
  Random random_, wild_;
  std::vector<double> before_;  // of each channel, in repeatabilities; NaN: none yet
};

}  // namespace mm
