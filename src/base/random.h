#pragma once
#include <cstdint>
#include <random>
#include <string>

namespace mm {

/// Random numbers of one purpose: streams of different names are independent, so that hiding one more source
/// does not change the noise of the others. The same seed and name give the same bits everywhere, which no
/// standard promises of the distributions of the C++ library or of Boost.
class Random {
 public:
  Random(std::uint64_t seed, const std::string& stream);

  double uniform();                               ///< in [0, 1)
  double uniform(double lower, double upper);     ///< from lower to upper
  double logUniform(double lower, double upper);  ///< both above 0, or equal
  double normal();                                ///< mean 0, standard deviation 1
  /// Student's t, scaled to standard deviation 1 where it has one (more than two degrees of freedom).
  double student(double degreesOfFreedom);
  int below(int count);  ///< 0 … count - 1
  double sign() { return uniform() < 0.5 ? -1.0 : 1.0; }

 private:
  std::mt19937_64 engine_;
  double spare_ = 0.0;
  bool hasSpare_ = false;
};

}  // namespace mm
