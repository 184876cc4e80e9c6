#include <algorithm>
#include <cmath>

#include "base/dense.h"
#include "estimation/genetic_sphere_fitness.h"

namespace mm {

/// Mean square of the residuals as a quadratic form of the coefficients, about the last newGeneration().
Eigen::MatrixXd SphereFitness::informationOfCoefficients() const {
  const auto n = static_cast<Eigen::Index>(coefficientCount_);
  const std::size_t terms = terms_.total();
  const std::size_t ends[4] = {terms_.x, terms_.x + terms_.y, terms_.x + terms_.y + terms_.z, terms};
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(n, n);
  for (const Group& group : groups_) {
    const auto rows = static_cast<Eigen::Index>(group.count);
    Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(rows, n);
    Eigen::MatrixXd normals(rows, 3);
    for (Eigen::Index k = 0; k < rows; ++k) {
      const std::size_t i = group.first + static_cast<std::size_t>(k);
      const float* row = rows_.data() + (group.row + static_cast<std::size_t>(k)) * stride_;
      double factor[4] = {row[kNormalX], row[kNormalY], row[kNormalZ], -rootWeight_[i]};
      normals.row(k) << factor[0], factor[1], factor[2];
      for (std::size_t part = 0, t = 0; part < 4; ++part)
        for (; t < ends[part]; ++t)
          jacobian(k, static_cast<Eigen::Index>(termCoefficient_[t])) +=
              factor[part] * columns_[i * terms + t];
    }
    information += jacobian.transpose() * jacobian;
    const Eigen::MatrixXd shift = normals.transpose() * jacobian;
    information -= shift.transpose() * group.inverse * shift;  // zero where the centre does not follow
  }
  Eigen::VectorXd line = Eigen::VectorXd::Zero(n);
  for (std::size_t i = 0; i < linearRows_; ++i) {
    line.setZero();
    for (std::size_t t = 0; t < linearTerms_; ++t)
      line[static_cast<Eigen::Index>(linearCoefficient_[t])] += linear_[i * (linearTerms_ + 1) + t + 1];
    information += line * line.transpose();
  }
  return information / static_cast<double>(residualCount_);
}

std::vector<double> SphereFitness::principalAxes(const GeneticRanges& ranges) const {
  const auto n = static_cast<Eigen::Index>(dimension_);
  Eigen::MatrixXd slope(static_cast<Eigen::Index>(coefficientCount_), n);  // of the mapping, in half ranges
  std::vector<double> gene = reference_, above(coefficientCount_), below(coefficientCount_);
  Eigen::VectorXd half(n);
  for (Eigen::Index j = 0; j < n; ++j) {
    const auto g = static_cast<std::size_t>(j);
    half[j] = 0.5 * (ranges.high[g] - ranges.low[g]);
    constexpr double kStep = 1e-4;
    gene[g] = reference_[g] + kStep * half[j];
    mapCoefficients(gene.data(), above.data());
    gene[g] = reference_[g] - kStep * half[j];
    mapCoefficients(gene.data(), below.data());
    gene[g] = reference_[g];
    for (std::size_t c = 0; c < coefficientCount_; ++c)
      slope(static_cast<Eigen::Index>(c), j) = (above[c] - below[c]) / (2.0 * kStep);
  }
  const SymmetricEigen eigen(slope.transpose() * informationOfCoefficients() * slope);
  const double strongest = eigen.values[n - 1];
  if (!(strongest > 0.0)) return {};
  constexpr double kNoEffect = 1e-18;  // of the strongest information: rounding, squared
  std::vector<double> axes;
  axes.reserve(dimension_ * dimension_);
  for (Eigen::Index a = 0; a < n; ++a) {
    // An axis without any effect is not longer than its range, like the others in the first stage.
    const double length = std::sqrt(strongest / std::max(eigen.values[a], kNoEffect * strongest));
    for (Eigen::Index j = 0; j < n; ++j) axes.push_back(length * half[j] * eigen.vectors(j, a));
  }
  return axes;
}

}  // namespace mm
