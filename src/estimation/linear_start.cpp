#include "estimation/linear_start.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "base/dense.h"
#include "estimation/refine.h"
#include "estimation/whitened.h"

namespace mm {
namespace {

double costOf(const Problem& problem, const Eigen::VectorXd& x, const Eigen::VectorXd& inverseSigma) {
  const Eigen::VectorXd r = problem.residuals(x);
  double cost = 0.0;
  for (int i = 0; i < r.size(); ++i)
    if (inverseSigma[i] != 0.0) cost += r[i] * r[i] * inverseSigma[i] * inverseSigma[i];
  for (int u : problem.priors()) {
    const double prior = x[u] / problem.unknowns()[static_cast<std::size_t>(u)].priorStd;
    cost += prior * prior;
  }
  for (const UnitVector& v : problem.unitVectors()) {
    const double h = v.weight(inverseSigma) * v.excess(x.data() + v.first);
    cost += h * h;
  }
  return cost;
}

}  // namespace

bool hasNonlinearParameters(const Problem& problem) {
  const auto& effects = problem.model().effects();
  return std::any_of(effects.begin(), effects.end(),
                     [](const EffectPtr& e) { return !e->separable() && !e->nature().nonlinear.empty(); });
}

bool linearStart(const Problem& problem, Eigen::VectorXd& x, const std::vector<char>& fixed,
                 const Eigen::VectorXd& inverseSigma) {
  const Model& model = problem.model();
  std::vector<char> held = fixed;
  for (std::size_t e = 0; e < model.effects().size(); ++e)
    for (const int k : model.effects()[e]->nature().nonlinear)
      held[static_cast<std::size_t>(model.offset(static_cast<int>(e)) + k)] = 1;
  const WhitenedSystem system(problem, x, inverseSigma, held);
  if (system.free.empty() || !system.jacobian.allFinite() || !system.residuals.allFinite()) return false;
  const Eigen::VectorXd step = leastSquares(system.jacobian, -system.residuals);
  Eigen::VectorXd next = x;
  for (std::size_t i = 0; i < system.free.size(); ++i)
    next[system.free[i]] += step[static_cast<Eigen::Index>(i)] * system.scale[static_cast<Eigen::Index>(i)];
  if (!(costOf(problem, next, inverseSigma) < costOf(problem, x, inverseSigma))) return false;
  x = next;
  return true;
}

Eigen::VectorXd bestRefined(const Problem& problem, const std::vector<Eigen::VectorXd>& candidates,
                            const std::vector<char>& fixed, const Eigen::VectorXd& sigma,
                            const Eigen::VectorXd& weight, const std::function<bool()>& cancelled) {
  const Eigen::VectorXd inverse = weight.cwiseSqrt().cwiseQuotient(sigma);
  Eigen::VectorXd best = candidates.front();
  constexpr double kEqual = 1e-9;  // of a sum of squares: two ways to one optimum end within rounding of it
  double least = std::numeric_limits<double>::infinity();
  RefineOptions refining;
  refining.progress = [&](int, double) { return !(cancelled && cancelled()); };
  for (const Eigen::VectorXd& candidate : candidates) {
    if (cancelled && cancelled()) break;
    const Eigen::VectorXd x = refine(problem, candidate, fixed, sigma, weight, refining).x;
    const double cost = costOf(problem, x, inverse);
    if (!(cost < (1.0 - kEqual) * least)) continue;
    least = cost;
    best = x;
  }
  return best;
}

}  // namespace mm
