#pragma once
#include <map>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "estimation/row_products.h"
#include "posterior/problem.h"
#include "posterior/whitened_rows.h"

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
  /// Of several problems with the same rows and scatter, at the same state. @param whitened by it
  /// (whitenedAt).
  NoiseView(const PosteriorProblem& problem, NoiseState state, std::shared_ptr<const WhitenedRows> whitened);

  const NoiseState& state() const { return state_; }  ///< of the noise
  /// Log density of this state and set, data included: prior of the noise, of the causes, their shapes and
  /// sizes, and the evidence with coefficients and the scale of the noise integrated out.
  double logDensity(const ActingSet& set) const;
  /// What was asked lately is kept: a chain comes back to where it was in two steps of three.
  std::shared_ptr<const Conditionals> look(const ActingSet& set) const;
  /// Variance of the white noise beside a set, in units of the stated one.
  double whiteVariance(const ActingSet& set) const;
  /// Expected coefficients of the columns of each member of a set, and their covariance.
  WhitenedRows::Fit fit(const ActingSet& set) const;

 private:
  struct OfShape {
    WhitenedRows::Columns columns;
    RowMatrix cross;  // k x all columns; made when first asked for
    std::once_flag once, onceCross;
  };
  struct Joint : WhitenedRows::Joint {  // of a set
    std::vector<WhitenedRows::Sized> members;
    double rest = 0.0;  // with what the stated noise is worth
  };
  OfShape& keptOf(int shape) const;
  const RowMatrix& crossOf(int shape) const;
  Eigen::MatrixXd productOf(int a, int b) const;
  Joint jointOf(const ActingSet& set) const;
  std::shared_ptr<const Conditionals> ask(const ActingSet& set) const;
  WhitenedRows::Fit fitOf(const Joint& joint) const;
  double logPossible(const ActingSet& set, const Joint& joint) const;
  void makeAll() const;
  void askShapes(int first, int end, const ActingSet& set, const Joint& joint, const RowMatrix& absorbed,
                 int firstColumn, Conditionals& look) const;

  const PosteriorProblem& problem_;
  NoiseState state_;
  std::shared_ptr<const PackedColumns> packed_;
  double logPrior_ = 0.0;
  std::shared_ptr<const WhitenedRows> whitened_;
  double rest_ = 0.0, freedoms_ = 1.0;  // with what the stated noise is worth
  // of all columns of the problem
  mutable std::once_flag onceAll_;
  mutable RowMatrix byFixed_;  // fixed x all
  mutable Eigen::VectorXd allTarget_;
  mutable std::vector<Eigen::MatrixXd> products_;  // a shape
  mutable std::mutex mutex_;                       // of those below
  mutable std::map<int, std::unique_ptr<OfShape>> kept_;
  mutable std::map<std::pair<int, int>, Eigen::MatrixXd> keptProducts_;               // of two shapes
  mutable std::map<ActingSet, std::shared_ptr<const Conditionals>> lately_, before_;  // asked
};

/// The rows of a problem, whitened by a state of its noise.
std::shared_ptr<const WhitenedRows> whitenedAt(const NoiseRows& rows, const std::vector<RandomBlock>& scatter,
                                               const NoiseState& state);

/// log(sum(exp(values)))
double logSumExp(const Eigen::Ref<const Eigen::ArrayXd>& values);

}  // namespace mm
