#include "design/weak_directions.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "base/dense.h"
#include "base/format.h"
#include "base/text.h"
#include "estimation/linearisation.h"

namespace mm {

std::vector<WeakDirection> weakDirections(const CalibrationResult& result) {
  constexpr double kStandsOut = 2.0, kPart = 0.2;
  const auto& unknowns = result.problem->unknowns();
  std::vector<int> free;
  for (int u = 0; u < result.problem->unknownCount(); ++u)
    if (unknowns[u].kind == UnknownKind::kEffect && result.covariance(u, u) > 0.0) free.push_back(u);
  std::vector<WeakDirection> weak;
  const int count = static_cast<int>(free.size());
  if (count < 3) return weak;
  // in units of what each parameter alone would show: what is large there is large by collinearity (Belsley)
  const Eigen::MatrixXd jacobian = result.weight.cwiseSqrt().cwiseQuotient(result.sigma).asDiagonal() *
                                   linearise(*result.problem, result.x).jacobian()(Eigen::all, free);
  const Eigen::VectorXd shown = jacobian.colwise().norm();
  const SymmetricEigen eigen(shown.asDiagonal() * result.covariance(free, free) * shown.asDiagonal());
  const double median = std::sqrt(std::max(0.0, eigen.values[count / 2]));
  for (int k = count - 1; k > count / 2; --k) {
    const double std = std::sqrt(std::max(0.0, eigen.values[k]));
    if (!(std > kStandsOut * median)) break;
    WeakDirection one;
    one.timesMedian = median > 0.0 ? std / median : 0.0;
    for (int i = 0; i < count; ++i)
      if (std::abs(eigen.vectors(i, k)) > kPart) one.direction.emplace_back(free[i], eigen.vectors(i, k));
    std::sort(one.direction.begin(), one.direction.end(),
              [](const auto& a, const auto& b) { return std::abs(a.second) > std::abs(b.second); });
    std::vector<std::string> told;
    for (const auto& [p, part] : one.direction) {
      const Unknown& u = unknowns[p];
      told.push_back(displayName(*result.problem, p) + format(" (± %.2g%s%s)", 2.0 * result.std(p) * u.toUnit,
                                                              u.unit == "1" ? "" : " ",
                                                              u.unit == "1" ? "" : u.unit.c_str()));
    }
    one.inWords = enumerated(told) + (told.size() > 1 ? " are strongly correlated (± with k = 2)"
                                                      : " is weakly determined (± with k = 2)");
    weak.push_back(std::move(one));
  }
  return weak;
}

}  // namespace mm
