// Half of a diagnosis is products of tall matrices. Debian's Eigen is compiled for every x86-64, that is for
// two numbers at a time; four and a fused multiply-add do it three times as fast (bench_diagnosis,
// BM_RowProducts).
#include "estimation/row_products.h"

#include <algorithm>
#include <vector>

namespace mm {
namespace {

constexpr int kLanes = 4, kAcross = 3 * kLanes;  // columns of b in a tile
constexpr int kDown = 4;                         // columns of a in a tile
constexpr int kRows = 256;                       // at a time: both panels stay in the first cache

typedef double FourLanes
    __attribute__((vector_size(kLanes * sizeof(double)), aligned(alignof(double)), may_alias));

/// Panels of `width` columns each, row after row; the last is filled up with zeros.
template <int width>
std::vector<double> packed(const Eigen::Ref<const RowMatrix>& m, Eigen::Index first, int rows) {
  const auto columns = static_cast<int>(m.cols());
  const int whole = columns / width, rest = columns % width;
  std::vector<double> out(static_cast<std::size_t>(whole + (rest > 0)) * rows * width);
  for (int i = 0; i < rows; ++i) {
    const double* from = m.data() + (first + i) * m.outerStride();
    for (int p = 0; p < whole; ++p) {
      double* to = out.data() + (static_cast<std::size_t>(p) * rows + i) * width;
      for (int k = 0; k < width; ++k) to[k] = from[p * width + k];
    }
    double* to = out.data() + (static_cast<std::size_t>(whole) * rows + i) * width;
    for (int k = 0; k < rest; ++k) to[k] = from[whole * width + k];
  }
  return out;
}

/// One tile: kDown x kAcross sums over the rows of two panels.
__attribute__((always_inline)) inline void addTile(const double* a, const double* b, int rows, double* out) {
  FourLanes sum[kDown][3] = {};
  for (int i = 0; i < rows; ++i, a += kDown, b += kAcross) {
    const FourLanes* right = reinterpret_cast<const FourLanes*>(b);
#pragma GCC unroll 4
    for (int k = 0; k < kDown; ++k) {
      const FourLanes left = {a[k], a[k], a[k], a[k]};
#pragma GCC unroll 3
      for (int l = 0; l < 3; ++l) sum[k][l] += left * right[l];
    }
  }
#pragma GCC unroll 4
  for (int k = 0; k < kDown; ++k)
#pragma GCC unroll 3
    for (int l = 0; l < 3; ++l) reinterpret_cast<FourLanes*>(out + k * kAcross)[l] = sum[k][l];
}

#if defined(__x86_64__)
__attribute__((target("avx2,fma"))) void wideTile(const double* a, const double* b, int rows, double* out) {
  addTile(a, b, rows, out);
}
bool isWide() { return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"); }
#else
void wideTile(const double* a, const double* b, int rows, double* out) { addTile(a, b, rows, out); }
bool isWide() { return false; }
#endif

/// @param own b is a: tiles below the diagonal are mirrored.
RowMatrix products(const Eigen::Ref<const RowMatrix>& a, const Eigen::Ref<const RowMatrix>& b, bool own) {
  static const bool wide = isWide();
  if (!wide) return a.transpose() * b;
  const int down = static_cast<int>(a.cols()), across = static_cast<int>(b.cols());
  RowMatrix out = RowMatrix::Zero(down, across);
  for (Eigen::Index first = 0; first < a.rows(); first += kRows) {
    const int rows = static_cast<int>(std::min<Eigen::Index>(kRows, a.rows() - first));
    const std::vector<double> left = packed<kDown>(a, first, rows);
    const std::vector<double> right = packed<kAcross>(b, first, rows);
    for (int j = 0; j < across; j += kAcross)
      for (int i = 0; i < down && !(own && i >= j + kAcross); i += kDown) {
        double sums[kDown * kAcross];
        wideTile(left.data() + static_cast<std::size_t>(i) * rows,
                 right.data() + static_cast<std::size_t>(j) * rows, rows, sums);
        const int m = std::min(kDown, down - i), n = std::min(kAcross, across - j);
        for (int k = 0; k < m; ++k) {
          double* to = &out(i + k, j);
          const double* from = sums + k * kAcross;
          if (n == kAcross)
            for (int l = 0; l < kAcross; ++l) to[l] += from[l];
          else
            for (int l = 0; l < n; ++l) to[l] += from[l];
        }
      }
  }
  if (own)
    for (int i = 0; i < down; ++i)
      for (int j = 0; j < i; ++j) out(i, j) = out(j, i);
  return out;
}

}  // namespace

RowMatrix rowProducts(const Eigen::Ref<const RowMatrix>& a, const Eigen::Ref<const RowMatrix>& b) {
  return products(a, b, false);
}

RowMatrix rowProducts(const Eigen::Ref<const RowMatrix>& a) { return products(a, a, true); }

}  // namespace mm
