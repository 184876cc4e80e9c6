#pragma once
#include <Eigen/Core>

namespace mm {

/// Whether a series is anything but one value.
inline bool varies(const Eigen::VectorXd& series) { return series.maxCoeff() > series.minCoeff(); }

/// Grey relational grade of every input with the outputs, as DFNN chooses its temperatures: each series is
/// scaled to 0 … 1, Delta_i(k) = |x_0(k) - x_i(k)|, xi_i(k) = (Delta_min + rho Delta_max) / (Delta_i(k) + rho
/// Delta_max), with the extremes over all inputs and samples; the grade is the mean over k, and over the
/// outputs where there are many. An input that falls as the output rises is mirrored. A series that does not
/// vary has grade 0.
/// @param inputs samples x inputs; outputs samples x outputs; any units. Throws InputError for unequal
/// lengths.
Eigen::VectorXd greyRelationalGrade(const Eigen::MatrixXd& inputs, const Eigen::MatrixXd& outputs,
                                    double rho = 0.5);

}  // namespace mm
