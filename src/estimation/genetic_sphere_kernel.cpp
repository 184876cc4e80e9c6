#include "estimation/genetic_sphere_kernel.h"

#include <cstdint>

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define MM_X86 1
#define MM_TARGET(level) __attribute__((target("arch=x86-64-" level)))
#endif
#if defined(MM_X86) && !defined(__SANITIZE_THREAD__)  // chosen before the thread sanitizer has begun
#define MM_CLONES __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define MM_CLONES
#endif
#define MM_INLINE inline __attribute__((always_inline))

namespace mm {
namespace {

template <int kWidth>
struct Lanes {
  typedef float Vector __attribute__((vector_size(kWidth * sizeof(float)), aligned(4), may_alias));
  typedef std::int32_t Bits __attribute__((vector_size(kWidth * sizeof(float)), aligned(4), may_alias));
};

/// `kContacts` contacts against kVectors vectors of lanes: each value that is loaded is used several times.
/// The residual is formed as (|p + d|^2 - (D + dD)^2) / (|p + d| + D + dD) from the small |p|^2 - D^2, so
/// that single precision costs 1e-7 of the displacement and not of the radius.
template <int kWidth, int kVectors, int kContacts>
MM_INLINE void addTile(const SphereBlock& block, const float* rows, std::size_t lane,
                       typename Lanes<kWidth>::Vector (&sums)[4][kVectors]) {
  using V = typename Lanes<kWidth>::Vector;
  using B = typename Lanes<kWidth>::Bits;
  const std::size_t stride = block.stride, lanes = block.lanes;
  const float* coefficient = block.coefficients + lane;
  const float* column = rows + kRowHead;
  V excess[kContacts][kVectors], moved[kContacts][kVectors];
#pragma GCC unroll 4
  for (int i = 0; i < kContacts; ++i)
#pragma GCC unroll 4
    for (int v = 0; v < kVectors; ++v) excess[i][v] = V{} + rows[i * stride + kExcess];

  const auto sumTerms = [&](std::size_t terms) __attribute__((always_inline)) {
#pragma GCC unroll 4
    for (int i = 0; i < kContacts; ++i)
#pragma GCC unroll 4
      for (int v = 0; v < kVectors; ++v) moved[i][v] = V{};
    for (std::size_t t = 0; t < terms; ++t, coefficient += lanes, ++column) {
      V c[kVectors];
#pragma GCC unroll 4
      for (int v = 0; v < kVectors; ++v) c[v] = *reinterpret_cast<const V*>(coefficient + v * kWidth);
#pragma GCC unroll 4
      for (int i = 0; i < kContacts; ++i) {
        const float factor = column[i * stride];
#pragma GCC unroll 4
        for (int v = 0; v < kVectors; ++v) moved[i][v] += factor * c[v];
      }
    }
  };
  const std::size_t components[3] = {block.terms.x, block.terms.y, block.terms.z};
  for (int axis = 0; axis < 3; ++axis) {
    sumTerms(components[axis]);
#pragma GCC unroll 4
    for (int i = 0; i < kContacts; ++i)
#pragma GCC unroll 4
      for (int v = 0; v < kVectors; ++v)
        excess[i][v] += moved[i][v] * (moved[i][v] + rows[i * stride + kTwoX + axis]);
  }
  sumTerms(block.terms.distance);
#pragma GCC unroll 4
  for (int i = 0; i < kContacts; ++i) {
    const float* row = rows + i * stride;
#pragma GCC unroll 4
    for (int v = 0; v < kVectors; ++v) {
      // Square root by two Newton steps from the exponent's half: within 5e-6, which is the relative error of
      // the residual too; the same on every processor, and several times as fast as the instruction.
      const V square = excess[i][v] + row[kSquare];
      V root = (V)(0x5f375a86 - ((B)square >> 1));
      root *= 1.5f - 0.5f * square * root * root;
      root *= 1.5f - 0.5f * square * root * root;
      const V length = square * root;
      const V distance = moved[i][v] + row[kDistance];
      const V numerator = excess[i][v] - moved[i][v] * (distance + row[kDistance]);
      const V residual = numerator / (length + distance) * row[kRootWeight];
      sums[0][v] += residual * residual;
      sums[1][v] += residual * row[kNormalX];
      sums[2][v] += residual * row[kNormalY];
      sums[3][v] += residual * row[kNormalZ];
    }
  }
}

template <int kWidth, int kVectors, int kContacts>
MM_INLINE void addBlock(const SphereBlock& block, double* sums) {
  using V = typename Lanes<kWidth>::Vector;
  for (std::size_t lane = 0; lane < block.lanes; lane += kWidth * kVectors) {
    V partial[4][kVectors] = {};
    for (std::size_t i = 0; i < block.contacts; i += kContacts)
      addTile<kWidth, kVectors, kContacts>(block, block.rows + i * block.stride, lane, partial);
    for (int s = 0; s < 4; ++s)
      for (int v = 0; v < kVectors; ++v)
        for (int k = 0; k < kWidth; ++k)
          sums[s * block.lanes + lane + v * kWidth + k] += static_cast<double>(partial[s][v][k]);
  }
}

#ifdef MM_X86
MM_TARGET("v4") void addBlockV4(const SphereBlock& block, double* sums) { addBlock<16, 2, 4>(block, sums); }
MM_TARGET("v3") void addBlockV3(const SphereBlock& block, double* sums) { addBlock<8, 2, 2>(block, sums); }
#endif

SphereInstructions detect() {
#ifdef MM_X86
  __builtin_cpu_init();
  if (__builtin_cpu_supports("x86-64-v4")) return SphereInstructions::kAvx512;
  if (__builtin_cpu_supports("x86-64-v3")) return SphereInstructions::kAvx2;
#endif
  return SphereInstructions::kPortable;
}

}  // namespace

SphereInstructions sphereInstructions() {
  static const SphereInstructions kDetected = detect();
  return kDetected;
}

void addSphereBlock(const SphereBlock& block, double* sums, SphereInstructions instructions) {
#ifdef MM_X86
  if (instructions == SphereInstructions::kAvx512) return addBlockV4(block, sums);
  if (instructions == SphereInstructions::kAvx2) return addBlockV3(block, sums);
#else
  (void)instructions;
#endif
  addBlock<4, 2, 2>(block, sums);
}

MM_CLONES
void addLinearRows(const double* data, std::size_t rows, std::size_t terms, const double* coefficients,
                   std::size_t lanes, double* sums) {
  typedef double V __attribute__((vector_size(64), aligned(8), may_alias));
  for (std::size_t lane = 0; lane < lanes; lane += 8) {
    V sum = {};
    for (std::size_t i = 0; i < rows; ++i) {
      const double* row = data + i * (terms + 1);
      V residual = V{} + row[0];
      for (std::size_t t = 0; t < terms; ++t)
        residual += row[t + 1] * *reinterpret_cast<const V*>(coefficients + t * lanes + lane);
      sum += residual * residual;
    }
    for (int k = 0; k < 8; ++k) sums[lane + k] += sum[k];
  }
}

}  // namespace mm
