#include "report/report_variables.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/dense.h"
#include "base/units.h"
#include "diagnosis/structure.h"
#include "estimation/residual_space.h"

namespace mm {
namespace {

constexpr double kSeen = 0.05;        // least mean square of the direction's factor in a bin
constexpr std::size_t kPoints = 600;  // drawn a variable; the bins use all rows

/// The rows of one kind (m or rad), in units of people.
struct Rows {
  std::vector<int> space;                          // row of the residual space
  std::vector<double> residual, improved, weight;  // um or arcsec, 1/um^2 or 1/arcsec^2
  std::vector<double>
      varying;  // the residual without what a constant displacement in every direction explains
};

/// A variable's unit for people and the factor from the unit of formulas.
struct Scale {
  std::string unit;
  double factor = 1.0;
};

Scale scaleOf(const Variable& variable, const Problem& problem) {
  const Domain& domain = problem.model().domain();
  for (const Joint& joint : domain.joints) {
    const bool rotary = joint.kind == JointKind::kRotary;
    if (variable.name == joint.name) return {rotary ? "deg" : "mm", rotary ? 1.0 / kDegree : 1.0};
    if (variable.name == joint.name + " speed")
      return {rotary ? "deg/s" : "mm/s", rotary ? 1.0 / kDegree : 1.0};
  }
  if (variable.name == "time")
    return domain.duration > 7200.0  ? Scale{"h", 1.0 / 3600.0}
           : domain.duration > 300.0 ? Scale{"min", 1.0 / 60.0}
                                     : Scale{"s", 1.0};
  if (variable.name.rfind("temperature ", 0) == 0) return {"degC", 1.0};
  if (variable.name == "laser reading") return {"mm", 1.0};
  for (const Series& series : problem.session().covariates)
    if (series.name == variable.name) return {series.unit, 1.0};
  return {};
}

std::string labelOf(const Variable& variable, double level) {
  if (!variable.labels.empty()) return variable.labels[static_cast<std::size_t>(level)];
  return level > 0.0 ? "+" : "\u2212";
}

/// Rows in bins: one a level where there are few, else about as many rows in each. Equal values stay
/// together.
std::vector<std::vector<int>> binsOf(const Eigen::VectorXd& values, const Rows& rows) {
  constexpr std::size_t kLevels = 16;
  std::vector<int> order(rows.space.size());
  std::iota(order.begin(), order.end(), 0);
  const auto value = [&](int i) { return values[rows.space[static_cast<std::size_t>(i)]]; };
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return value(a) < value(b); });
  std::vector<std::vector<int>> levels;
  for (const int i : order) {
    constexpr double kSameLevel = 1e-4;  // of the variable's own unit
    if (levels.empty() || value(i) - value(levels.back().front()) > kSameLevel) levels.emplace_back();
    levels.back().push_back(i);
  }
  if (levels.size() <= kLevels) return levels;
  const double wanted = std::clamp(std::sqrt(static_cast<double>(order.size())) / 1.5, 6.0, 40.0);
  const auto enough = static_cast<std::size_t>(std::ceil(static_cast<double>(order.size()) / wanted));
  std::vector<std::vector<int>> bins(1);
  for (const std::vector<int>& level : levels) {
    if (bins.back().size() >= enough) bins.emplace_back();
    bins.back().insert(bins.back().end(), level.begin(), level.end());
  }
  if (bins.size() > 1 && 2 * bins.back().size() < enough) {
    const std::vector<int> last = bins.back();
    bins.pop_back();
    bins.back().insert(bins.back().end(), last.begin(), last.end());
  }
  return bins;
}

struct Line {
  std::vector<VariableBin> bins;
  double gain = 0.0;  // what the bins explain of the varying part, whitened
};

/// The mean deviation along one direction in each bin: weighted least squares of residual = -factor *
/// deviation.
Line lineOf(const std::vector<std::vector<int>>& bins, const Rows& rows, const Eigen::VectorXd& values,
            const Eigen::VectorXd& factor) {
  Line line;
  const double most = factor.cwiseAbs().maxCoeff();
  double scatter = 0.0;
  int rest = 0;
  std::vector<double> information;
  for (const std::vector<int>& bin : bins) {
    double ff = 0.0, fr = 0.0, fi = 0.0, fv = 0.0, at = 0.0, seen = 0.0;
    for (const int i : bin) {
      const auto k = static_cast<std::size_t>(i);
      const double f = factor[rows.space[k]], w = rows.weight[k];
      ff += w * f * f;
      fr -= w * f * rows.residual[k];
      fi -= w * f * rows.improved[k];
      fv -= w * f * rows.varying[k];
      at += values[rows.space[k]];
      seen += f * f / (most * most);
    }
    if (!(seen > kSeen * static_cast<double>(bin.size())))
      continue;  // the direction was hardly measured here
    VariableBin one;
    one.at = at / static_cast<double>(bin.size());
    one.mean = fr / ff;
    one.meanImproved = fi / ff;
    one.count = static_cast<int>(bin.size());
    for (const int i : bin) {
      const auto k = static_cast<std::size_t>(i);
      const double left = rows.residual[k] + factor[rows.space[k]] * one.mean;
      scatter += rows.weight[k] * left * left;
    }
    rest += one.count - 1;
    information.push_back(ff);
    line.gain += fv * fv / ff;
    line.bins.push_back(one);
  }
  const double variance = rest > 0 ? scatter / rest : 1.0;  // pooled: single bins may hold very few rows
  for (std::size_t b = 0; b < line.bins.size(); ++b)
    line.bins[b].standardError = std::sqrt(variance / information[b]);
  return line;
}

/// Takes out of the residual what a constant displacement along each direction explains, all fitted together.
void removeConstants(Rows& rows, const Eigen::MatrixXd& factors) {
  const auto n = static_cast<Eigen::Index>(rows.space.size());
  const Eigen::ArrayXd root = Eigen::Map<const Eigen::ArrayXd>(rows.weight.data(), n).sqrt();
  const Eigen::VectorXd whitened = root * Eigen::Map<const Eigen::ArrayXd>(rows.residual.data(), n);
  const Eigen::MatrixXd columns = root.matrix().asDiagonal() * factors(rows.space, Eigen::all);
  const Eigen::ArrayXd left = whitened - columns * leastSquares(columns, whitened);
  rows.varying.resize(rows.space.size());
  Eigen::Map<Eigen::ArrayXd>(rows.varying.data(), n) = left / root;
}

void addPoints(VariableView& view, const Rows& rows, const Eigen::VectorXd& raw,
               const Eigen::VectorXd& factor) {
  const double largest = factor.cwiseAbs().maxCoeff();
  const auto along = [&](std::size_t i) {
    return residualAlong(rows.residual[i], factor[rows.space[i]], largest);
  };
  std::vector<int> seen;
  for (std::size_t i = 0; i < rows.space.size(); ++i)
    if (std::isfinite(along(i))) seen.push_back(static_cast<int>(i));
  const std::size_t shown = std::min(kPoints, seen.size());
  for (std::size_t n = 0; n < shown; ++n) {
    const auto i = static_cast<std::size_t>(seen[n * seen.size() / shown]);
    view.x.push_back(raw[rows.space[i]]);
    view.y.push_back(along(i));
  }
}

VariableView viewOf(const Variable& variable, const Directions& directions, const Rows& rows,
                    const Problem& problem) {
  VariableView view;
  view.name = variable.name;
  view.category = variable.category;
  view.observations = static_cast<int>(rows.space.size());
  const std::vector<std::vector<int>> bins = binsOf(variable.values, rows);
  const Scale scale = scaleOf(variable, problem);
  view.unit = scale.unit;
  Eigen::VectorXd raw = variable.values;
  if (!variable.category) raw = (variable.centre + variable.half * variable.values.array()) * scale.factor;
  double best = -1.0;
  int direction = 0;
  for (int d = 0; d < directions.factors.cols(); ++d) {
    Line line = lineOf(bins, rows, raw, directions.factors.col(d));
    if (line.bins.empty() || !(line.gain > best)) continue;
    best = line.gain;
    direction = d;
    view.bins = std::move(line.bins);
  }
  if (view.bins.empty()) return view;
  view.direction = directions.names[static_cast<std::size_t>(direction)];
  addPoints(view, rows, raw, directions.factors.col(direction));
  if (!view.category) return view;
  const bool travel = variable.labels.empty();
  const auto unknown = [&](double level) {
    return travel ? std::abs(level) != 1.0 : level != std::floor(level);
  };
  std::vector<VariableBin> known;
  std::vector<double> levels;
  for (const VariableBin& bin : view.bins) {  // a category's levels are numbered from 0
    if (unknown(bin.at)) continue;            // rows whose level is not known
    levels.push_back(bin.at);
    view.labels.push_back(labelOf(variable, bin.at));
    known.push_back(bin);
    known.back().at = static_cast<double>(levels.size()) - 1.0;
  }
  view.bins = std::move(known);
  std::vector<double> x, y;
  for (std::size_t i = 0; i < view.x.size(); ++i) {
    const auto level = std::find(levels.begin(), levels.end(), view.x[i]);
    if (level == levels.end()) continue;
    x.push_back(static_cast<double>(level - levels.begin()));
    y.push_back(view.y[i]);
  }
  view.x = std::move(x);
  view.y = std::move(y);
  return view;
}

}  // namespace

double residualAlong(double residual, double factor, double largest) {
  constexpr double kLeast = 0.5;  // of the largest factor: a touch from the side tells little
  return std::abs(factor) > 0.0 && std::abs(factor) >= kLeast * largest ? -residual / factor : kNotMeasured;
}

void dropUnmeasured(Directions& directions) {
  constexpr double kTellsNothing = 0.02;  // of the largest factor of all
  if (directions.names.empty() || directions.factors.rows() == 0) return;
  const double least = kTellsNothing * directions.factors.cwiseAbs().maxCoeff();
  std::vector<std::string> names;
  std::vector<int> measured;
  for (int d = 0; d < directions.factors.cols(); ++d) {
    if (directions.factors.col(d).cwiseAbs().maxCoeff() < least) continue;
    names.push_back(directions.names[static_cast<std::size_t>(d)]);
    measured.push_back(d);
  }
  directions = {names, directions.factors(Eigen::all, measured)};
}

std::vector<VariableView> residualsByVariable(const CalibrationResult& fitted,
                                              const CalibrationResult* improved,
                                              const std::vector<WhereItFails>& where) {
  const ResidualSpace space(fitted);
  const bool angular = !std::isfinite(fitted.figures.rms);
  const double unit = angular ? kArcsecond : kMicrometre;
  const bool paired = improved != nullptr && improved->residuals.size() == fitted.residuals.size();
  Rows rows;
  for (int i = 0; i < space.rows(); ++i) {
    const int row = space.used()[static_cast<std::size_t>(i)];
    if (fitted.problem->rows()[static_cast<std::size_t>(row)].angular != angular) continue;
    rows.space.push_back(i);
    rows.residual.push_back(fitted.residuals[row] / unit);
    rows.improved.push_back(paired ? improved->residuals[row] / unit : kNotMeasured);
    rows.weight.push_back(unit * unit / (fitted.sigma[row] * fitted.sigma[row]));
  }
  Directions directions = directionsOf(space);
  dropUnmeasured(directions);
  std::vector<VariableView> views;
  if (rows.space.empty() || directions.names.empty()) return views;
  removeConstants(rows, directions.factors);
  for (const Variable& variable : variablesOf(space)) {
    VariableView view = viewOf(variable, directions, rows, *fitted.problem);
    if (!view.bins.empty()) views.push_back(std::move(view));
  }
  const auto place = [&](const VariableView& v) {
    return std::find_if(where.begin(), where.end(),
                        [&](const WhereItFails& w) { return w.variable == v.name; });
  };
  for (VariableView& view : views)
    if (const auto found = place(view); found != where.end()) {
      view.share = found->share;
      view.pValue = found->pValue;
    }
  std::stable_sort(views.begin(), views.end(),
                   [&](const VariableView& a, const VariableView& b) { return place(a) < place(b); });
  return views;
}

}  // namespace mm
