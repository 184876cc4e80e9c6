#include "export/fitted_tables.h"

#include <algorithm>
#include <cmath>

#include "base/dense.h"
#include "base/format.h"
#include "base/grid_values.h"
#include "base/quantity_words.h"
#include "base/units.h"
#include "export/export_target.h"
#include "export/hat_functions.h"

namespace mm {
namespace {

constexpr double kOfAStep = 1e-6;      // by which a limit may lie beside a step through rounding
constexpr double kStandsStill = 1e-9;  // RMS of an input, m or rad: it says nothing

constexpr int kTableOthers = 16;    // states of everything else, over which a table is the mean
constexpr int kTableProbes = 3;     // of them, by which the steps are chosen
constexpr int kProbesAStep = 8;     // of the finest steps
constexpr int kSamplesAStep = 4;    // of the steps chosen
constexpr int kCoarsest = 16;       // finest steps
constexpr int kTableStates = 600;   // of the straight part
constexpr double kFollowed = 2e-8;  // m
constexpr double kToldLeft = 3e-8;  // m: no less is told as not followed
constexpr double kHardlyMore = 1.02;
constexpr double kStandsOut = 4.0;  // standard errors
constexpr double kStepUnit = 1e-7;  // m
constexpr unsigned kTableSeed = 11, kPlaneSeed = 12, kStraightSeed = 13;

double between(const std::vector<double>& at, const std::vector<double>& values, double position) {
  if (values.size() == 1) return values[0];
  const auto [i, share] = placeAmong(at, position);
  return values[i] + share * (values[i + 1] - values[i]);
}

/// The mean of the correction over the other states, at one position and direction of an axis.
Eigen::VectorXd meanAt(const NeededCorrection& needed, CorrectionPart part, std::vector<State>& others,
                       int input, double position, double travel) {
  return meanOver(needed, part, others, [&](State& state) {
    state.position[input] = position;
    state.travel[input] = travel;
  });
}

/// How coarse a table is.
struct Stride {
  int steps = 1;  // finest steps that one of its own takes: 16, 8, 4, 2 or 1
  bool followed = false;
};

/// Judged by the displacements of the probe in few states, at places between the finest points where no
/// period is hidden.
Stride strideOf(const NeededCorrection& needed, int input, const std::vector<double>& finest, int coarsest) {
  const ExportAxis& axis = needed.axis(input);
  std::vector<State> probes = needed.states(kTableOthers, kTableSeed);
  probes.resize(kTableProbes);
  const std::vector<double> at = samplesWithin(finest, kProbesAStep);
  Eigen::MatrixXd curves(at.size(), 6 * kTableProbes);
  for (std::size_t n = 0; n < at.size(); ++n)
    for (int p = 0; p < 2 * kTableProbes; ++p) {
      State& state = probes[p / 2];
      state.position[input] = std::clamp(at[n], axis.lower, axis.upper);
      state.travel[input] = p % 2 == 0 ? 1.0 : -1.0;
      curves.block<1, 3>(n, 3 * p) = needed.displacement(state).transpose();
    }
  const auto left = [&](int stride) {
    std::vector<double> points;
    for (std::size_t i = 0; i < finest.size(); i += stride) points.push_back(finest[i]);
    return hatHeldOut(points, at, curves);
  };
  const auto follows = [](const Eigen::MatrixXd& remainder) {
    return remainder.cwiseAbs().maxCoeff() < kFollowed;
  };
  const Eigen::MatrixXd least = left(1);
  for (int stride = coarsest; stride > 1; stride /= 2) {
    const Eigen::MatrixXd here = left(stride);
    bool enough = true;
    for (Eigen::Index c = 0; c < here.cols() && enough; ++c)
      enough = follows(here.col(c)) || here.col(c).norm() < kHardlyMore * least.col(c).norm();
    if (enough) return {stride, follows(here)};
  }
  return {1, follows(least)};
}

/// Points of a table, as fine as it may be.
struct FinestPoints {
  std::vector<double> at;
  int coarsest = kCoarsest;  // of them, that a step may take
};

/// Steps of the tables that were active over the joint, in whole parts, as far as the observed range and they
/// reach; none where there are none, or they are not equal, or too many.
FinestPoints pointsOfActive(const NeededCorrection& needed, int input, int most) {
  FinestPoints finest;
  const std::vector<double> points = needed.activePoints(input);
  if (points.size() < 2) return finest;
  const double step = points[1] - points[0];
  for (std::size_t i = 1; i < points.size(); ++i)
    if (std::abs(points[i] - points[0] - i * step) > kOfAStep * step) return finest;
  const ExportAxis& axis = needed.axis(input);
  const auto beyond = [&](double distance) {
    return std::max(0, static_cast<int>(std::ceil(distance / step - kOfAStep)));
  };
  const int before = beyond(points.front() - axis.lower), after = beyond(axis.upper - points.back());
  const int steps = before + static_cast<int>(points.size()) - 1 + after;
  const auto whole = [&](int parts) {
    const double part = step / parts / kStepUnit;
    return std::abs(part - std::round(part)) < kOfAStep * part;
  };
  for (finest.coarsest = kCoarsest; finest.coarsest > 1; finest.coarsest /= 2)
    if (steps * finest.coarsest < most && whole(finest.coarsest)) break;
  if (steps >= most) return finest;
  for (int i = 0; i <= steps * finest.coarsest; ++i)
    finest.at.push_back(points.front() + (static_cast<double>(i) / finest.coarsest - before) * step);
  return finest;
}

FinestPoints finestPoints(const NeededCorrection& needed, int input, int mostPoints) {
  FinestPoints finest = pointsOfActive(needed, input, mostPoints);
  if (!finest.at.empty()) return finest;
  const auto [lower, upper] = needed.tabulated(input);
  finest.coarsest = kCoarsest;
  finest.at = evenSteps(lower, upper, std::max(1, (mostPoints - 1) / kCoarsest) * kCoarsest);
  return finest;
}

/// What the active compensation adds is known at every place: it is taken as it is, never fitted.
void addActive(const NeededCorrection& needed, std::vector<State>& others, LineTable& table) {
  for (std::size_t i = 0; i < table.at.size(); ++i)
    for (auto* values : {&table.positive, &table.negative}) {
      const Eigen::VectorXd here = meanAt(needed, &NeededCorrection::activeAt, others, table.input,
                                          table.at[i], values == &table.positive ? 1.0 : -1.0);
      for (std::size_t j = 0; j < values->size(); ++j) (*values)[j][i] += here[j];
    }
}

void subtractReference(LineTable& table, double reference) {
  for (std::size_t j = 0; j < table.positive.size(); ++j) {
    const double zero = table.value(j, reference, 0.0);
    for (std::size_t i = 0; i < table.at.size(); ++i) {
      table.positive[j][i] -= zero;
      table.negative[j][i] -= zero;
    }
  }
}

/// Each state twice, the second time with everything but the positions mirrored: a curve over positions then
/// never passes for a reversal or for thermal growth.
std::vector<State> mirrored(const NeededCorrection& needed, int count) {
  const Domain& d = needed.model().domain();
  std::vector<State> states = needed.states(count, kStraightSeed);
  for (int n = 0; n < count; ++n) {
    State other = states[n];
    for (double& travel : other.travel) travel = -travel;
    for (std::size_t k = 0; k < d.sensors.size(); ++k)
      other.temperature[k] = d.sensorLower[k] + d.sensorUpper[k] - other.temperature[k];
    for (std::size_t k = 0; k < d.covariates.size(); ++k)
      other.covariate[k] = d.covariateLower[k] + d.covariateUpper[k] - other.covariate[k];
    other.time = d.duration - other.time;
    states.push_back(other);
  }
  return states;
}

}  // namespace

std::vector<double> evenSteps(double from, double to, int intervals) {
  const double start = std::floor(from / kStepUnit + kOfAStep);
  const double step = std::max(1.0, std::ceil((to / kStepUnit - start) / intervals - kOfAStep));
  std::vector<double> at;
  for (int i = 0; i <= intervals; ++i) at.push_back((start + i * step) * kStepUnit);
  return at;
}

double LineTable::value(int output, double position, double travel) const {
  const double up = between(at, positive[output], position), down = between(at, negative[output], position);
  return travel > 0.0 ? up : travel < 0.0 ? down : 0.5 * (up + down);
}

double LineTable::largest(int output) const {
  double most = 0.0;
  for (std::size_t i = 0; i < at.size(); ++i)
    most = std::max({most, std::abs(positive[output][i]), std::abs(negative[output][i])});
  return most;
}

LineTable lineTable(const NeededCorrection& needed, int input, int mostPoints, CorrectionPart part) {
  const FinestPoints finest = finestPoints(needed, input, mostPoints);
  const Stride stride = strideOf(needed, input, finest.at, finest.coarsest);
  LineTable table;
  table.input = input;
  table.samplesAStep = stride.followed ? kSamplesAStep : kSamplesAStep * stride.steps;
  for (std::size_t i = 0; i < finest.at.size(); i += stride.steps) table.at.push_back(finest.at[i]);
  std::vector<State> others = needed.states(kTableOthers, kTableSeed);
  const std::vector<double> at = samplesWithin(table.at, table.samplesAStep);
  const Eigen::Index joints = needed.axes().size();
  Eigen::MatrixXd curves(at.size(), 2 * joints);  // upwards, downwards
  for (std::size_t n = 0; n < at.size(); ++n)
    curves.row(n) << meanAt(needed, &NeededCorrection::adds, others, input, at[n], 1.0).transpose(),
        meanAt(needed, &NeededCorrection::adds, others, input, at[n], -1.0).transpose();
  const Eigen::MatrixXd values = hatOrLineFit(table.at, at, curves);
  const Eigen::MatrixXd left = hatRemainder(table.at, values, at, curves).cwiseAbs();
  for (Eigen::Index j = 0; j < joints; ++j) {
    const Eigen::VectorXd up = values.col(j), down = values.col(joints + j);
    table.positive.emplace_back(up.begin(), up.end());
    table.negative.emplace_back(down.begin(), down.end());
    table.left.push_back(std::max(left.col(j).maxCoeff(), left.col(joints + j).maxCoeff()));
  }
  subtractReference(table, needed.reference(input));
  for (int j = 0; j < joints; ++j) table.added.push_back(table.largest(j));
  if (needed.active() != nullptr && part != &NeededCorrection::adds) {
    addActive(needed, others, table);
    subtractReference(table, needed.reference(input));
  }
  return table;
}

Eigen::VectorXd meanCorrection(const NeededCorrection& needed, int input, double position,
                               CorrectionPart part) {
  std::vector<State> others = needed.states(kTableOthers, kTableSeed);
  return 0.5 * (meanAt(needed, part, others, input, position, 1.0) +
                meanAt(needed, part, others, input, position, -1.0));
}

void addNotFollowed(const NeededCorrection& needed, const LineTable& table, const std::vector<int>& outputs,
                    Exported& out) {
  const auto letter = [&](int joint) { return capital(needed.axis(joint).letter); };
  for (const int output : outputs) {
    const double left = table.left[output];
    if (left < kToldLeft) continue;
    out.notFollowed.push_back(format(
        "the correction of %s by the position of %s varies between the points even of the finest table (%zu "
        "points, every %.4g mm): up to %s of it remain",
        letter(output).c_str(), letter(table.input).c_str(), table.at.size(),
        (table.at[1] - table.at[0]) / kMillimetre, errorInWords(left, false).c_str()));
  }
}

double PlaneTable::interpolated(int output, double a, double b) const {
  const Eigen::MatrixXd& v = value[output];
  const auto [i, s] = placeAmong(atFirst, a);
  const auto [k, t] = placeAmong(atSecond, b);
  return (1 - s) * ((1 - t) * v(i, k) + t * v(i, k + 1)) + s * ((1 - t) * v(i + 1, k) + t * v(i + 1, k + 1));
}

Eigen::VectorXd meanOver(const NeededCorrection& needed, CorrectionPart part, std::vector<State>& states,
                         const std::function<void(State&)>& put) {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(needed.axes().size());
  for (State& state : states) {
    put(state);
    sum += (needed.*part)(state);
  }
  return sum / states.size();
}

PlaneTable planeTable(const NeededCorrection& needed, int first, int second, std::vector<double> atFirst,
                      std::vector<double> atSecond, CorrectionPart part) {
  PlaneTable plane{first, second, std::move(atFirst), std::move(atSecond), {}};
  const std::size_t rows = plane.atFirst.size(), columns = plane.atSecond.size();
  const std::size_t joints = needed.axes().size();
  plane.value.assign(joints, Eigen::MatrixXd::Zero(rows, columns));
  std::vector<State> others = needed.states(kTableOthers, kPlaneSeed);
  for (std::size_t i = 0; i < rows; ++i)
    for (std::size_t k = 0; k < columns; ++k) {
      const Eigen::VectorXd mean = meanOver(needed, part, others, [&](State& state) {
        state.position[first] = plane.atFirst[i];
        state.position[second] = plane.atSecond[k];
      });
      for (std::size_t j = 0; j < joints; ++j) plane.value[j](i, k) = mean[j];
    }
  for (std::size_t j = 0; j < joints; ++j)
    plane.value[j].array() -= plane.interpolated(j, needed.reference(first), needed.reference(second));
  return plane;
}

StraightPart straightPart(const NeededCorrection& needed, CorrectionPart which) {
  const std::vector<State> states = mirrored(needed, kTableStates / 2);
  const Eigen::Index joints = needed.axes().size(), sensors = needed.model().domain().sensors.size();
  Eigen::MatrixXd inputs(kTableStates, 1 + 2 * joints + sensors), outputs(kTableStates, joints);
  for (int n = 0; n < kTableStates; ++n) {
    const State& s = states[n];
    inputs(n, 0) = 1.0;
    for (Eigen::Index j = 0; j < joints; ++j) {
      inputs(n, 1 + j) = s.position[j];
      inputs(n, 1 + joints + j) = s.travel[j];
    }
    for (Eigen::Index k = 0; k < sensors; ++k) {
      const double t = s.temperature[k];
      inputs(n, 1 + 2 * joints + k) = std::isfinite(t) ? t - kReferenceTemperature : 0.0;
    }
    outputs.row(n) = (needed.*which)(s).transpose();
  }
  // Columns of one size, so that the rank is judged fairly; what did not vary gets nothing.
  Eigen::VectorXd size(inputs.cols());
  for (Eigen::Index c = 1; c < inputs.cols(); ++c) {
    inputs.col(c).array() -= inputs.col(c).mean();
    size[c] = inputs.col(c).norm() / std::sqrt(kTableStates);
    if (size[c] > kStandsStill)
      inputs.col(c) /= size[c];
    else
      inputs.col(c).setZero();
  }
  size[0] = 1.0;
  Eigen::MatrixXd by = shortestLeastSquares(inputs, outputs, kStandsStill);
  // The columns are all but orthogonal, so that this is the standard error of each.
  const Eigen::RowVectorXd error = (outputs - inputs * by).colwise().norm() / kTableStates;
  for (Eigen::Index c = 1; c < by.rows(); ++c)
    for (Eigen::Index j = 0; j < joints; ++j)
      if (which != &NeededCorrection::activeAt && std::abs(by(c, j)) < kStandsOut * error[j]) by(c, j) = 0.0;
  for (Eigen::Index c = 1; c < by.rows(); ++c)
    by.row(c) =
        size[c] > kStandsStill ? Eigen::RowVectorXd(by.row(c) / size[c]) : Eigen::RowVectorXd::Zero(joints);
  return {by.middleRows(1, joints).transpose(), by.middleRows(1 + joints, joints).transpose(),
          by.bottomRows(sensors).transpose()};
}

}  // namespace mm
