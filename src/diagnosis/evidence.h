#pragma once
#include <Eigen/Core>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/dense.h"
#include "diagnosis/groups.h"
#include "estimation/noise_fit.h"
#include "estimation/row_products.h"

namespace mm {

/// One cause of an explanation: a shape of a group at a size, with its columns.
struct Member {
  int group = 0, shape = 0;
  std::vector<double> nonlinear;  // refined, SI
  double size = 0.0;  // standard deviation of a coefficient of weight 1, in units of the white noise
  std::shared_ptr<const RowMatrix> columns;  // length x k, weighted
  std::string id;                            // tells its columns from those of any other member
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
  /// @param groups, rows: must outlive it. @param blocks at their ratios. @param heldOut a data row: not 0
  /// where the row must not be used; null: all are.
  Evidence(const NoiseRows& rows, const Groups& groups, NoiseModel noise, std::vector<RandomBlock> blocks,
           const std::vector<char>* heldOut = nullptr);

  struct Given;  ///< what is left for others to explain
  /// What is common to all that is asked beside these members.
  Given given(const std::vector<Member>& members) const;

  /// The best shape and size of a group beside what is given. @param ofShapes filled with the gain of each.
  Gain gainOf(const Given& given, int group, std::vector<double>* ofShapes = nullptr) const;
  /// The same for columns that no group has.
  Gain gainOf(const Given& given, const std::vector<Member>& members, const RowMatrix& columns) const;
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

  const NoiseModel& noise() const { return fixed_->noise; }           ///< held
  const TimeWhitener& whitener() const { return *fixed_->whitener; }  ///< of the noise
  const Groups& groups() const { return groups_; }                    ///< all causes asked
  const NoiseRows& rows() const { return rows_; }                     ///< whitened

 private:
  /// The columns of a member, whitened, and what the base and the blocks leave of their products.
  struct Prepared {
    RowMatrix columns;
    Eigen::MatrixXd byBase;   // base and blocks x k
    Eigen::VectorXd target;   // k
    RowMatrix cross;          // k x all columns of the groups: those that somebody asked for
    std::vector<char> there;  // kTogether columns of `cross`: not 0 where they are
  };
  /// Members together, beside base and blocks.
  struct Joint {
    int columns = 0;
    Cholesky factor;
    Eigen::VectorXd explained;
  };
  /// Base, blocks and noise: what does not depend on the questions.
  struct Fixed {
    NoiseModel noise;
    std::unique_ptr<TimeWhitener> whitener;
    RowMatrix raw, columns;  // base and blocks, and the same whitened
    Eigen::VectorXd target;  // whitened
    Cholesky factor;         // of the products of base and blocks
    Eigen::VectorXd byTarget;
    double logDeterminant = 0.0, rest = 0.0, freedoms = 1.0;
  };
  static std::shared_ptr<const Fixed> fixedOf(const NoiseRows& rows, NoiseModel noise,
                                              const std::vector<RandomBlock>& blocks,
                                              const std::vector<char>* heldOut);
  Prepared prepare(const RowMatrix& columns) const;
  Prepared& prepared(const Member& member) const;
  void makeCross(Prepared& p, int first, int end) const;
  void makeAllCross(const Given& given) const;
  Eigen::MatrixXd productsOf(const Prepared& a, const Prepared& b) const;
  Joint jointOf(const std::vector<Member>& members) const;
  Gain best(const Eigen::MatrixXd& products, const Eigen::VectorXd& target, const Given& given) const;

  const NoiseRows& rows_;
  const Groups& groups_;
  std::shared_ptr<const Fixed> fixed_;
  PackedColumns columns_;        // of the groups, whitened
  Eigen::MatrixXd byBase_;       // base and blocks x columns of the groups
  Eigen::VectorXd groupTarget_;  // a column of the groups: product with the target, after base and blocks
  std::vector<std::vector<Eigen::MatrixXd>>
      products_;  // a group, a shape: of its columns, after base and blocks
  mutable std::map<std::string, Prepared> prepared_;
};

/// Of the evidence that made it, which must outlive it.
struct Evidence::Given {
  double logEvidence = 0.0;
  double rest = 0.0;  // whitened sum of squares that is left
  double freedoms = 1.0;
  Joint joint;
  std::vector<std::pair<double, Prepared*>> members;  // size, columns
};

}  // namespace mm
