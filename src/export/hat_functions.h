#pragma once
#include <Eigen/Core>
#include <utility>
#include <vector>

namespace mm {

/// Positions inside each step between ascending, equally spaced points, `aStep` of them in parts of equal
/// size, each anywhere in its part (the same every time), so that no period falls on them.
std::vector<double> samplesWithin(const std::vector<double>& points, int aStep);

/// Values at `points` whose straight connections come nearest to samples: least squares by hat functions.
/// Over the samples that is never worse than nothing, whatever lies between the points.
/// @param points ascending, at least two, with samples inside every step. @param at where the samples are.
/// @param samples a row a sample, a column a curve. @return a row a point.
Eigen::MatrixXd hatFit(const std::vector<double>& points, const std::vector<double>& at,
                       const Eigen::MatrixXd& samples);

/// The same, and where a curve bends so much between the points that a fit to every second sample leaves
/// hardly less of the others than a straight line does, the straight line: more points would only follow
/// chance.
Eigen::MatrixXd hatOrLineFit(const std::vector<double>& points, const std::vector<double>& at,
                             const Eigen::MatrixXd& samples);

/// What the fit to every second sample leaves of the others: a row each of them.
Eigen::MatrixXd hatHeldOut(const std::vector<double>& points, const std::vector<double>& at,
                           const Eigen::MatrixXd& samples);

/// What the straight connections of `values` (a row a point) leave of the samples.
Eigen::MatrixXd hatRemainder(const std::vector<double>& points, const Eigen::MatrixXd& values,
                             const std::vector<double>& at, const Eigen::MatrixXd& samples);

}  // namespace mm
