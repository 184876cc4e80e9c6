#pragma once

namespace mm {

/// Legendre polynomial P_{k+1}(u) from P_k and P_{k-1}, by Bonnet's recursion.
inline double nextLegendre(int k, double u, double now, double before) {
  return ((2 * k + 1) * u * now - k * before) / (k + 1);
}

/// Legendre polynomial P_n(u), n from 0. Not std::legendre: that refuses |u| > 1, and an effect is also asked
/// somewhat beyond the range over which it was found.
inline double legendre(int n, double u) {
  double before = 1.0, now = n == 0 ? 1.0 : u;
  for (int k = 1; k < n; ++k) {
    const double next = nextLegendre(k, u, now, before);
    before = now;
    now = next;
  }
  return now;
}

}  // namespace mm
