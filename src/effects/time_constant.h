#pragma once
#include <algorithm>
#include <cmath>
#include <vector>

#include "effects/domain.h"
#include "effects/law.h"
#include "effects/quantity.h"

namespace mm {

/// The unknown time constant (s) of a first-order process in a session of this length.
inline Parameter timeConstant(const std::string& name, const Domain& domain) {
  const double duration = std::max(domain.duration, 1.0);
  Parameter p = parameter(name, {"s", 1.0}, 0.2 * duration, 10.0 * duration, 0.2 * duration);
  p.minimum = 0.0;
  p.maximum = 100.0 * duration;
  return p;
}

/// Starts for its search, a factor of two apart: from 1/128 of the session to twice the session.
inline std::vector<double> timeConstantStarts(const Domain& domain) {
  std::vector<double> starts;
  const double duration = std::max(domain.duration, 1.0);
  for (int k = -7; k <= 1; ++k) starts.push_back(std::ldexp(duration, k));
  return starts;
}

/// Gives a law of what settles after the start its time constant, the last parameter. Of a slower one the
/// session saw hardly more than a steady change, of a quicker one not more than its first reading: the rest
/// is a constant, and what differs in one reading alone an outlier.
inline void settles(Law& law, const Domain& domain) {
  law.parameters.push_back(timeConstant("time_constant", domain));
  law.starts = timeConstantStarts(domain);
  law.longest = law.starts.back();
  if (domain.gaps.size() > 1) law.shortest = domain.gaps[1];
}

}  // namespace mm
