#pragma once
#include <functional>
#include <memory>
#include <vector>

#include "base/dense.h"
#include "estimation/noise_fit.h"

namespace mm {

/// A linear-Gaussian model of rows at one state of the noise: whitened, with the coefficients of the base
/// (free) and of what scatters (normal, at given ratios) integrated out. What may act beside these is asked
/// by its columns, whose coefficients are normal as well.
class WhitenedRows {
 public:
  /// Columns, whitened, and what base and scatter leave of their products.
  struct Columns {
    RowMatrix whitened;      // length x k
    RowMatrix byFixed;       // columns of base and scatter x k: what these take of them
    Eigen::VectorXd target;  // k: their products with the target
  };
  /// Columns whose coefficients have this standard deviation, in units of the white noise.
  struct Sized {
    double size = 0.0;
    const Columns* columns = nullptr;
  };
  /// Sets of columns that act together.
  struct Joint {
    Cholesky factor;            // of their products, plus 1
    Eigen::VectorXd explained;  // its solution for their products with the target
  };
  /// Expected coefficients of each set of columns, and their covariance.
  struct Fit {
    std::vector<Eigen::VectorXd> values;
    std::vector<Eigen::MatrixXd> covariance;
  };
  /// Products of two of several sets of columns, by their numbers.
  using ProductOf = std::function<Eigen::MatrixXd(std::size_t, std::size_t)>;

  /// @param ratios of what scatters, in units of the white noise; 0: it is not there.
  WhitenedRows(const NoiseRows& rows, const Eigen::VectorXd& variance, const std::vector<DriftTerm>& drift,
               const std::vector<RandomBlock>& scatter, const std::vector<double>& ratios);

  Columns prepare(RowMatrix columns) const;  ///< length x k
  /// Columns of a x columns of b, after base and scatter.
  static Eigen::MatrixXd productOf(const Columns& a, const Columns& b);
  /// @param product of two of the sets; none: as productOf gives it.
  static Joint jointOf(const std::vector<Sized>& sets, const ProductOf& product = {});
  /// @param white variance of the white noise.
  static Fit fitOf(const std::vector<Sized>& sets, const Joint& joint, double white);
  /// Expected coefficients of base and scatter. @param values coefficients of sets of columns that act.
  Eigen::VectorXd fixedBeside(const std::vector<Sized>& sets,
                              const std::vector<Eigen::VectorXd>& values) const;

  const TimeWhitener& whitener() const { return *whitener_; }  ///< of the noise
  const RowMatrix& fixed() const { return fixed_; }            ///< base and scatter, whitened
  double logDeterminant() const { return logDeterminant_; }    ///< of the covariance of the rows
  double rest() const { return rest_; }          ///< whitened sum of squares that is left; 0 at the least
  double freedoms() const { return freedoms_; }  ///< of `rest`; 1 at the least

 private:
  std::unique_ptr<TimeWhitener> whitener_;
  RowMatrix fixed_;
  Eigen::VectorXd target_;  // whitened
  Cholesky factor_;         // of the products of the fixed columns
  Eigen::VectorXd byTarget_;
  double logDeterminant_ = 0.0, rest_ = 0.0, freedoms_ = 1.0;
};

/// Columns of the base and, at their ratios, of what scatters. @return length x all.
RowMatrix fixedColumnsOf(const NoiseRows& rows, const std::vector<RandomBlock>& scatter,
                         const std::vector<double>& ratios);

}  // namespace mm
