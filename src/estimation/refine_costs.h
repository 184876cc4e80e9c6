#pragma once
#include <ceres/ceres.h>
#include <ceres/normal_prior.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "estimation/problem.h"

namespace mm {

// A problem in the terms of Ceres: blocks of unknowns, and the whitened residuals that depend on them.

/// Which unknowns make one parameter block of Ceres.
struct Block {
  std::vector<int> unknowns;
  std::vector<double> scales;
  double* values = nullptr;  // divided by the scales
  int feature = -1;          // whose position it is, -1: what all rows share
};

/// The whitened residuals of the observations that share one local block (a free feature), or of a slice of
/// the rest.
class GroupCost final : public ceres::CostFunction {
 public:
  GroupCost(const Problem& problem, const Eigen::VectorXd& base, const Eigen::VectorXd& inverseSigma,
            std::vector<int> observations, const std::vector<const Block*>& blocks)
      : problem_(problem),
        base_(base),
        inverseSigma_(inverseSigma),
        observations_(std::move(observations)),
        blocks_(blocks) {
    int rows = 0;
    for (int o : observations_) rows += problem.firstRow(o + 1) - problem.firstRow(o);
    set_num_residuals(rows);
    for (const Block* b : blocks_)
      mutable_parameter_block_sizes()->push_back(static_cast<int>(b->unknowns.size()));
  }

  bool Evaluate(double const* const* values, double* residuals, double** jacobians) const override {
    Eigen::VectorXd x = base_;
    for (std::size_t b = 0; b < blocks_.size(); ++b)
      for (std::size_t i = 0; i < blocks_[b]->unknowns.size(); ++i)
        x[blocks_[b]->unknowns[i]] = values[b][i] * blocks_[b]->scales[i];
    Model::Workspace work;
    Problem::Derivative d;
    Eigen::MatrixXd rows;
    double r[Problem::kMaxRows];
    int at = 0;
    for (int o : observations_) {
      const int n = problem_.residualsOf(o, x, r, jacobians != nullptr ? &d : nullptr, work);
      for (int i = 0; i < n; ++i) {
        const double s = inverseSigma_[problem_.firstRow(o) + i];
        residuals[at + i] = s == 0.0 ? 0.0 : s * r[i];
        if (!std::isfinite(residuals[at + i])) return false;
      }
      if (jacobians != nullptr) {
        problem_.scatter(o, d, rows);
        for (std::size_t b = 0; b < blocks_.size(); ++b) {
          if (jacobians[b] == nullptr) continue;
          const std::size_t width = blocks_[b]->unknowns.size();
          for (int i = 0; i < n; ++i) {
            const double s = inverseSigma_[problem_.firstRow(o) + i];
            for (std::size_t k = 0; k < width; ++k) {
              const double v = s == 0.0 ? 0.0 : s * rows(i, blocks_[b]->unknowns[k]) * blocks_[b]->scales[k];
              if (!std::isfinite(v)) return false;
              jacobians[b][(at + i) * width + k] = v;
            }
          }
        }
      }
      at += n;
    }
    return true;
  }

 private:
  const Problem& problem_;
  const Eigen::VectorXd& base_;
  const Eigen::VectorXd& inverseSigma_;
  std::vector<int> observations_;
  std::vector<const Block*> blocks_;
};

/// The norm of a unit vector, LASER (11).
class UnitVectorCost final : public ceres::CostFunction {
 public:
  /// @param scales of the block. @param places of l, m, n in the block, -1: held at the value.
  UnitVectorCost(const UnitVector& vector, double weight, const std::vector<double>& scales,
                 std::array<int, 3> places, Eigen::Vector3d held)
      : vector_(vector), weight_(weight), scales_(scales), places_(places), held_(std::move(held)) {
    set_num_residuals(1);
    mutable_parameter_block_sizes()->push_back(static_cast<int>(scales.size()));
  }
  bool Evaluate(double const* const* values, double* residuals, double** jacobians) const override {
    Eigen::Vector3d lmn = held_;
    for (int k = 0; k < 3; ++k)
      if (places_[k] >= 0) lmn[k] = values[0][places_[k]] * scales_[places_[k]];
    residuals[0] = weight_ * vector_.excess(lmn.data());
    if (jacobians == nullptr || jacobians[0] == nullptr) return true;
    std::fill(jacobians[0], jacobians[0] + scales_.size(), 0.0);
    for (int k = 0; k < 3; ++k)
      if (places_[k] >= 0) jacobians[0][places_[k]] = 2.0 * weight_ * lmn[k] * scales_[places_[k]];
    return true;
  }

 private:
  UnitVector vector_;
  double weight_;
  std::vector<double> scales_;
  std::array<int, 3> places_;
  Eigen::Vector3d held_;
};

}  // namespace mm
