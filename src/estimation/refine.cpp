#include "estimation/refine.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <map>
#include <optional>

#include "base/dense.h"
#include "estimation/refine_costs.h"

namespace mm {
namespace {

class Watcher final : public ceres::IterationCallback {
 public:
  explicit Watcher(const RefineProgress& progress) : progress_(progress) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary& s) override {
    return progress_ && !progress_(s.iteration, s.cost) ? ceres::SOLVER_TERMINATE_SUCCESSFULLY
                                                        : ceres::SOLVER_CONTINUE;
  }

 private:
  const RefineProgress& progress_;
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

/// The rows that see one local block, or none: linearised, and the local unknowns eliminated by a Householder
/// QR of these rows alone.
struct ReducedRows {
  Eigen::MatrixXd local, crossed;  // triangle of the local unknowns; by the shared ones beside it
  Eigen::VectorXd localRest;
  Eigen::MatrixXd shared;  // what is left by the shared unknowns, a few rows
  Eigen::VectorXd sharedRest;
  double cost = 0.0;  // squared length of the residuals

  /// @param rows by the local and the shared unknowns, and the residuals as the last column.
  ReducedRows(Eigen::MatrixXd rows, Eigen::Index locals) {
    const Eigen::Index columns = rows.cols() - 1, shares = columns - locals;
    cost = rows.col(columns).squaredNorm();
    const Eigen::Index kept = std::min(rows.rows(), columns + 1);
    const Eigen::MatrixXd r = triangleOf(std::move(rows));
    const Eigen::Index first = std::min(kept, locals);
    local = r.topLeftCorner(first, locals);
    crossed = r.block(0, locals, first, shares);
    localRest = r.col(columns).head(first);
    shared = r.block(first, locals, kept - first, shares);
    sharedRest = r.col(columns).tail(kept - first);
  }
};

/// A problem linearised: the rows of each local block, reduced. None where a residual cannot be evaluated.
struct Linear {
  std::vector<std::pair<const Block*, ReducedRows>> groups;
  double cost = 0.0;
  bool finite() const { return !groups.empty(); }
};

/// The problem in blocks: one of the unknowns that all rows share, and one for each feature whose position is
/// wholly free. Ceres sees it so, and so do the Gauss-Newton steps.
class BlockFit {
 public:
  BlockFit(const Problem& problem, const Eigen::VectorXd& start, const std::vector<char>& fixed,
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
  BlockFit(const BlockFit&) = delete;
  BlockFit& operator=(const BlockFit&) = delete;

  bool empty() const { return global_.unknowns.empty() && local_.empty(); }

  /// Gauss-Newton steps, halved until they shorten the residual: the whole way where the model is nearly
  /// linear, else the last digits.
  /// @return true when what a further step promises is nothing beside the residual (Bates and Watts: the
  /// relative offset), or when no step shortens it any more; false also where the progress asked to stop.
  bool gaussNewton(const RefineProgress& progress, RefineResult& result) {
    constexpr int kSteps = 100, kHalvings = 12;
    // of the residual's length: below the first nothing is left to gain, above the second a step that
    // shortens nothing means that the linear model does not hold there
    constexpr double kOffset = 1e-9, kFlat = 1e-4;
    Linear now = linear();
    if (!now.finite()) return false;
    for (int step = 0; step < kSteps; ++step) {
      double promised = 0.0;
      const std::vector<double> from = values_, full = stepOf(now, promised);
      if (!std::isfinite(promised)) return false;
      const double offset = promised / std::sqrt(now.cost);
      if (offset < kOffset) return true;
      bool shorter = false;
      double factor = 1.0;
      for (int half = 0; half < kHalvings && !shorter; ++half, factor *= 0.5) {
        for (std::size_t i = 0; i < values_.size(); ++i) values_[i] = from[i] + factor * full[i];
        if (!settle()) continue;
        Linear next = linear();
        shorter = next.finite() && next.cost < now.cost;
        if (shorter) now = std::move(next);
      }
      if (!shorter) {
        values_ = from;
        return !(offset > kFlat);
      }
      ++result.iterations;
      if (progress && !progress(result.iterations, 0.5 * now.cost)) {
        result.cancelled = true;
        return false;
      }
    }
    return false;
  }

  ceres::Solver::Summary solve(const RefineProgress& progress) {
    ceres::Solver::Options solver = solverOptions();
    Watcher watcher(progress);
    solver.callbacks.push_back(&watcher);
    ceres::Solver::Summary summary;
    ceres::Solve(solver, &ceres_, &summary);
    return summary;
  }

  /// All unknowns, SI, as they are now.
  Eigen::VectorXd x() const {
    Eigen::VectorXd x = start_;
    for (const auto& [unknown, place] : placeOf_)
      x[unknown] = place.first->values[place.second] * place.first->scales[place.second];
    normalise(problem_, fixed_, x);
    return x;
  }

 private:
  struct Cost {
    const ceres::CostFunction* function;  // Ceres' own
    std::vector<Block*> blocks;
  };

  void makeBlocks() {
    const auto& unknowns = problem_.unknowns();
    for (int u = 0; u < problem_.unknownCount(); ++u) {
      if (fixed_[u]) continue;
      const int first = u - unknowns[u].component;
      const bool isLocal = unknowns[u].kind == UnknownKind::kFeature && !fixed_[first] &&
                           !fixed_[first + 1] && !fixed_[first + 2];
      Block& block = isLocal ? local_[unknowns[u].owner] : global_;
      if (isLocal) block.feature = unknowns[u].owner;
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
      std::vector<Block*> blocks;
      if (!global_.unknowns.empty()) blocks.push_back(&global_);
      if (key >= 0) blocks.push_back(&local_[key]);
      add(new GroupCost(problem_, start_, inverseSigma_, members, {blocks.begin(), blocks.end()}), blocks);
    }
  }

  void add(ceres::CostFunction* cost, const std::vector<Block*>& blocks) {
    std::vector<double*> values;
    for (const Block* b : blocks) values.push_back(b->values);
    ceres_.AddResidualBlock(cost, nullptr, values);
    groups_[blocks.back()->feature].push_back({cost, blocks});
  }

  void addPriors() {
    for (const int u : problem_.priors()) {
      if (fixed_[u]) continue;
      const auto [block, index] = placeOf_[u];
      const Unknown& unknown = problem_.unknowns()[u];
      const auto width = static_cast<Eigen::Index>(block->unknowns.size());
      RowMatrix factors = RowMatrix::Zero(1, width);
      factors(0, index) = unknown.scale / unknown.priorStd;
      add(new ceres::NormalPrior(factors, Eigen::VectorXd::Zero(width)), {block});
    }
  }

  void addUnitVectors() {
    for (const UnitVector& v : problem_.unitVectors()) {
      std::array<int, 3> places{-1, -1, -1};
      for (int k = 0; k < 3; ++k)
        if (placeOf_.count(v.first + k) > 0) places[k] = placeOf_[v.first + k].second;
      if (places[0] < 0 && places[1] < 0 && places[2] < 0) continue;
      add(new UnitVectorCost(v, v.penalty > 0.0 ? v.weight(inverseSigma_) : kSoft, global_.scales, places,
                             start_.segment<3>(v.first)),
          {&global_});
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

  /// The residuals and the Jacobian of one block or of none beside the shared one, reduced. Empty where a
  /// residual cannot be evaluated.
  std::optional<ReducedRows> reduced(const Block* local, const std::vector<Cost>& costs) const {
    const auto locals = static_cast<Eigen::Index>(local == nullptr ? 0 : local->unknowns.size());
    const auto columns = locals + static_cast<Eigen::Index>(global_.unknowns.size());
    Eigen::Index count = 0;
    for (const Cost& c : costs) count += c.function->num_residuals();
    Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(count, columns + 1);
    Eigen::Index at = 0;
    for (const Cost& c : costs) {
      const int n = c.function->num_residuals();
      std::vector<RowMatrix> jacobians;
      std::vector<double*> values, into;
      for (const Block* b : c.blocks) {
        jacobians.emplace_back(n, static_cast<Eigen::Index>(b->unknowns.size()));
        values.push_back(b->values);
        into.push_back(jacobians.back().data());
      }
      if (!c.function->Evaluate(values.data(), rows.col(columns).data() + at, into.data()))
        return std::nullopt;
      for (std::size_t k = 0; k < c.blocks.size(); ++k)
        rows.block(at, c.blocks[k] == local ? 0 : locals, n, jacobians[k].cols()) = jacobians[k];
      at += n;
    }
    return ReducedRows(std::move(rows), locals);
  }

  /// At the present values; no groups where a residual cannot be evaluated.
  Linear linear() const {
    Linear linear;
    for (const auto& [feature, costs] : groups_) {
      const Block* local = feature < 0 ? nullptr : &local_.at(feature);
      std::optional<ReducedRows> rows = reduced(local, costs);
      if (!rows) return {};
      linear.cost += rows->cost;
      linear.groups.emplace_back(local, std::move(*rows));
    }
    return linear;
  }

  /// The Gauss-Newton step of all values. @param promised length by which it changes the residuals.
  std::vector<double> stepOf(const Linear& linear, double& promised) const {
    const auto shares = static_cast<Eigen::Index>(global_.unknowns.size());
    Eigen::Index count = 0, at = 0;
    for (const auto& [local, rows] : linear.groups) count += rows.sharedRest.size();
    Eigen::MatrixXd a(count, shares);
    Eigen::VectorXd b(count);
    for (const auto& [local, rows] : linear.groups) {
      a.middleRows(at, rows.shared.rows()) = rows.shared;
      b.segment(at, rows.shared.rows()) = rows.sharedRest;
      at += rows.shared.rows();
    }
    Eigen::VectorXd shared(shares);
    if (shares > 0) shared = leastSquares(a, -b);
    double length = (a * shared).squaredNorm();
    std::vector<double> step(values_.size(), 0.0);
    std::copy(shared.data(), shared.data() + shares, step.begin());
    for (const auto& [local, rows] : linear.groups) {
      if (local == nullptr) continue;
      // with pivots: of a feature most of whose rows have no weight a direction may not be determined
      const Eigen::VectorXd own = leastSquares(rows.local, -rows.localRest - rows.crossed * shared);
      length += rows.localRest.squaredNorm();
      std::copy(own.data(), own.data() + own.size(), step.begin() + (local->values - values_.data()));
    }
    const bool finite = std::all_of(step.begin(), step.end(), [](double v) { return std::isfinite(v); });
    promised = finite ? std::sqrt(length) : kNotMeasured;
    return step;
  }

  /// Brings unit vectors back to their length. @return whether the values are within the limits.
  bool settle() {
    const Eigen::VectorXd now = x();
    for (const auto& [unknown, place] : placeOf_)
      place.first->values[place.second] = now[unknown] / place.first->scales[place.second];
    return withinLimits(problem_, now);
  }

  ceres::Solver::Options solverOptions() {
    // rounding is what ends the iterations: what is left is for Gauss-Newton
    constexpr int kMostIterations = 500;
    constexpr double kFunction = 1e-15, kParameter = 1e-13, kGradient = 1e-16;
    ceres::Solver::Options solver;
    solver.num_threads = 1;
    solver.max_num_iterations = kMostIterations;
    solver.function_tolerance = kFunction;
    solver.parameter_tolerance = kParameter;
    solver.gradient_tolerance = kGradient;
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
  std::map<int, std::vector<Cost>> groups_;        // by the feature of the local block, -1: none
  ceres::Problem ceres_;
};

}  // namespace

RefineResult refine(const Problem& problem, const Eigen::VectorXd& start, const std::vector<char>& fixed,
                    const Eigen::VectorXd& sigma, const Eigen::VectorXd& weight,
                    const RefineProgress& progress) {
  RefineResult result;
  result.x = start;
  const Eigen::VectorXd inverseSigma = weight.cwiseSqrt().cwiseQuotient(sigma);
  BlockFit fit(problem, start, fixed, inverseSigma);
  if (fit.empty()) {
    result.converged = true;
    result.stop = "nothing to estimate";
    return result;
  }
  result.converged = nearlyLinear(problem) && fit.gaussNewton(progress, result);
  result.stop = result.cancelled ? "cancelled" : "converged";
  if (!result.converged && !result.cancelled) {
    const ceres::Solver::Summary summary = fit.solve(progress);
    result.iterations += static_cast<int>(summary.iterations.size()) - 1;
    result.cancelled = summary.termination_type == ceres::USER_SUCCESS;
    result.converged = summary.termination_type == ceres::CONVERGENCE;
    result.stop = result.cancelled                                    ? "cancelled"
                  : result.converged                                  ? "converged"
                  : summary.termination_type == ceres::NO_CONVERGENCE ? "iterations"
                                                                      : "the residual cannot be evaluated";
    if (!result.cancelled && summary.termination_type != ceres::FAILURE) {
      result.converged |= fit.gaussNewton(progress, result);
      result.converged &= !result.cancelled;
      result.stop = result.cancelled ? "cancelled" : result.converged ? "converged" : result.stop;
    }
  }
  result.x = fit.x();
  return result;
}

}  // namespace mm
