#include "estimation/whitened.h"

namespace mm {

WhitenedSystem::WhitenedSystem(const Problem& problem, const Eigen::VectorXd& x,
                               const Eigen::VectorXd& inverseSigma, const std::vector<char>& fixed)
    : WhitenedSystem(linearise(problem, x), inverseSigma, fixed) {}

WhitenedSystem::WhitenedSystem(const Linearisation& at, const Eigen::VectorXd& inverseSigma,
                               const std::vector<char>& fixed) {
  const Problem& problem = at.problem();
  const Eigen::VectorXd &x = at.x(), &r = at.residuals();
  const Eigen::MatrixXd& full = at.jacobian();
  for (int u = 0; u < problem.unknownCount(); ++u)
    if (!fixed[u]) free.push_back(u);
  const int data = problem.rowCount();
  std::vector<int> priors;
  for (int u : problem.priors())
    if (!fixed[u]) priors.push_back(u);
  std::vector<UnitVector> units;
  for (const UnitVector& v : problem.unitVectors())
    if (!fixed[v.first] || !fixed[v.first + 1] || !fixed[v.first + 2]) units.push_back(v);
  const int firstUnit = data + static_cast<int>(priors.size());
  const int rows = firstUnit + static_cast<int>(units.size()), columns = static_cast<int>(free.size());
  scale.resize(columns);
  residuals.setZero(rows);
  jacobian.setZero(rows, columns);
  for (int i = 0; i < data; ++i)
    if (inverseSigma[i] != 0.0) residuals[i] = inverseSigma[i] * r[i];
  for (int c = 0; c < columns; ++c) {
    scale[c] = problem.unknowns()[free[c]].scale;
    for (int i = 0; i < data; ++i)
      if (inverseSigma[i] != 0.0) jacobian(i, c) = inverseSigma[i] * full(i, free[c]) * scale[c];
  }
  for (std::size_t k = 0; k < priors.size(); ++k) {
    const double factor = 1.0 / problem.unknowns()[priors[k]].priorStd;
    const int row = data + static_cast<int>(k);
    residuals[row] = factor * x[priors[k]];
    for (int c = 0; c < columns; ++c)
      if (free[c] == priors[k]) jacobian(row, c) = factor * scale[c];
  }
  for (std::size_t k = 0; k < units.size(); ++k) {
    const int row = firstUnit + static_cast<int>(k);
    const double weight = units[k].weight(inverseSigma);
    residuals[row] = weight * units[k].excess(x.data() + units[k].first);
    for (int c = 0; c < columns; ++c)
      if (free[c] >= units[k].first && free[c] < units[k].first + 3)
        jacobian(row, c) = 2.0 * weight * x[free[c]] * scale[c];
  }
}

}  // namespace mm
