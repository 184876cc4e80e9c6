#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "diagnosis/residual_space.h"
#include "diagnosis/subset_search.h"

namespace mm {

/// Held-out RMS of effects added to the model, fold by fold, without a fit each: the model's part of every
/// fold is solved once, an effect's columns are a low-rank update of it.
class HeldOutJudge {
 public:
  explicit HeldOutJudge(const ResidualSpace& space);
  /// Held-out RMS (whitened) with the orthonormal columns `added` (projected on the model) in it.
  double rms(const Eigen::MatrixXd& added) const;
  int folds() const { return static_cast<int>(folds_.size()); }
  const std::vector<int>& rowsOf(int fold) const { return folds_[fold].rows; }
  /// Sum of the squared held-out residuals of one fold.
  double squares(const Eigen::MatrixXd& added, int fold) const;

 private:
  struct Fold {
    std::vector<int> rows;
    Eigen::MatrixXd q, gain;  // rows x rank; rank x rank
  };
  const ResidualSpace& space_;
  std::vector<Fold> folds_;
};

/// Share of resampled blocks (bootstrap over blocks of time) in which member `index` of the subset beats,
/// after penalty, every rival in its place.
double stability(const ResidualSpace& space, const CandidateSet& set, const Subset& rest, const Gain& chosen,
                 const std::vector<Gain>& rivals, double dof, std::uint64_t seed);

}  // namespace mm
