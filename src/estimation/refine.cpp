#include "estimation/refine.h"

#include <ceres/ceres.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <map>

#include "base/dense.h"
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
  explicit Watcher(const RefineOptions& options) : options_(options) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary& s) override {
    return options_.progress && !options_.progress(s.iteration, s.cost) ? ceres::SOLVER_TERMINATE_SUCCESSFULLY
                                                                        : ceres::SOLVER_CONTINUE;
  }

 private:
  const RefineOptions& options_;
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
bool lastDigits(const Problem& problem, const Eigen::VectorXd& inverseSigma, const std::vector<char>& fixed,
                Eigen::VectorXd& x) {
  constexpr int kSteps = 100, kHalvings = 12;
  // of the residual's length: below the first nothing is left to gain, above the second a step that shortens
  // nothing means that the linear model does not hold there
  constexpr double kOffset = 1e-9, kFlat = 1e-4;
  WhitenedSystem system(problem, x, inverseSigma, fixed);
  for (int step = 0; step < kSteps; ++step) {
    const double cost = system.residuals.squaredNorm();
    const Eigen::VectorXd full = leastSquares(system.jacobian, -system.residuals);
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

/// The problem as Ceres sees it: one block of the unknowns that all share, and a block for each feature whose
/// position is wholly free.
class CeresFit {
 public:
  CeresFit(const Problem& problem, const Eigen::VectorXd& start, const std::vector<char>& fixed,
           const Eigen::VectorXd& inverseSigma)
      : problem_(problem), start_(start), fixed_(fixed), inverseSigma_(inverseSigma) {
    makeBlocks();
    if (empty()) return;
    placeValues();
    addObservations();
    addPriors();
    addUnitVectors();
    addLimits();
  }
  CeresFit(const CeresFit&) = delete;
  CeresFit& operator=(const CeresFit&) = delete;

  bool empty() const { return global_.unknowns.empty() && local_.empty(); }

  ceres::Solver::Summary solve(const RefineOptions& options) {
    ceres::Solver::Options solver = solverOptions(options);
    Watcher watcher(options);
    solver.callbacks.push_back(&watcher);
    ceres::Solver::Summary summary;
    ceres::Solve(solver, &ceres_, &summary);
    return summary;
  }

  /// All unknowns, SI, as they are now.
  Eigen::VectorXd x() const {
    Eigen::VectorXd x = start_;
    const auto read = [&](const Block& block) {
      for (std::size_t i = 0; i < block.unknowns.size(); ++i)
        x[block.unknowns[i]] = block.values[i] * block.scales[i];
    };
    read(global_);
    for (const auto& [feature, block] : local_) read(block);
    return x;
  }

 private:
  void makeBlocks() {
    const auto& unknowns = problem_.unknowns();
    for (int u = 0; u < problem_.unknownCount(); ++u) {
      if (fixed_[u]) continue;
      const int first = u - unknowns[u].component;
      const bool isLocal = unknowns[u].kind == UnknownKind::kFeature && !fixed_[first] &&
                           !fixed_[first + 1] && !fixed_[first + 2];
      Block& block = isLocal ? local_[unknowns[u].owner] : global_;
      block.unknowns.push_back(u);
      block.scales.push_back(unknowns[u].scale);
    }
  }

  void placeValues() {
    // Ceres orders the blocks of a group by their addresses: in one array, the same in every run
    values_.reserve(static_cast<std::size_t>(problem_.unknownCount()));
    const auto place = [&](Block& block) {
      block.values = values_.data() + values_.size();
      for (std::size_t i = 0; i < block.unknowns.size(); ++i) {
        values_.push_back(start_[block.unknowns[i]] / block.scales[i]);
        placeOf_[block.unknowns[i]] = {&block, static_cast<int>(i)};
      }
    };
    place(global_);
    for (auto& [feature, block] : local_) place(block);
  }

  void addObservations() {
    constexpr int kSlice = 256;  // observations of a block without a free feature: part of no result
    std::map<int, std::vector<int>> groups;  // feature, or a negative slice of the rest
    const auto& observations = problem_.session().observations;
    for (int o = 0; o < static_cast<int>(observations.size()); ++o) {
      const bool has = observations[o].feature >= 0 && local_.count(observations[o].feature) > 0;
      if (has || !global_.unknowns.empty())
        groups[has ? observations[o].feature : -1 - o / kSlice].push_back(o);
    }
    for (auto& [key, members] : groups) {
      std::vector<const Block*> blocks;
      std::vector<double*> values;
      if (!global_.unknowns.empty()) blocks.push_back(&global_), values.push_back(global_.values);
      if (key >= 0) blocks.push_back(&local_[key]), values.push_back(local_[key].values);
      ceres_.AddResidualBlock(new GroupCost(problem_, start_, inverseSigma_, members, blocks), nullptr,
                              values);
    }
  }

  void addPriors() {
    for (const int u : problem_.priors()) {
      if (fixed_[u]) continue;
      const auto [block, index] = placeOf_[u];
      const Unknown& unknown = problem_.unknowns()[u];
      ceres_.AddResidualBlock(
          new PriorCost(index, static_cast<int>(block->unknowns.size()), unknown.scale / unknown.priorStd),
          nullptr, block->values);
    }
  }

  void addUnitVectors() {
    for (const UnitVector& v : problem_.unitVectors()) {
      std::array<int, 3> places{-1, -1, -1};
      for (int k = 0; k < 3; ++k)
        if (placeOf_.count(v.first + k) > 0) places[k] = placeOf_[v.first + k].second;
      if (places[0] < 0 && places[1] < 0 && places[2] < 0) continue;
      ceres_.AddResidualBlock(new UnitVectorCost(v, v.penalty > 0.0 ? v.weight(inverseSigma_) : kSoft,
                                                 global_.scales, places, start_.segment<3>(v.first)),
                              nullptr, global_.values);
    }
  }

  void addLimits() {
    for (std::size_t i = 0; i < global_.unknowns.size(); ++i) {
      const Unknown& u = problem_.unknowns()[global_.unknowns[i]];
      const double scale = global_.scales[i];
      global_.values[i] = std::clamp(start_[global_.unknowns[i]], u.minimum, u.maximum) / scale;
      if (std::isfinite(u.minimum))
        ceres_.SetParameterLowerBound(global_.values, static_cast<int>(i), u.minimum / scale);
      if (std::isfinite(u.maximum))
        ceres_.SetParameterUpperBound(global_.values, static_cast<int>(i), u.maximum / scale);
    }
  }

  ceres::Solver::Options solverOptions(const RefineOptions& options) {
    // rounding is what ends the iterations: what is left is for lastDigits()
    constexpr double kFunction = 1e-15, kParameter = 1e-13, kGradient = 1e-16;
    // damping only holds back the weak directions of a problem that is linear but for the geometry
    constexpr double kNoDamping = 1e9;
    ceres::Solver::Options solver;
    solver.num_threads = 1;
    solver.max_num_iterations = options.maxIterations;
    solver.function_tolerance = kFunction;
    solver.parameter_tolerance = kParameter;
    solver.gradient_tolerance = kGradient;
    if (nearlyLinear(problem_)) solver.initial_trust_region_radius = kNoDamping;
    solver.logging_type = ceres::SILENT;
    solver.max_num_consecutive_invalid_steps = 20;
    if (local_.empty() || global_.unknowns.empty()) {
      solver.linear_solver_type = local_.empty() ? ceres::DENSE_QR : ceres::SPARSE_NORMAL_CHOLESKY;
      return solver;
    }
    solver.linear_solver_type = ceres::DENSE_SCHUR;
    auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
    for (auto& [feature, block] : local_) ordering->AddElementToGroup(block.values, 0);
    ordering->AddElementToGroup(global_.values, 1);
    solver.linear_solver_ordering = ordering;
    return solver;
  }

  const Problem& problem_;
  const Eigen::VectorXd& start_;
  const std::vector<char>& fixed_;
  const Eigen::VectorXd& inverseSigma_;
  Block global_;
  std::map<int, Block> local_;                     // a feature
  std::vector<double> values_;                     // of all blocks
  std::map<int, std::pair<Block*, int>> placeOf_;  // an unknown: its block, its index in it
  ceres::Problem ceres_;
};

}  // namespace

RefineResult refine(const Problem& problem, const Eigen::VectorXd& start, const std::vector<char>& fixed,
                    const Eigen::VectorXd& sigma, const Eigen::VectorXd& weight,
                    const RefineOptions& options) {
  constexpr double kSmall = 5e7;  // rows times unknowns squared: a dense QR of it takes less than a second
  RefineResult result;
  result.x = start;
  const Eigen::VectorXd inverseSigma = weight.cwiseSqrt().cwiseQuotient(sigma);
  CeresFit fit(problem, start, fixed, inverseSigma);
  if (fit.empty()) {
    result.converged = true;
    result.stop = "nothing to estimate";
    return result;
  }
  const ceres::Solver::Summary summary = fit.solve(options);
  result.x = fit.x();
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
  if (!result.cancelled && summary.termination_type != ceres::FAILURE && size < kSmall) {
    result.converged |= lastDigits(problem, inverseSigma, fixed, result.x);
    if (result.converged) result.stop = "converged";
  }
  return result;
}

}  // namespace mm
