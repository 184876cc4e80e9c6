#include "estimation/polish.h"

#include <ceres/ceres.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <map>

#include "estimation/whitened.h"

namespace mm {
namespace {

/// Which unknowns make one parameter block of Ceres.
struct Block {
  std::vector<int> unknowns;
  std::vector<double> scales;
  double* values = nullptr;  // divided by the scales
};

/// The whitened residuals of the observations that share one local block (a free feature), or of a slice of
/// the rest.
class GroupCost final : public ceres::CostFunction {
 public:
  GroupCost(const Problem& problem, const Eigen::VectorXd& base, const Eigen::VectorXd& inverseSigma,
            std::vector<int> observations, const std::vector<const Block*>& blocks)
      : problem_(problem),
        base_(base),
        inverseSigma_(inverseSigma),
        observations_(std::move(observations)),
        blocks_(blocks) {
    int rows = 0;
    for (int o : observations_) rows += problem.firstRow(o + 1) - problem.firstRow(o);
    set_num_residuals(rows);
    for (const Block* b : blocks_)
      mutable_parameter_block_sizes()->push_back(static_cast<int>(b->unknowns.size()));
  }

  bool Evaluate(double const* const* values, double* residuals, double** jacobians) const override {
    Eigen::VectorXd x = base_;
    for (std::size_t b = 0; b < blocks_.size(); ++b)
      for (std::size_t i = 0; i < blocks_[b]->unknowns.size(); ++i)
        x[blocks_[b]->unknowns[i]] = values[b][i] * blocks_[b]->scales[i];
    Model::Workspace work;
    Problem::Derivative d;
    Eigen::MatrixXd rows;
    double r[Problem::kMaxRows];
    int at = 0;
    for (int o : observations_) {
      const int n = problem_.residualsOf(o, x, r, jacobians != nullptr ? &d : nullptr, work);
      for (int i = 0; i < n; ++i) {
        const double s = inverseSigma_[problem_.firstRow(o) + i];
        residuals[at + i] = s == 0.0 ? 0.0 : s * r[i];
        if (!std::isfinite(residuals[at + i])) return false;
      }
      if (jacobians != nullptr) {
        problem_.scatter(o, d, rows);
        for (std::size_t b = 0; b < blocks_.size(); ++b) {
          if (jacobians[b] == nullptr) continue;
          const std::size_t width = blocks_[b]->unknowns.size();
          for (int i = 0; i < n; ++i) {
            const double s = inverseSigma_[problem_.firstRow(o) + i];
            for (std::size_t k = 0; k < width; ++k) {
              const double v = s == 0.0 ? 0.0 : s * rows(i, blocks_[b]->unknowns[k]) * blocks_[b]->scales[k];
              if (!std::isfinite(v)) return false;
              jacobians[b][(at + i) * width + k] = v;
            }
          }
        }
      }
      at += n;
    }
    return true;
  }

 private:
  const Problem& problem_;
  const Eigen::VectorXd& base_;
  const Eigen::VectorXd& inverseSigma_;
  std::vector<int> observations_;
  std::vector<const Block*> blocks_;
};

/// A prior on one unknown: its value over its standard deviation.
class PriorCost final : public ceres::CostFunction {
 public:
  PriorCost(int index, int width, double factor) : index_(index), width_(width), factor_(factor) {
    set_num_residuals(1);
    mutable_parameter_block_sizes()->push_back(width);
  }
  bool Evaluate(double const* const* values, double* residuals, double** jacobians) const override {
    residuals[0] = factor_ * values[0][index_];
    if (jacobians != nullptr && jacobians[0] != nullptr)
      for (int i = 0; i < width_; ++i) jacobians[0][i] = i == index_ ? factor_ : 0.0;
    return true;
  }

 private:
  int index_, width_;
  double factor_;
};

/// The norm of a unit vector, LASER (11).
class UnitVectorCost final : public ceres::CostFunction {
 public:
  /// @param scales of the block. @param places of l, m, n in the block, -1: held at the value.
  UnitVectorCost(const UnitVector& vector, double weight, const std::vector<double>& scales,
                 std::array<int, 3> places, Eigen::Vector3d held)
      : vector_(vector), weight_(weight), scales_(scales), places_(places), held_(std::move(held)) {
    set_num_residuals(1);
    mutable_parameter_block_sizes()->push_back(static_cast<int>(scales.size()));
  }
  bool Evaluate(double const* const* values, double* residuals, double** jacobians) const override {
    Eigen::Vector3d lmn = held_;
    for (int k = 0; k < 3; ++k)
      if (places_[k] >= 0) lmn[k] = values[0][places_[k]] * scales_[places_[k]];
    residuals[0] = weight_ * vector_.excess(lmn.data());
    if (jacobians == nullptr || jacobians[0] == nullptr) return true;
    std::fill(jacobians[0], jacobians[0] + scales_.size(), 0.0);
    for (int k = 0; k < 3; ++k)
      if (places_[k] >= 0) jacobians[0][places_[k]] = 2.0 * weight_ * lmn[k] * scales_[places_[k]];
    return true;
  }

 private:
  UnitVector vector_;
  double weight_;
  std::vector<double> scales_;
  std::array<int, 3> places_;
  Eigen::Vector3d held_;
};

class Watcher final : public ceres::IterationCallback {
 public:
  explicit Watcher(const PolishOptions& options) : options_(options) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary& s) override {
    return options_.progress && !options_.progress(s.iteration, s.cost) ? ceres::SOLVER_TERMINATE_SUCCESSFULLY
                                                                        : ceres::SOLVER_CONTINUE;
  }

 private:
  const PolishOptions& options_;
};

bool nearlyLinear(const Problem& problem) {
  return std::all_of(problem.model().effects().begin(), problem.model().effects().end(),
                     [](const EffectPtr& e) { return e->separable(); });
}

/// A stiff row would make every step along the sphere a short one. The residuals do not depend on the length
/// of a vector whose norm is a constraint: a soft row holds it, and afterwards it is set to 1.
constexpr double kSoft = 1.0;

void normalise(const Problem& problem, const std::vector<char>& fixed, Eigen::VectorXd& x) {
  for (const UnitVector& v : problem.unitVectors())
    if (v.penalty == 0.0 && !fixed[v.first] && !fixed[v.first + 1] && !fixed[v.first + 2])
      x.segment<3>(v.first).normalize();
}

bool withinLimits(const Problem& problem, const Eigen::VectorXd& x) {
  for (int u = 0; u < problem.unknownCount(); ++u)
    if (x[u] < problem.unknowns()[u].minimum || x[u] > problem.unknowns()[u].maximum) return false;
  return true;
}

/// Gauss-Newton steps by QR, halved until they shorten the residual: the last digits, for small problems.
/// @return true when what a further step promises is nothing beside the residual (Bates and Watts: the
/// relative offset), or when no step shortens it any more.
bool refine(const Problem& problem, const Eigen::VectorXd& inverseSigma, const std::vector<char>& fixed,
            Eigen::VectorXd& x) {
  constexpr int kSteps = 100, kHalvings = 12;
  constexpr double kOffset = 1e-9, kFlat = 1e-4;
  WhitenedSystem system(problem, x, inverseSigma, fixed);
  for (int step = 0; step < kSteps; ++step) {
    const double cost = system.residuals.squaredNorm();
    const Eigen::VectorXd full = system.jacobian.colPivHouseholderQr().solve(-system.residuals);
    if (!full.allFinite()) return false;
    const double offset = (system.jacobian * full).norm() / std::sqrt(cost);
    bool shorter = false;
    double factor = 1.0;
    for (int half = 0; half < kHalvings && !shorter; ++half, factor *= 0.5) {
      Eigen::VectorXd next = x;
      for (std::size_t i = 0; i < system.free.size(); ++i)
        next[system.free[i]] += factor * full[static_cast<int>(i)] * system.scale[static_cast<int>(i)];
      if (!withinLimits(problem, next)) continue;
      normalise(problem, fixed, next);
      WhitenedSystem trial(problem, next, inverseSigma, fixed);
      shorter = trial.residuals.squaredNorm() < cost;
      if (!shorter) continue;
      x = next;
      system = std::move(trial);
    }
    if (!shorter) return !(offset > kFlat);
    if (offset < kOffset) return true;
  }
  return false;
}

}  // namespace

PolishResult polish(const Problem& problem, const Eigen::VectorXd& start, const std::vector<char>& fixed,
                    const Eigen::VectorXd& sigma, const Eigen::VectorXd& weight,
                    const PolishOptions& options) {
  PolishResult result;
  result.x = start;
  const Eigen::VectorXd inverseSigma = weight.cwiseSqrt().cwiseQuotient(sigma);
  const auto& unknowns = problem.unknowns();

  // one global block, and a local one for each feature whose position is wholly free
  Block global;
  std::map<int, Block> local;
  for (int u = 0; u < problem.unknownCount(); ++u) {
    if (fixed[u]) continue;
    const int first = u - unknowns[u].component;
    const bool isLocal =
        unknowns[u].kind == UnknownKind::kFeature && !fixed[first] && !fixed[first + 1] && !fixed[first + 2];
    Block& block = isLocal ? local[unknowns[u].owner] : global;
    block.unknowns.push_back(u);
    block.scales.push_back(unknowns[u].scale);
  }
  if (global.unknowns.empty() && local.empty()) {
    result.converged = true;
    result.stop = "nothing to estimate";
    return result;
  }

  // Ceres orders the blocks of a group by their addresses: in one array, the same in every run
  std::vector<double> all;
  all.reserve(static_cast<std::size_t>(problem.unknownCount()));
  const auto place = [&](Block& block) {
    block.values = all.data() + all.size();
    for (std::size_t i = 0; i < block.unknowns.size(); ++i)
      all.push_back(start[block.unknowns[i]] / block.scales[i]);
  };
  place(global);
  for (auto& [feature, block] : local) place(block);

  std::map<int, std::vector<int>> groups;  // feature, or a negative slice of the rest
  const auto& observations = problem.session().observations;
  for (int o = 0; o < static_cast<int>(observations.size()); ++o) {
    const bool has =
        observations[o].kind == ObservationKind::kContact && local.count(observations[o].feature) > 0;
    if (has || !global.unknowns.empty()) groups[has ? observations[o].feature : -1 - o / 256].push_back(o);
  }
  const Eigen::VectorXd base = start;
  ceres::Problem ceresProblem;
  std::map<int, std::pair<Block*, int>> placeOf;  // unknown -> block, index
  for (std::size_t i = 0; i < global.unknowns.size(); ++i)
    placeOf[global.unknowns[i]] = {&global, static_cast<int>(i)};
  for (auto& [feature, block] : local)
    for (std::size_t i = 0; i < block.unknowns.size(); ++i)
      placeOf[block.unknowns[i]] = {&block, static_cast<int>(i)};
  for (auto& [key, members] : groups) {
    std::vector<const Block*> blocks;
    std::vector<double*> values;
    if (!global.unknowns.empty()) blocks.push_back(&global), values.push_back(global.values);
    if (key >= 0) blocks.push_back(&local[key]), values.push_back(local[key].values);
    ceresProblem.AddResidualBlock(new GroupCost(problem, base, inverseSigma, members, blocks), nullptr,
                                  values);
  }
  for (int u : problem.priors()) {
    if (fixed[u]) continue;
    auto [block, index] = placeOf[u];
    ceresProblem.AddResidualBlock(new PriorCost(index, static_cast<int>(block->unknowns.size()),
                                                unknowns[u].scale / unknowns[u].priorStd),
                                  nullptr, block->values);
  }

  for (const UnitVector& v : problem.unitVectors()) {
    std::array<int, 3> places{-1, -1, -1};
    for (int k = 0; k < 3; ++k)
      if (placeOf.count(v.first + k) > 0) places[k] = placeOf[v.first + k].second;
    if (places[0] < 0 && places[1] < 0 && places[2] < 0) continue;
    ceresProblem.AddResidualBlock(new UnitVectorCost(v, v.penalty > 0.0 ? v.weight(inverseSigma) : kSoft,
                                                     global.scales, places, start.segment<3>(v.first)),
                                  nullptr, global.values);
  }
  for (std::size_t i = 0; i < global.unknowns.size(); ++i) {
    const Unknown& u = unknowns[global.unknowns[i]];
    global.values[i] = std::clamp(start[global.unknowns[i]], u.minimum, u.maximum) / global.scales[i];
    if (std::isfinite(u.minimum))
      ceresProblem.SetParameterLowerBound(global.values, static_cast<int>(i), u.minimum / global.scales[i]);
    if (std::isfinite(u.maximum))
      ceresProblem.SetParameterUpperBound(global.values, static_cast<int>(i), u.maximum / global.scales[i]);
  }

  ceres::Solver::Options solver;
  solver.num_threads = 1;
  solver.max_num_iterations = options.maxIterations;
  solver.function_tolerance = 1e-15;
  solver.parameter_tolerance = 1e-13;
  solver.gradient_tolerance = 1e-16;
  // damping only holds back the weak directions of a problem that is linear but for the geometry
  if (nearlyLinear(problem)) solver.initial_trust_region_radius = 1e9;
  solver.logging_type = ceres::SILENT;
  solver.max_num_consecutive_invalid_steps = 20;
  if (local.empty() || global.unknowns.empty()) {
    solver.linear_solver_type = local.empty() ? ceres::DENSE_QR : ceres::SPARSE_NORMAL_CHOLESKY;
  } else {
    solver.linear_solver_type = ceres::DENSE_SCHUR;
    auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
    for (auto& [feature, block] : local) ordering->AddElementToGroup(block.values, 0);
    ordering->AddElementToGroup(global.values, 1);
    solver.linear_solver_ordering = ordering;
  }
  Watcher watcher(options);
  solver.callbacks.push_back(&watcher);
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &ceresProblem, &summary);

  const auto read = [&](const Block& block) {
    for (std::size_t i = 0; i < block.unknowns.size(); ++i)
      result.x[block.unknowns[i]] = block.values[i] * block.scales[i];
  };
  read(global);
  for (const auto& [feature, block] : local) read(block);
  normalise(problem, fixed, result.x);
  result.iterations = static_cast<int>(summary.iterations.size()) - 1;
  result.cancelled = summary.termination_type == ceres::USER_SUCCESS;
  result.converged = summary.termination_type == ceres::CONVERGENCE;
  result.stop = result.cancelled                                    ? "cancelled"
                : result.converged                                  ? "converged"
                : summary.termination_type == ceres::NO_CONVERGENCE ? "iterations"
                                                                    : "the residual cannot be evaluated";
  const double size =
      static_cast<double>(problem.rowCount()) * problem.unknownCount() * problem.unknownCount();
  if (!result.cancelled && summary.termination_type != ceres::FAILURE && size < 5e7) {
    result.converged |= refine(problem, inverseSigma, fixed, result.x);
    if (result.converged) result.stop = "converged";
  }
  return result;
}

}  // namespace mm
