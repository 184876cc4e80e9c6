#include "diagnosis/structure.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <set>

#include "machine/cancel_scope.h"
#include "machine/units.h"

namespace mm {
namespace {

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
    if (variable.half < 1e-9 * std::abs(variable.centre)) return;
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
      const double next = ((2 * k + 1) * v.values[i] * now - k * before) / (k + 1);
      before = now;
      now = next;
    }
  }
  return terms;
}

struct Test {
  double share = 0.0, logP = 0.0;
};

/// F test of what the columns explain of `left` beyond the model and what was found.
Test explain(const ResidualSpace& space, const Eigen::VectorXd& left, const Eigen::MatrixXd& found,
             Eigen::MatrixXd columns) {
  CancelScope::check();
  space.project(columns);
  if (found.cols() > 0) columns -= found * (found.transpose() * columns);
  for (int k = 0; k < columns.cols(); ++k) {
    const double norm = columns.col(k).norm();
    columns.col(k) /= norm > 0.0 ? norm : 1.0;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(columns.transpose() * columns);
  const Eigen::VectorXd score = eigen.eigenvectors().transpose() * (columns.transpose() * left);
  double drop = 0.0;
  int rank = 0;
  for (int k = 0; k < score.size(); ++k)
    if (eigen.eigenvalues()[k] > 1e-4) {
      drop += score[k] * score[k] / eigen.eigenvalues()[k];
      ++rank;
    }
  Test test;
  const double total = left.squaredNorm();
  const double dof = static_cast<double>(space.length() - space.baseRank() - found.cols());
  const double rest = dof - rank;
  if (rank == 0 || rest < 3 || !(total > 0.0)) return test;
  const double after = std::max(total - drop, 1e-300);
  test.share = std::max(0.0, 1.0 - after / rest / (total / dof));
  test.logP = logPValueF(drop / rank / (after / rest), rank, rest);
  return test;
}

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
  if (features.size() > 1 && features.size() <= 40)
    addVariable(variables, "ball", "",
                collect([&](const State& s) { return s.feature < 0 ? kNotMeasured : s.feature; }), true);
  if (problem.session().hasLaser())
    addVariable(variables, "laser reading", "", collect([&](const State& s) { return s.laserReading; }),
                false);
  return variables;
}

Directions directionsOf(const ResidualSpace& space) {
  const Problem& problem = space.problem();
  const ErrorLayout layout = problem.model().machine().layout();
  Directions directions;
  const auto add = [&](const std::string& name, auto value) {
    Eigen::VectorXd column(space.rows());
    for (int i = 0; i < space.rows(); ++i) column[i] = value(space.used()[i]);
    if (!(column.norm() > 0.0)) return;
    directions.names.push_back(name);
    directions.factors.conservativeResize(space.rows(), directions.names.size());
    directions.factors.rightCols<1>() = column;
  };
  const auto& joints = problem.model().machine().joints();
  const auto& g = problem.slotGradients();
  std::set<std::string> taken;
  const char* const axes[] = {"x", "y", "z"};
  for (int j = 0; j < static_cast<int>(joints.size()); ++j)
    if (joints[j].kind == JointKind::kLinear ||
        std::any_of(problem.rows().begin(), problem.rows().end(), [](auto& r) { return r.angular; })) {
      add(joints[j].name, [&](int row) { return g(row, layout.axis(j)); });
      taken.insert(joints[j].name);
    }
  bool linear = std::any_of(problem.rows().begin(), problem.rows().end(), [](auto& r) { return !r.angular; });
  for (int k = 0; k < 3 && linear; ++k)
    if (!taken.count(axes[k])) add(axes[k], [&](int row) { return g(row, layout.volume(k)); });
  add("approach", [&](int row) {
    const Eigen::Vector3d a = problem.state(problem.rows()[row].observation).approach;
    double sum = 0.0;
    for (int k = 0; k < 3; ++k) sum += a[k] * g(row, layout.volume(k));
    return std::isfinite(sum) ? sum : 0.0;
  });
  return directions;
}

std::vector<WhereItFails> explainedByVariable(const ResidualSpace& space, const Eigen::VectorXd& left,
                                              const Eigen::MatrixXd& found) {
  const std::vector<Variable> variables = variablesOf(space);
  const Directions directions = directionsOf(space);
  // a constant in each direction is no variable's: with it in, every variable would seem to explain it
  Eigen::MatrixXd constants = times(space, Eigen::MatrixXd::Ones(space.rows(), 1), directions.factors);
  space.project(constants);
  if (found.cols() > 0) constants -= found * (found.transpose() * constants);
  for (int k = 0; k < constants.cols(); ++k) constants.col(k) /= std::max(constants.col(k).norm(), 1e-300);
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(constants);
  qr.setThreshold(1e-3);
  const Eigen::MatrixXd even = qr.householderQ() * Eigen::MatrixXd::Identity(constants.rows(), qr.rank());
  Eigen::MatrixXd known(space.length(), found.cols() + even.cols());
  known << found, even;
  const Eigen::VectorXd uneven = left - even * (even.transpose() * left);
  std::vector<WhereItFails> out;
  for (const Variable& v : variables) {
    Test t = explain(space, uneven, known, times(space, termsOf(v, 4), directions.factors));
    t.share *= uneven.squaredNorm() / std::max(left.squaredNorm(), 1e-300);
    out.push_back({v.name, t.share, std::min(1.0, std::exp(t.logP) * static_cast<double>(variables.size()))});
  }
  std::stable_sort(out.begin(), out.end(), [](const WhereItFails& a, const WhereItFails& b) {
    return a.share != b.share ? a.share > b.share : a.pValue < b.pValue;
  });
  return out;
}

Structure structureLeft(const ResidualSpace& space, const Eigen::VectorXd& left, const Eigen::MatrixXd& found,
                        const Eigen::MatrixXd& others) {
  const std::vector<Variable> variables = variablesOf(space);
  const Directions directions = directionsOf(space);
  std::vector<Test> tests;
  const auto test = [&](const Eigen::MatrixXd& terms) {
    if (3 * terms.cols() * directions.factors.cols() < space.rows())
      tests.push_back(explain(space, left, found, times(space, terms, directions.factors)));
  };
  for (std::size_t a = 0; a < variables.size(); ++a) {
    test(termsOf(variables[a], 6));
    for (std::size_t b = a + 1; b < variables.size(); ++b) {
      if (variables[a].name == "ball" || variables[b].name == "ball") continue;
      const Eigen::MatrixXd ua = termsOf(variables[a], 2), ub = termsOf(variables[b], 2);
      Eigen::MatrixXd product(ua.rows(), ua.cols() * ub.cols());
      for (int i = 0; i < ua.cols(); ++i)
        for (int j = 0; j < ub.cols(); ++j)
          product.col(i * ub.cols() + j) = ua.col(i).cwiseProduct(ub.col(j));
      test(product);
    }
  }
  for (int k = 0; k < others.cols(); ++k) tests.push_back(explain(space, left, found, others.col(k)));
  Structure structure;
  for (const Test& t : tests) {
    const double p = std::min(1.0, std::exp(t.logP) * static_cast<double>(tests.size()));
    if (p < structure.pValue) structure.pValue = p;
    if (p < 1e-4) structure.share = std::max(structure.share, t.share);
  }
  return structure;
}

}  // namespace mm
