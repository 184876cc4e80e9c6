#pragma once
#include <map>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "base/dense.h"
#include "estimation/row_products.h"
#include "posterior/problem.h"

namespace mm {

/// What every cause would bring beside a set, at one state of the noise.
struct Conditionals {
  std::vector<double> logOdds;  // a cause: that it acts, given all others; its shapes and sizes summed
  /// Rows: shapes; log weight of each size of a shape, prior odds of its cause included. Of causes that act:
  /// beside the others.
  Eigen::Array<double, Eigen::Dynamic, kSizes, Eigen::RowMajor> logWeights;
};

/// The problem at one state of the noise, whitened and with everything free integrated out. What is asked
/// again and again is kept; safe to ask from several threads, and every answer is the same bits whoever asks.
class NoiseView {
 public:
  /// @param problem must outlive it. @param packed its columns, where a pool of views asks them again and
  /// again.
  NoiseView(const PosteriorProblem& problem, NoiseState state,
            std::shared_ptr<const PackedColumns> packed = nullptr);

  const NoiseState& state() const { return state_; }  ///< of the noise
  /// Log density of this state and set, data included: prior of the noise, of the causes, their shapes and
  /// sizes, and the evidence with coefficients and the scale of the noise integrated out.
  double logDensity(const ActingSet& set) const;
  Conditionals look(const ActingSet& set) const;
  /// Variance of the white noise beside a set, in units of the stated one.
  double whiteVariance(const ActingSet& set) const;
  /// Expected coefficients of the columns of each member, and their covariance.
  struct Fit {
    std::vector<Eigen::VectorXd> values;
    std::vector<Eigen::MatrixXd> covariance;
  };
  Fit fit(const ActingSet& set) const;  ///< of the members of a set

 private:
  struct Columns {  // of one shape
    RowMatrix whitened;
    Eigen::MatrixXd byFixed;  // fixed x k
    Eigen::VectorXd target;   // k
    RowMatrix cross;          // k x all columns; made when first asked for
    std::once_flag once, onceCross;
  };
  struct Joint {  // of a set
    Cholesky factor;
    Eigen::VectorXd explained;
    double rest = 0.0;  // with what the stated noise is worth
  };
  Columns& columnsOf(int shape) const;
  const RowMatrix& crossOf(int shape) const;
  Eigen::MatrixXd productOf(int a, int b) const;
  Joint jointOf(const ActingSet& set) const;
  Fit fitOf(const ActingSet& set, const Joint& joint) const;
  double logPossible(const ActingSet& set, const Joint& joint) const;
  void makeAll() const;
  void askShapes(int first, int end, const ActingSet& set, const Joint& joint, const RowMatrix& absorbed,
                 int firstColumn, Conditionals& look) const;

  const PosteriorProblem& problem_;
  NoiseState state_;
  std::shared_ptr<const PackedColumns> packed_;
  double logPrior_ = 0.0;
  std::unique_ptr<TimeWhitener> whitener_;
  RowMatrix fixed_;         // whitened columns of base and scatter
  Eigen::VectorXd target_;  // whitened
  Cholesky factor_;         // of the products of the fixed columns
  Eigen::VectorXd byTarget_;
  double logDeterminant_ = 0.0, rest_ = 0.0, freedoms_ = 1.0;
  // of all columns of the problem
  mutable std::once_flag onceAll_;
  mutable RowMatrix byFixed_;  // fixed x all
  mutable Eigen::VectorXd allTarget_;
  mutable std::vector<Eigen::MatrixXd> products_;  // a shape
  mutable std::mutex mutex_;                       // of those below
  mutable std::map<int, std::unique_ptr<Columns>> kept_;
  mutable std::map<std::pair<int, int>, Eigen::MatrixXd> keptProducts_;  // of two shapes
};

/// log(sum(exp(values)))
double logSumExp(const Eigen::Ref<const Eigen::ArrayXd>& values);

}  // namespace mm
