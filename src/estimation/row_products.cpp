// Half of a diagnosis is products of tall matrices. Debian's Eigen is compiled for every x86-64, that is for
// two numbers at a time; four and a fused multiply-add do it three times as fast (bench_diagnosis,
// BM_RowProducts).
#include "estimation/row_products.h"

#include <algorithm>
#include <vector>

#include "base/parallel.h"

namespace mm {
namespace {

constexpr int kLanes = 4, kAcross = 3 * kLanes;  // columns of b in a tile
constexpr int kDown = 4;                         // columns of a in a tile
constexpr int kRows = 256;                       // at a time: both panels stay in the first cache

typedef double FourLanes
    __attribute__((vector_size(kLanes * sizeof(double)), aligned(alignof(double)), may_alias));

/// Panels of `width` columns each, row after row; the last is filled up with zeros.
template <int width>
void pack(const Eigen::Ref<const RowMatrix>& m, Eigen::Index first, int rows, double* out) {
  const auto columns = static_cast<int>(m.cols());
  const int whole = columns / width, rest = columns % width;
  for (int i = 0; i < rows; ++i) {
    const double* from = m.data() + (first + i) * m.outerStride();
    for (int p = 0; p < whole; ++p) {
      double* to = out + (static_cast<std::size_t>(p) * rows + i) * width;
      for (int k = 0; k < width; ++k) to[k] = from[p * width + k];
    }
    if (rest == 0) continue;
    double* to = out + (static_cast<std::size_t>(whole) * rows + i) * width;
    for (int k = 0; k < width; ++k) to[k] = k < rest ? from[whole * width + k] : 0.0;
  }
}

int panelsOf(Eigen::Index columns, int width) { return static_cast<int>((columns + width - 1) / width); }

/// Memory of this thread for panels: asked for anew, it would cost more than what is done in it.
template <int width>
double* panelsFor(Eigen::Index columns, int rows) {
  thread_local std::vector<double> memory;
  const std::size_t needed = static_cast<std::size_t>(panelsOf(columns, width)) * rows * width;
  if (memory.size() < needed) memory.resize(needed);
  return memory.data();
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

using Tile = void (*)(const double* a, const double* b, int rows, double* out);

void anyTile(const double* a, const double* b, int rows, double* out) { addTile(a, b, rows, out); }

#if defined(__x86_64__)
__attribute__((target("avx2,fma"))) void wideTile(const double* a, const double* b, int rows, double* out) {
  addTile(a, b, rows, out);
}
Tile bestTile() {
  return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") ? wideTile : anyTile;
}
#else
Tile bestTile() { return anyTile; }
#endif

/// Adds the products of some rows. @param first, end panels of b. @param own b is a: tiles below the diagonal
/// are left out.
void addProducts(const double* a, const double* b, int rows, int first, int end, bool own, RowMatrix& out) {
  static const Tile tile = bestTile();
  const int down = static_cast<int>(out.rows()), across = static_cast<int>(out.cols());
  for (int j = first * kAcross; j < std::min(across, end * kAcross); j += kAcross)
    for (int i = 0; i < down && !(own && i >= j + kAcross); i += kDown) {
      double sums[kDown * kAcross];
      tile(a + static_cast<std::size_t>(i) * rows, b + static_cast<std::size_t>(j) * rows, rows, sums);
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

int rowsAt(Eigen::Index first, Eigen::Index rows) {
  return static_cast<int>(std::min<Eigen::Index>(kRows, rows - first));
}

RowMatrix products(const Eigen::Ref<const RowMatrix>& a, const Eigen::Ref<const RowMatrix>& b, bool own) {
  RowMatrix out = RowMatrix::Zero(a.cols(), b.cols());
  for (Eigen::Index first = 0; first < a.rows(); first += kRows) {
    const int rows = rowsAt(first, a.rows());
    double* left = panelsFor<kDown>(a.cols(), rows);
    double* right = panelsFor<kAcross>(b.cols(), rows);
    pack<kDown>(a, first, rows, left);
    pack<kAcross>(b, first, rows, right);
    addProducts(left, right, rows, 0, panelsOf(b.cols(), kAcross), own, out);
  }
  if (own)
    for (Eigen::Index i = 0; i < out.rows(); ++i)
      for (Eigen::Index j = 0; j < i; ++j) out(i, j) = out(j, i);
  return out;
}

}  // namespace

RowMatrix rowProducts(const Eigen::Ref<const RowMatrix>& a, const Eigen::Ref<const RowMatrix>& b) {
  return products(a, b, false);
}

RowMatrix rowProducts(const Eigen::Ref<const RowMatrix>& a) { return products(a, a, true); }

static_assert(PackedColumns::kTogether == kAcross, "a panel");

PackedColumns::PackedColumns(const Eigen::Ref<const RowMatrix>& m)
    : rows_(m.rows()), columns_(m.cols()), panels_(new double[beginOf(rows_)]) {
  parallelFor(partsOf(static_cast<std::size_t>(rows_), kRows), [&](std::size_t number) {
    const auto first = static_cast<Eigen::Index>(number) * kRows;
    pack<kAcross>(m, first, rowsAt(first, rows_), panels_.get() + beginOf(first));
  });
}

std::size_t PackedColumns::beginOf(Eigen::Index row) const {
  return static_cast<std::size_t>(row) * panelsOf(columns_, kAcross) * kAcross;
}

void PackedColumns::productsWith(const Eigen::Ref<const RowMatrix>& a, int first, int end,
                                 RowMatrix& to) const {
  const int firstPanel = first / kAcross, endPanel = panelsOf(end, kAcross);
  const Eigen::Index columns = std::min<Eigen::Index>(columns_, endPanel * kAcross) - firstPanel * kAcross;
  to.middleCols(firstPanel * kAcross, columns).setZero();
  for (Eigen::Index row = 0; row < rows_; row += kRows) {
    const int rows = rowsAt(row, rows_);
    double* left = panelsFor<kDown>(a.cols(), rows);
    pack<kDown>(a, row, rows, left);
    addProducts(left, panels_.get() + beginOf(row), rows, firstPanel, endPanel, false, to);
  }
}

}  // namespace mm
