#pragma once
#include <random>
#include <string>

namespace mm {

/// Readings of an instrument along x, an axis with a scale error of 400 um/m: three cycles over nine
/// positions, both ways, noise of 0.3 um.
inline std::string axisCsv(unsigned seed) {
  std::string csv = "time_s,x_mm,x_velocity_mm_s,deviation_x_um\n";
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> noise(-0.5, 0.5);
  int time = 0;
  for (int cycle = 0; cycle < 3; ++cycle)
    for (const int way : {1, -1})
      for (int i = 0; i < 9; ++i) {
        const double x = way * (-20.0 + 5.0 * i);
        csv += std::to_string(time++) + "," + std::to_string(x) + "," + std::to_string(way) + "," +
               std::to_string(0.4 * x + noise(random)) + "\n";
      }
  return csv;
}

}  // namespace mm
