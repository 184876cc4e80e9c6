#include "diagnosis/structure.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>

#include "base/cancel_scope.h"
#include "base/dense.h"
#include "base/legendre.h"
#include "base/tiny.h"
#include "base/units.h"

namespace mm {
namespace {

constexpr double kRounding = 1e-9;  // of the middle of a range: a variable that varies by less does not vary
constexpr double kOwnShare = 1e-4;  // of terms of unit length: what the others leave of one that they imitate
constexpr std::size_t kMostBalls = 40;  // more levels than this are no variable of which to ask

/// Adds a variable when it varies and is known in at least nine of ten rows; unknown values become the mean.
void addVariable(std::vector<Variable>& to, const std::string& name, const std::string& symbol,
                 Eigen::VectorXd raw, bool category) {
  double low = 1e300, high = -1e300, sum = 0.0;
  int known = 0;
  for (double v : raw)
    if (std::isfinite(v)) low = std::min(low, v), high = std::max(high, v), sum += v, ++known;
  if (10 * known < 9 * raw.size() || !(high > low)) return;
  for (double& v : raw)
    if (!std::isfinite(v)) v = sum / known;
  Variable variable;
  variable.name = name;
  variable.symbol = symbol;
  variable.category = category;
  if (!category) {
    variable.centre = 0.5 * (low + high);
    variable.half = 0.5 * (high - low);
    if (variable.half < kRounding * std::abs(variable.centre)) return;
    raw = (raw.array() - variable.centre) / variable.half;
  }
  variable.values = raw;
  to.push_back(variable);
}

/// Low-order terms of a variable: Legendre 1 … order, or one indicator a category but one.
Eigen::MatrixXd termsOf(const Variable& v, int order) {
  const int n = static_cast<int>(v.values.size());
  if (v.category) {
    std::set<double> levels(v.values.begin(), v.values.end());
    Eigen::MatrixXd terms = Eigen::MatrixXd::Zero(n, static_cast<int>(levels.size()));
    int k = 0;
    for (double level : levels) {
      for (int i = 0; i < n; ++i) terms(i, k) = v.values[i] == level ? 1.0 : 0.0;
      ++k;
    }
    return terms.rightCols(terms.cols() - 1);
  }
  const std::set<double> distinct(v.values.begin(), v.values.end());
  order = std::min(order, static_cast<int>(distinct.size()) - 1);
  Eigen::MatrixXd terms(n, order);
  for (int i = 0; i < n; ++i) {
    double before = 1.0, now = v.values[i];
    for (int k = 1; k <= order; ++k) {
      terms(i, k - 1) = now;
      const double next = nextLegendre(k, v.values[i], now, before);
      before = now;
      now = next;
    }
  }
  return terms;
}

struct Test {
  double share = 0.0, logP = 0.0;
};

/// What is asked: a residual and what may absorb a part of it, as the noise whitens them.
class ShareTest {
 public:
  ShareTest(const ResidualSpace& space, const TimeWhitener* noise, const RowMatrix& scatter)
      : noise_(noise), basis_(space.length(), 0), left_(whitened(space.target()).col(0)) {
    dof_ = static_cast<double>(left_.size());
    if (noise == nullptr && scatter.cols() == 0) {
      basis_ = space.basis();
      dof_ -= static_cast<double>(basis_.cols());
    } else {
      absorb(space.basis());
      absorb(scatter);
    }
  }

  /// What these columns (length of the space) explain is asked no more.
  void absorb(const Eigen::MatrixXd& whole) {
    if (whole.cols() == 0) return;
    const Eigen::MatrixXd span = spanOf(unitColumns(whole), std::sqrt(kOwnShare));
    basis_.conservativeResize(Eigen::NoChange, basis_.cols() + span.cols());
    basis_.rightCols(span.cols()) = span;
    left_ -= span * (span.transpose() * left_).eval();
    dof_ -= static_cast<double>(span.cols());
  }

  /// F test of what columns (length of the space, not projected) explain.
  Test ask(const Eigen::MatrixXd& whole) const {
    CancelScope::check();
    const Eigen::MatrixXd columns = unitColumns(whole);
    const SymmetricEigen eigen(columns.transpose() * columns);
    const Eigen::VectorXd score = eigen.vectors.transpose() * (columns.transpose() * left_);
    double drop = 0.0;
    int rank = 0;
    for (int k = 0; k < score.size(); ++k)
      if (eigen.values[k] > kOwnShare) {
        drop += score[k] * score[k] / eigen.values[k];
        ++rank;
      }
    Test test;
    const double total = left_.squaredNorm(), rest = dof_ - rank;
    if (rank == 0 || rest < 3 || !(total > 0.0)) return test;
    const double after = std::max(total - drop, kTiny);
    test.share = std::max(0.0, 1.0 - after / rest / (total / dof_));
    test.logP = logPValueF(drop / rank / (after / rest), rank, rest);
    return test;
  }

 private:
  Eigen::MatrixXd whitened(const Eigen::MatrixXd& whole) const {
    if (noise_ == nullptr) return whole;
    RowMatrix columns = whole;
    noise_->whiten(columns);
    return columns;
  }

  /// What the basis leaves of columns, as parts of what they were: of one that it absorbs nothing but
  /// rounding.
  Eigen::MatrixXd unitColumns(const Eigen::MatrixXd& whole) const {
    Eigen::MatrixXd columns = whitened(whole);
    for (int k = 0; k < columns.cols(); ++k) {
      const double norm = columns.col(k).norm();
      columns.col(k) /= norm > 0.0 ? norm : 1.0;
    }
    const Eigen::MatrixXd absorbed = basis_.transpose() * columns;
    columns.noalias() -= basis_ * absorbed;
    return columns;
  }

  const TimeWhitener* noise_;
  Eigen::MatrixXd basis_;
  Eigen::VectorXd left_;
  double dof_ = 1.0;
};

Eigen::MatrixXd times(const ResidualSpace& space, const Eigen::MatrixXd& terms,
                      const Eigen::MatrixXd& factors) {
  Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(space.problem().rowCount(), terms.cols() * factors.cols());
  for (int i = 0; i < space.rows(); ++i)
    for (int d = 0; d < factors.cols(); ++d)
      for (int k = 0; k < terms.cols(); ++k)
        columns(space.used()[i], d * terms.cols() + k) = factors(i, d) * terms(i, k);
  return space.whiten(columns);
}

}  // namespace

std::vector<Variable> variablesOf(const ResidualSpace& space) {
  const Problem& problem = space.problem();
  const Domain& domain = problem.model().domain();
  const int n = space.rows();
  std::vector<Variable> variables;
  const auto collect = [&](auto value) {
    Eigen::VectorXd raw(n);
    for (int i = 0; i < n; ++i) raw[i] = value(problem.state(problem.rows()[space.used()[i]].observation));
    return raw;
  };
  for (int j = 0; j < static_cast<int>(domain.joints.size()); ++j) {
    const bool linear = domain.joints[j].kind == JointKind::kLinear;
    const std::string& name = domain.joints[j].name;
    addVariable(variables, name, name,
                collect([&](const State& s) { return s.position[j] / (linear ? kMillimetre : 1.0); }), false);
    addVariable(variables, name + " travel direction", "",
                collect([&](const State& s) { return s.travel[j] == 0.0 ? kNotMeasured : s.travel[j]; }),
                true);
    addVariable(variables, name + " speed", name + "_velocity",
                collect([&](const State& s) { return s.velocity[j] / (linear ? kMillimetre : 1.0); }), false);
  }
  const char* const axes[] = {"x", "y", "z"};
  for (int k = 0; k < 3; ++k)
    addVariable(variables, std::string("approach ") + axes[k], "", collect([&](const State& s) {
                  return s.approach.norm() > 0.5 ? s.approach[k] : kNotMeasured;
                }),
                false);
  addVariable(variables, "time", "t", collect([&](const State& s) { return s.time; }), false);
  for (std::size_t k = 0; k < domain.sensors.size(); ++k)
    addVariable(variables, "temperature " + domain.sensors[k], domain.sensors[k],
                collect([&](const State& s) { return s.temperature[k]; }), false);
  for (std::size_t k = 0; k < domain.covariates.size(); ++k)
    addVariable(variables, domain.covariates[k], domain.covariates[k],
                collect([&](const State& s) { return s.covariate[k]; }), false);
  const auto& features = problem.session().artifact.features;
  const auto category = [&](const char* name, std::vector<std::string> labels, auto indexOf) {
    if (labels.size() < 2 || labels.size() > kMostBalls) return;
    Eigen::VectorXd raw(n);
    for (int i = 0; i < n; ++i) {
      const int index = indexOf(problem.session().observations[static_cast<std::size_t>(
          problem.rows()[static_cast<std::size_t>(space.used()[static_cast<std::size_t>(i)])].observation)]);
      raw[i] = index < 0 ? kNotMeasured : index;
    }
    const std::size_t before = variables.size();
    addVariable(variables, name, "", raw, true);
    if (variables.size() > before) variables.back().labels = std::move(labels);
  };
  std::vector<std::string> balls, styli, sessions;
  for (const Feature& f : features) balls.push_back(f.name);
  for (const Stylus& s : problem.session().artifact.styli) styli.push_back(s.name);
  for (const Recording& r : problem.session().recordings)
    sessions.push_back(std::filesystem::path(r.source).filename().string());
  category("ball", balls, [](const Observation& o) { return o.feature; });
  category("stylus", styli, [](const Observation& o) { return o.feature < 0 ? -1 : o.stylus; });
  category("placement", problem.session().placements, [](const Observation& o) { return o.placement; });
  category("session", sessions, [](const Observation& o) { return o.recording; });
  if (problem.session().hasLaser())
    addVariable(variables, "laser reading",
                domain.laser && domain.findCovariate("reading") < 0 ? "reading" : "",
                collect([&](const State& s) { return s.laserReading / kMillimetre; }), false);
  return variables;
}

Directions directionsOf(const ResidualSpace& space) {
  return directionsOf(space.linearisation(), space.used());
}

std::vector<WhereItFails> explainedByVariable(const ResidualSpace& space, const TimeWhitener* noise,
                                              const RowMatrix& scatter) {
  const std::vector<Variable> variables = variablesOf(space);
  const Directions directions = directionsOf(space);
  ShareTest questions(space, noise, scatter);
  const auto columnsOf = [&](const Variable& v) {
    // about their means: a constant in some direction is no variable's, and none shall seem to explain it
    const Eigen::MatrixXd terms = termsOf(v, 4);
    return times(space, terms.rowwise() - terms.colwise().mean(), directions.factors);
  };
  const auto probability = [&](const Test& t) {
    return std::min(1.0, std::exp(t.logP) * static_cast<double>(variables.size()));
  };
  std::vector<std::pair<WhereItFails, const Variable*>> asked;
  for (const Variable& v : variables) {
    const Test t = questions.ask(columnsOf(v));
    asked.push_back({{v.name, t.share, probability(t)}, &v});
  }
  std::stable_sort(asked.begin(), asked.end(), [](const auto& a, const auto& b) {
    return a.first.share != b.first.share ? a.first.share > b.first.share : a.first.pValue < b.first.pValue;
  });
  std::vector<WhereItFails> out;
  for (auto& [where, variable] : asked) {
    const Eigen::MatrixXd columns = columnsOf(*variable);
    const Test beside = questions.ask(columns);
    where.shareBeside = beside.share;
    where.pBeside = probability(beside);
    questions.absorb(columns);
    out.push_back(where);
  }
  return out;
}

}  // namespace mm
