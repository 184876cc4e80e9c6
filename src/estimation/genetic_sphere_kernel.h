#pragma once
#include <cstddef>

namespace mm {

/// Lanes of a batch are padded to a multiple of this: the widest tile of any instruction set.
inline constexpr std::size_t kSphereLanes = 32;
/// Contacts of a ball are padded to a multiple of this, by contacts of zero weight.
inline constexpr std::size_t kSphereTile = 4;

/// Head of a contact's row of floats; its sparse columns follow, in the order of SphereTerms.
/// p = P0 - C is the contact seen from the ball's centre, D the distance that it should have.
enum SphereRow : std::size_t {
  kExcess,  // |p|^2 - D^2
  kTwoX,    // 2 p
  kTwoY,
  kTwoZ,
  kSquare,    // D^2
  kDistance,  // D
  kRootWeight,
  kNormalX,  // square root of the weight times the unit normal
  kNormalY,
  kNormalZ,
  kRowHead
};

/// Numbers of sparse columns: those of the three components of the displacement, then those of the distance.
struct SphereTerms {
  std::size_t x = 0, y = 0, z = 0, distance = 0;
  std::size_t total() const { return x + y + z + distance; }  ///< columns of all
};

/// One block of contacts of one ball against all lanes (chromosomes).
struct SphereBlock {
  const float* rows = nullptr;  // contacts x stride
  std::size_t contacts = 0;     // a multiple of kSphereTile
  std::size_t stride = 0;
  SphereTerms terms;
  const float* coefficients = nullptr;  // terms.total() x lanes: coefficient of each column
  std::size_t lanes = 0;                // a multiple of kSphereLanes
};

enum class SphereInstructions { kPortable, kAvx2, kAvx512 };
/// The most capable that this processor has.
SphereInstructions sphereInstructions();

/// Adds to `sums` (4 x lanes: the sum of w r^2, then the three of w r n) the residuals
/// r = |P0 + B c - C| - D of the block, n being the normal of the row. The arithmetic of a lane depends
/// neither on the number of lanes nor on its place. `instructions` must be those of the processor or less.
void addSphereBlock(const SphereBlock& block, double* sums,
                    SphereInstructions instructions = sphereInstructions());

/// Adds to `sums` (lanes) the squares of `rows` linear residuals: each row of `data` (1 + terms values) is
/// its offset and the factors of `coefficients` (terms x lanes).
void addLinearRows(const double* data, std::size_t rows, std::size_t terms, const double* coefficients,
                   std::size_t lanes, double* sums);

}  // namespace mm
