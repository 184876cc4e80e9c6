#include "export/fitted_tables.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "base/units.h"

namespace mm {
namespace {

constexpr int kTableOthers = 32;    // states of everything else, over which a table is the mean
constexpr int kTableStates = 600;   // of the straight part
constexpr double kFollowed = 2e-8;  // m
constexpr double kStepUnit = 1e-7;  // m
constexpr unsigned kTableSeed = 11, kPlaneSeed = 12, kStraightSeed = 13;

/// Where `position` lies among ascending points: the one before it, and the share of the way to the next.
std::pair<std::size_t, double> placeAmong(const std::vector<double>& at, double position) {
  if (at.size() < 2 || position <= at.front()) return {0, 0.0};
  if (position >= at.back()) return {at.size() - 2, 1.0};
  const auto i = static_cast<std::size_t>(std::upper_bound(at.begin(), at.end(), position) - at.begin()) - 1;
  return {i, (position - at[i]) / (at[i + 1] - at[i])};
}

double between(const std::vector<double>& at, const std::vector<double>& values, double position) {
  if (values.size() == 1) return values[0];
  const auto [i, share] = placeAmong(at, position);
  return values[i] + share * (values[i + 1] - values[i]);
}

/// The mean of the correction over the other states, at one position and direction of an axis.
Eigen::VectorXd meanAt(const NeededCorrection& needed, std::vector<State>& others, int input, double position,
                       double travel) {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(needed.axes().size()));
  for (State& state : others) {
    state.position[static_cast<std::size_t>(input)] = position;
    state.travel[static_cast<std::size_t>(input)] = travel;
    sum += needed.at(state);
  }
  return sum / static_cast<double>(others.size());
}

/// Largest distance of the points of odd number from the straight line between their neighbours.
double bend(const std::vector<Eigen::VectorXd>& values) {
  double largest = 0.0;
  for (std::size_t i = 1; i + 1 < values.size(); i += 2)
    largest = std::max(largest, (values[i] - 0.5 * (values[i - 1] + values[i + 1])).cwiseAbs().maxCoeff());
  return largest;
}

void subtractReference(LineTable& table, double reference) {
  for (std::size_t j = 0; j < table.positive.size(); ++j) {
    const double zero = table.value(static_cast<int>(j), reference, 0.0);
    for (std::size_t i = 0; i < table.at.size(); ++i) {
      table.positive[j][i] -= zero;
      table.negative[j][i] -= zero;
    }
  }
}

/// Each state twice, the second time with everything but the positions mirrored: a curve over positions then
/// never passes for a reversal or for growth by heat.
std::vector<State> mirrored(const NeededCorrection& needed, int count) {
  const Domain& d = needed.model().domain();
  std::vector<State> states = needed.states(count, kStraightSeed);
  for (int n = 0; n < count; ++n) {
    State other = states[static_cast<std::size_t>(n)];
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
  const double start = std::floor(from / kStepUnit + 1e-6);
  const double step = std::max(1.0, std::ceil((to / kStepUnit - start) / intervals - 1e-6));
  std::vector<double> at;
  for (int i = 0; i <= intervals; ++i) at.push_back((start + i * step) * kStepUnit);
  return at;
}

double LineTable::value(int output, double position, double travel) const {
  const auto j = static_cast<std::size_t>(output);
  const double up = between(at, positive[j], position), down = between(at, negative[j], position);
  return travel > 0.0 ? up : travel < 0.0 ? down : 0.5 * (up + down);
}

double LineTable::largest(int output) const {
  double most = 0.0;
  const auto j = static_cast<std::size_t>(output);
  for (std::size_t i = 0; i < at.size(); ++i)
    most = std::max({most, std::abs(positive[j][i]), std::abs(negative[j][i])});
  return most;
}

LineTable lineTable(const NeededCorrection& needed, int input, int mostPoints) {
  const ExportAxis& axis = needed.axes()[static_cast<std::size_t>(input)];
  std::vector<State> others = needed.states(kTableOthers, kTableSeed);
  int intervals = std::max(1, (mostPoints - 1) / 16);
  const int most = intervals * 16;
  const std::vector<double> finest = evenSteps(axis.lower, axis.upper, most);
  std::vector<Eigen::VectorXd> up, down;
  int stride = 16;
  const auto sample = [&](std::size_t i, double travel) {
    return meanAt(needed, others, input, finest[i], travel);
  };
  for (std::size_t i = 0; i < finest.size(); i += 16) {
    up.push_back(sample(i, 1.0));
    down.push_back(sample(i, -1.0));
  }
  while (stride > 1) {
    const int half = stride / 2;
    std::vector<Eigen::VectorXd> finerUp, finerDown;
    for (std::size_t i = 0; i < finest.size(); i += static_cast<std::size_t>(half)) {
      const std::size_t k = i / static_cast<std::size_t>(stride);
      const bool known = i % static_cast<std::size_t>(stride) == 0;
      finerUp.push_back(known ? up[k] : sample(i, 1.0));
      finerDown.push_back(known ? down[k] : sample(i, -1.0));
    }
    // Eight intervals or more have been seen before a curve is believed to be followed.
    const bool followed = up.size() > 8 && std::max(bend(finerUp), bend(finerDown)) < kFollowed;
    if (followed) break;
    up = std::move(finerUp);
    down = std::move(finerDown);
    stride = half;
  }
  LineTable table;
  table.input = input;
  for (std::size_t i = 0; i < finest.size(); i += static_cast<std::size_t>(stride))
    table.at.push_back(finest[i]);
  const std::size_t joints = needed.axes().size();
  table.positive.resize(joints);
  table.negative.resize(joints);
  for (std::size_t j = 0; j < joints; ++j)
    for (std::size_t i = 0; i < table.at.size(); ++i) {
      table.positive[j].push_back(up[i][static_cast<Eigen::Index>(j)]);
      table.negative[j].push_back(down[i][static_cast<Eigen::Index>(j)]);
    }
  subtractReference(table, needed.reference(input));
  return table;
}

double PlaneTable::interpolated(int output, double a, double b) const {
  const Eigen::MatrixXd& v = value[static_cast<std::size_t>(output)];
  const auto [i, s] = placeAmong(atFirst, a);
  const auto [k, t] = placeAmong(atSecond, b);
  const auto r = static_cast<Eigen::Index>(i), c = static_cast<Eigen::Index>(k);
  return (1 - s) * ((1 - t) * v(r, c) + t * v(r, c + 1)) + s * ((1 - t) * v(r + 1, c) + t * v(r + 1, c + 1));
}

PlaneTable planeTable(const NeededCorrection& needed, int first, int second, std::vector<double> atFirst,
                      std::vector<double> atSecond) {
  PlaneTable plane;
  plane.first = first;
  plane.second = second;
  plane.atFirst = std::move(atFirst);
  plane.atSecond = std::move(atSecond);
  const auto rows = static_cast<Eigen::Index>(plane.atFirst.size()),
             columns = static_cast<Eigen::Index>(plane.atSecond.size());
  const std::size_t joints = needed.axes().size();
  plane.value.assign(joints, Eigen::MatrixXd::Zero(rows, columns));
  std::vector<State> others = needed.states(kTableOthers, kPlaneSeed);
  for (Eigen::Index i = 0; i < rows; ++i)
    for (Eigen::Index k = 0; k < columns; ++k) {
      Eigen::VectorXd sum = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(joints));
      for (State& state : others) {
        state.position[static_cast<std::size_t>(first)] = plane.atFirst[static_cast<std::size_t>(i)];
        state.position[static_cast<std::size_t>(second)] = plane.atSecond[static_cast<std::size_t>(k)];
        sum += needed.at(state);
      }
      for (std::size_t j = 0; j < joints; ++j)
        plane.value[j](i, k) = sum[static_cast<Eigen::Index>(j)] / static_cast<double>(others.size());
    }
  for (std::size_t j = 0; j < joints; ++j)
    plane.value[j].array() -=
        plane.interpolated(static_cast<int>(j), needed.reference(first), needed.reference(second));
  return plane;
}

StraightPart straightPart(const NeededCorrection& needed) {
  const std::vector<State> states = mirrored(needed, kTableStates / 2);
  const auto joints = static_cast<Eigen::Index>(needed.axes().size());
  const auto sensors = static_cast<Eigen::Index>(needed.model().domain().sensors.size());
  Eigen::MatrixXd inputs(kTableStates, 1 + 2 * joints + sensors), outputs(kTableStates, joints);
  for (int n = 0; n < kTableStates; ++n) {
    const State& s = states[static_cast<std::size_t>(n)];
    inputs(n, 0) = 1.0;
    for (Eigen::Index j = 0; j < joints; ++j) {
      inputs(n, 1 + j) = s.position[static_cast<std::size_t>(j)];
      inputs(n, 1 + joints + j) = s.travel[static_cast<std::size_t>(j)];
    }
    for (Eigen::Index k = 0; k < sensors; ++k) {
      const double t = s.temperature[static_cast<std::size_t>(k)];
      inputs(n, 1 + 2 * joints + k) = std::isfinite(t) ? t - kReferenceTemperature : 0.0;
    }
    outputs.row(n) = needed.at(s).transpose();
  }
  // Columns of one size, so that the rank is judged fairly; what did not vary gets nothing.
  Eigen::VectorXd size(inputs.cols());
  for (Eigen::Index c = 1; c < inputs.cols(); ++c) {
    inputs.col(c).array() -= inputs.col(c).mean();
    size[c] = inputs.col(c).norm() / std::sqrt(static_cast<double>(kTableStates));
    if (size[c] > 1e-9)
      inputs.col(c) /= size[c];
    else
      inputs.col(c).setZero();
  }
  size[0] = 1.0;
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> solver;
  solver.setThreshold(1e-9);
  solver.compute(inputs);
  Eigen::MatrixXd by = solver.solve(outputs);
  for (Eigen::Index c = 1; c < by.rows(); ++c)
    by.row(c) = size[c] > 1e-9 ? Eigen::RowVectorXd(by.row(c) / size[c]) : Eigen::RowVectorXd::Zero(joints);
  StraightPart part;
  part.byPosition = by.middleRows(1, joints).transpose();
  part.byTravel = by.middleRows(1 + joints, joints).transpose();
  part.bySensor = by.bottomRows(sensors).transpose();
  return part;
}

}  // namespace mm
