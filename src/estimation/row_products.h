#pragma once
#include <memory>

#include "estimation/drift.h"

namespace mm {

/// a' b of two tall matrices with the same rows (one observation each): columns of a x columns of b. Uses the
/// widest arithmetic that the processor has, so its last bits differ between kinds of processors, but not
/// between runs on one of them.
RowMatrix rowProducts(const Eigen::Ref<const RowMatrix>& a, const Eigen::Ref<const RowMatrix>& b);

/// a' a, the whole square.
RowMatrix rowProducts(const Eigen::Ref<const RowMatrix>& a);

/// Many columns that are multiplied by a few others again and again: brought into the order of the arithmetic
/// once.
class PackedColumns {
 public:
  static constexpr int kTogether = 12;  // columns that are multiplied at a time

  PackedColumns() = default;
  /// @param m one observation a row; a copy is kept.
  explicit PackedColumns(const Eigen::Ref<const RowMatrix>& m);

  /// a' m for at least the columns [first, end) of m: those of whole groups of kTogether.
  /// @param to columns of a x all columns of m: only these are written.
  void productsWith(const Eigen::Ref<const RowMatrix>& a, int first, int end, RowMatrix& to) const;

 private:
  std::size_t beginOf(Eigen::Index row) const;

  Eigen::Index rows_ = 0, columns_ = 0;
  std::unique_ptr<double[]>
      panels_;  // some rows after the others; of each, kTogether columns after the others
};

}  // namespace mm
