#pragma once
#include <Eigen/Core>
#include <vector>

#include "estimation/calibrate.h"
#include "estimation/drift.h"
#include "estimation/folds.h"
#include "estimation/linearisation.h"

namespace mm {

/// The linearised view of a fitted session in which every candidate is judged: one projection instead of one
/// fit each. Rows are the used data rows, whitened; everything that the model's own unknowns can absorb is
/// projected out, so that what is left of a candidate's columns is what it would do after everything is
/// refitted together.
class ResidualSpace {
 public:
  /// @param fitted must outlive it.
  explicit ResidualSpace(const CalibrationResult& fitted);

  const Problem& problem() const { return *fitted_.problem; }   ///< that was fitted
  const CalibrationResult& fitted() const { return fitted_; }   ///< the fit itself
  const Linearisation& linearisation() const { return at_; }    ///< of the problem at the fit
  int rows() const { return static_cast<int>(used_.size()); }   // data rows in use
  const std::vector<int>& used() const { return used_; }        // a row here: the problem's data row
  int baseRank() const { return static_cast<int>(q_.cols()); }  ///< columns of the base model
  /// What is left to explain: minus the whitened residuals, projected (rows + priors).
  const Eigen::VectorXd& target() const { return target_; }
  const Eigen::MatrixXd& basis() const { return q_; }  // orthonormal, (rows + priors) x baseRank
  const Folds& folds() const { return folds_; }        // of the rows here

  /// Columns of an effect at its parameters `p`, whitened and in units of the parameters' scale; rows +
  /// priors long. Rows that lack an input are 0. @param missing number of such rows.
  Eigen::MatrixXd columns(const Effect& effect, const std::vector<double>& p, int* missing = nullptr) const;
  /// Columns made of values a data row of the problem (m or rad each): whitened, rows + priors long.
  Eigen::MatrixXd whiten(const Eigen::MatrixXd& columns) const;
  /// Removes what the model's unknowns absorb.
  void project(Eigen::MatrixXd& columns) const;
  /// Norms of what `project` would leave of columns (length x k): one product, without the columns
  /// themselves.
  Eigen::VectorXd leftOf(const RowMatrix& columns) const;
  /// Share of what `project` leaves of columns (length x k), all together, that one observation has: the
  /// most.
  double mostInOneObservation(Eigen::MatrixXd columns) const;
  int length() const { return static_cast<int>(target_.size()); }

 private:
  const CalibrationResult& fitted_;
  Linearisation at_;
  std::vector<int> used_;
  std::vector<char> asked_;       // an observation: whether it has a row here
  Eigen::VectorXd inverseSigma_;  // a row here
  Eigen::MatrixXd q_;
  RowMatrix qRows_;  // the same, row after row
  Eigen::VectorXd target_;
  Folds folds_;
};

/// Natural logarithm of the upper tail of the F distribution.
double logPValueF(double f, double d1, double d2);

}  // namespace mm
