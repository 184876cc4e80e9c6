#include "uncertainty/conformity.h"

#include <algorithm>
#include <cmath>

#include "base/distributions.h"
#include "base/format.h"

namespace mm {
namespace {

double below(double limit, double value, double std) {
  if (std::isinf(limit)) return limit > 0.0 ? 1.0 : 0.0;
  return normalBelow((limit - value) / std);
}

}  // namespace

const char* nameOf(Conformity conformity) {
  static constexpr const char* kNames[] = {"conforms", "not proven", "does not conform"};
  return kNames[static_cast<std::size_t>(conformity)];
}

double probabilityWithin(double value, double std, const Specification& s) {
  if (!(std > 0.0)) return value >= s.lower && value <= s.upper ? 1.0 : 0.0;
  return below(s.upper, value, std) - below(s.lower, value, std);
}

Conformity judge(double value, double std, const Specification& s) {
  const double within = probabilityWithin(value, std, s);
  if (within >= kConformanceProbability) return Conformity::kConforms;
  return within <= 1.0 - kConformanceProbability && !(value >= s.lower && value <= s.upper)
             ? Conformity::kDoesNotConform
             : Conformity::kUndecided;
}

AcceptanceZone acceptanceZone(double std, const Specification& s) {
  AcceptanceZone zone;
  const double guard = normalQuantile(kConformanceProbability) * std;
  if (std::isinf(s.lower) || std::isinf(s.upper)) {
    zone.exists = true;
    zone.lower = s.lower + guard;
    zone.upper = s.upper - guard;
    return zone;
  }
  const double middle = 0.5 * (s.lower + s.upper);
  zone.exists = judge(middle, std, s) == Conformity::kConforms;
  if (!zone.exists) return zone;
  double inside = middle, outside = s.upper;  // the zone is symmetric about the middle
  for (int i = 0; i < 100 && std > 0.0; ++i) {
    const double between = 0.5 * (inside + outside);
    (judge(between, std, s) == Conformity::kConforms ? inside : outside) = between;
  }
  zone.upper = std > 0.0 ? inside : s.upper;
  zone.lower = 2.0 * middle - zone.upper;
  return zone;
}

double PermissibleError::at(double lengthMm) const { return std::min(a + lengthMm / k, b); }

std::string PermissibleError::inWords() const {
  std::string text = format("%.3g um", a);
  if (std::isfinite(k)) text += format(" + L/%.4g", k);
  if (std::isfinite(b)) text += format(", at most %.3g um", b);
  return text;
}

PermissibleError permissibleFor(const std::vector<TestLength>& lengths) {
  double n = 0.0, sumL = 0.0, sumE = 0.0, sumLL = 0.0, sumLE = 0.0;
  const auto most = [](const TestLength& l) { return std::abs(l.error) + 2.0 * l.std; };
  for (const TestLength& l : lengths) {
    n += 1.0;
    sumL += l.length;
    sumE += most(l);
    sumLL += l.length * l.length;
    sumLE += l.length * most(l);
  }
  const double spread = n * sumLL - sumL * sumL;
  const double slope = spread > 0.0 ? std::max(0.0, (n * sumLE - sumL * sumE) / spread) : 0.0;
  PermissibleError permissible;
  if (slope > 0.0) permissible.k = 1.0 / slope;
  for (const TestLength& l : lengths) permissible.a = std::max(permissible.a, most(l) - slope * l.length);
  return permissible;
}

}  // namespace mm
