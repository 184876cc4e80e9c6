#include "base/random.h"

#include <cmath>

#include "base/unit_random.h"
#include "base/units.h"

namespace mm {
namespace {

std::uint64_t mix(std::uint64_t seed, const std::string& name) {  // FNV-1a
  std::uint64_t hash = 1469598103934665603ULL;
  for (int i = 0; i < 8; ++i) hash = (hash ^ ((seed >> (8 * i)) & 0xff)) * 1099511628211ULL;
  for (const unsigned char c : name) hash = (hash ^ c) * 1099511628211ULL;
  return hash;
}

}  // namespace

Random::Random(std::uint64_t seed, const std::string& stream) : engine_(mix(seed, stream)) {}

double Random::uniform() { return unitRandom(engine_); }

double Random::uniform(double lower, double upper) { return lower + (upper - lower) * uniform(); }

double Random::logUniform(double lower, double upper) {
  const double part = uniform();
  return lower == upper ? lower : lower * std::pow(upper / lower, part);
}

double Random::normal() {
  if (hasSpare_) {
    hasSpare_ = false;
    return spare_;
  }
  const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));
  const double angle = 2.0 * kPi * uniform();
  spare_ = radius * std::sin(angle);
  hasSpare_ = true;
  return radius * std::cos(angle);
}

double Random::student(double degreesOfFreedom) {
  // Bailey's polar method
  for (;;) {
    const double u = 2.0 * uniform() - 1.0, v = 2.0 * uniform() - 1.0, w = u * u + v * v;
    if (w >= 1.0 || w == 0.0) continue;
    const double t = u * std::sqrt(degreesOfFreedom * (std::pow(w, -2.0 / degreesOfFreedom) - 1.0) / w);
    return degreesOfFreedom > 2.0 ? t * std::sqrt((degreesOfFreedom - 2.0) / degreesOfFreedom) : t;
  }
}

int Random::below(int count) { return static_cast<int>(uniform() * count); }

}  // namespace mm
