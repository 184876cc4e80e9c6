#pragma once
#include <Eigen/Core>
#include <map>
#include <memory>
#include <vector>

#include "diagnosis/groups.h"
#include "posterior/whitened_rows.h"

namespace mm {

/// One cause of an explanation: a shape of a group at a size, with its columns.
struct Member {
  int group = 0, shape = 0;
  std::vector<double> nonlinear;  // refined, SI
  double size = 0.0;  // standard deviation of a coefficient of weight 1, in units of the white noise
  std::shared_ptr<const RowMatrix> columns;  // length x k, weighted
};

/// What one more group would bring.
struct Gain {
  int group = -1, shape = 0;
  double size = 0.0;         // at which the evidence is largest
  double coefficient = 0.0;  // of its first column, there
  /// Log evidence with it less that without, less the logarithm of the number of its shapes, less the price
  /// of a size that is not usual.
  double value = -1e300;
};

/// The number on which a diagnosis decides: the log evidence of a linear-Gaussian model of the residuals at
/// one model of the noise. The columns of the base model are free (restricted likelihood), those of blocks
/// and members are drawn from normal distributions, the scale of the noise is integrated out.
class Evidence {
 public:
  /// @param groups, rows: must outlive it. @param ratios of the blocks; 0: it is not there. @param heldOut a
  /// data row: not 0 where the row must not be used; null: all are.
  Evidence(const NoiseRows& rows, const Groups& groups, const NoiseModel& noise,
           const std::vector<RandomBlock>& blocks, const std::vector<double>& ratios,
           const std::vector<char>* heldOut = nullptr);

  /// What is left for others to explain beside some members. Of the evidence that made it, which must outlive
  /// it.
  struct Given {
    double logEvidence = 0.0;
    double rest = 0.0;  // whitened sum of squares that is left
    double freedoms = 1.0;
    std::vector<WhitenedRows::Sized> members;
    WhitenedRows::Joint joint;
  };
  Given given(const std::vector<Member>& members) const;  ///< beside these

  /// The best shape and size of a group beside what is given.
  Gain gainOf(const Given& given, int group) const;
  /// The same for columns that no group has.
  Gain gainOf(const Given& given, const RowMatrix& columns) const;
  /// Of all groups, best first.
  std::vector<Gain> gains(const Given& given) const;

  /// Expected values of the target (length of the rows): everything but the white noise, drift included.
  struct Fit {
    Eigen::VectorXd expected;                 // length
    Eigen::VectorXd withoutDrift;             // length
    std::vector<Eigen::VectorXd> values;      // a member: its coefficients
    std::vector<Eigen::MatrixXd> covariance;  // a member: of its coefficients
  };
  Fit fit(const std::vector<Member>& members) const;  ///< refits all together

  const TimeWhitener& whitener() const { return whitened_.whitener(); }  ///< of the noise

 private:
  std::vector<WhitenedRows::Sized> sizedOf(const std::vector<Member>& members) const;

  const NoiseRows& rows_;
  const Groups& groups_;
  WhitenedRows whitened_;
  RowMatrix fixed_;  // base and blocks
  double freedoms_ = 1.0;
  mutable std::map<std::shared_ptr<const RowMatrix>, WhitenedRows::Columns> prepared_;  // of members
};

}  // namespace mm
