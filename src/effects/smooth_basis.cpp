#include "effects/smooth_basis.h"

#include <algorithm>
#include <cmath>

#include "base/units.h"

namespace mm {

SmoothBasis::SmoothBasis(int functions, double smoothness) {
  priorStd_.push_back(1.0);
  for (int k = 1; k < functions; ++k) {
    Mode mode;
    mode.even = k % 2 == 1;
    // the k-th root of cos(2 w) cosh(2 w) = 1: tanh is 1 but for little, so the iteration ends in a few steps
    mode.wave = (2 * k + 1) * kPi / 4.0;
    const double turns = kPi * (mode.even ? (k + 1) / 2 : k / 2);
    for (int step = 0; step < 30; ++step)
      mode.wave = turns + (mode.even ? -1.0 : 1.0) * std::atan(std::tanh(mode.wave));
    mode.atEnd = mode.even ? std::cos(mode.wave) : std::sin(mode.wave);
    modes_.push_back(mode);
    priorStd_.push_back(std::pow(modes_.front().wave / mode.wave, smoothness));
  }
  double square = 0.0;
  for (const double s : priorStd_) square += s * s;
  for (double& s : priorStd_) s /= std::sqrt(square);
}

void SmoothBasis::values(double u, double* out) const {
  const double z = std::clamp(u, -1.0, 1.0);  // NaN stays
  *out++ = std::sqrt(3.0) * z;
  for (const Mode& mode : modes_) {
    // cosh(w z) / cosh(w) and sinh(w z) / sinh(w) without their overflow
    const double far = std::exp(-2.0 * mode.wave * std::abs(z)), end = std::exp(-2.0 * mode.wave);
    const double decay = std::exp(mode.wave * (std::abs(z) - 1.0));
    *out++ = mode.even
                 ? std::cos(mode.wave * z) / mode.atEnd + decay * (1.0 + far) / (1.0 + end)
                 : std::sin(mode.wave * z) / mode.atEnd + std::copysign(decay * (1.0 - far) / (1.0 - end), z);
  }
}

}  // namespace mm
