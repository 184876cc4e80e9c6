#pragma once
#include <boost/math/special_functions/legendre.hpp>

namespace mm {

/// Legendre polynomial P_n(u), n from 0. By the recursion of Boost.Math, not by its legendre_p: that refuses
/// |u| > 1, and an effect is also asked somewhat beyond the range over which it was found.
inline double legendre(int n, double u) {
  double before = 1.0, now = n == 0 ? 1.0 : u;
  for (int k = 1; k < n; ++k) {
    const double next = boost::math::legendre_next(static_cast<unsigned>(k), u, now, before);
    before = now;
    now = next;
  }
  return now;
}

}  // namespace mm
