#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "base/dense.h"
#include "base/error.h"
#include "base/random.h"
#include "base/rotation.h"
#include "model/model.h"
#include "verification/calibration_changes.h"
#include "workflow/recalibration.h"

namespace mm {
namespace {

constexpr double kSameEffect = 1e-3;   // of an effect's size: by which two forms of it may differ
constexpr double kAtTheOrigin = 1e-6;  // m: all places in one point turn about nothing

double middle(double a, double b) { return 0.5 * (a + b); }

/// A state within the ranges of `a`, for a domain with the inputs of `named`: by name, the middle.
State stateFor(const Domain& named, const Domain& a) {
  State state;
  for (std::size_t j = 0; j < named.joints.size(); ++j) {
    state.position.push_back(middle(a.lower[j], a.upper[j]));
    state.velocity.push_back(0.0);
    state.travel.push_back(1.0);
  }
  for (const std::string& sensor : named.sensors) {
    const int at = a.findSensor(sensor);
    state.temperature.push_back(at >= 0 ? middle(a.sensorLower[at], a.sensorUpper[at]) : 20.0);
  }
  for (const std::string& covariate : named.covariates) {
    const int at = a.findCovariate(covariate);
    state.covariate.push_back(at >= 0 ? middle(a.covariateLower[at], a.covariateUpper[at]) : 0.0);
  }
  if (named.laser) state.laserReading = middle(named.readingLower, named.readingUpper);
  return state;
}

/// Range that both hold for. @return false: there is none.
bool commonRange(const Domain& a, const Domain& b, std::vector<double>& lower, std::vector<double>& upper) {
  for (std::size_t j = 0; j < a.joints.size(); ++j) {
    lower.push_back(std::max(a.lower[j], b.lower[j]));
    upper.push_back(std::min(a.upper[j], b.upper[j]));
    if (lower.back() > upper.back()) return false;
  }
  return true;
}

}  // namespace

bool meansTheSame(const EffectSpec& effect, const Calibration& a, const Calibration& b) {
  std::vector<double> lower, upper;
  if (!commonRange(a.domain, b.domain, lower, upper)) return false;
  const auto one = [&](const Calibration& c) {
    return Model(Machine(c.urdf, c.machineName), c.domain, std::vector<EffectSpec>{effect}, c.networks);
  };
  try {
    const Model first = one(a), second = one(b);
    if (first.parameterCount() != second.parameterCount()) return false;
    Eigen::VectorXd p(first.parameterCount());
    for (int i = 0; i < first.parameterCount(); ++i)
      p[i] = first.parameter(i).start != 0.0 ? first.parameter(i).start : first.parameter(i).scale;
    Random random(1, "parameter meaning");
    Model::Workspace work;
    double difference = 0.0, size = 0.0;
    for (int trial = 0; trial < 20; ++trial) {
      State here = stateFor(a.domain, a.domain), there = stateFor(b.domain, a.domain);
      for (std::size_t j = 0; j < lower.size(); ++j) {
        here.position[j] = there.position[j] = random.uniform(lower[j], upper[j]);
        here.travel[j] = there.travel[j] = random.sign();
      }
      first.place(here);
      second.place(there);
      first.corrected(here, p.data(), work);
      const std::vector<double> errors = work.errors;
      second.corrected(there, p.data(), work);
      for (std::size_t k = 0; k < errors.size(); ++k) {
        if (!std::isfinite(errors[k]) || !std::isfinite(work.errors[k]))
          continue;  // of an input not known here
        difference = std::max(difference, std::abs(errors[k] - work.errors[k]));
        size = std::max(size, std::abs(errors[k]));
      }
    }
    return difference <= kSameEffect * size;
  } catch (const InputError&) {
    return false;  // one of them lacks an input of it
  }
}

TipChange tipChange(const Calibration& a, const Calibration& b) {
  TipChange change;
  std::vector<double> lower, upper;
  if (!commonRange(a.domain, b.domain, lower, upper)) return change;
  constexpr int kPoints = 4;  // along each joint
  const Model first = modelOf(a), second = modelOf(b);
  const Eigen::VectorXd pa = valuesOf(a), pb = valuesOf(b);
  const std::size_t joints = lower.size();
  std::size_t nodes = 2;  // directions of travel
  for (std::size_t j = 0; j < joints; ++j) nodes *= upper[j] > lower[j] ? kPoints : 1;
  Eigen::VectorXd difference(3 * nodes), variance(difference.size());
  Eigen::MatrixXd rigid(difference.size(), 6);
  Model::Workspace work;
  Eigen::Matrix<double, 6, Eigen::Dynamic> byParameter;
  for (std::size_t node = 0; node < nodes; ++node) {
    std::size_t rest = node / 2;
    State here = stateFor(a.domain, a.domain), there = stateFor(b.domain, a.domain);
    for (std::size_t j = 0; j < joints; ++j) {
      here.travel[j] = there.travel[j] = node % 2 == 0 ? -1.0 : 1.0;
      if (!(upper[j] > lower[j])) continue;
      const double share = static_cast<double>(rest % kPoints) / (kPoints - 1);
      here.position[j] = there.position[j] = lower[j] + share * (upper[j] - lower[j]);
      rest /= kPoints;
    }
    first.place(here);
    second.place(there);
    const Eigen::Index row = 3 * node;
    const auto varianceOf = [&](const Eigen::MatrixXd& covariance) {
      const Eigen::Matrix<double, 3, Eigen::Dynamic> top = byParameter.topRows<3>();
      return Eigen::Vector3d((top * covariance).cwiseProduct(top).rowwise().sum());
    };
    const Eigen::Vector3d before = first.corrected(here, pa.data(), work, &byParameter).position;
    variance.segment<3>(row) = varianceOf(a.covariance);
    const Eigen::Vector3d after = second.corrected(there, pb.data(), work, &byParameter).position;
    variance.segment<3>(row) += varianceOf(b.covariance);
    difference.segment<3>(row) = after - before;
    const Eigen::Vector3d at = here.tip;
    rigid.block<3, 3>(row, 0).setIdentity();
    rigid.block<3, 3>(row, 3) = skew(at).transpose();
  }
  if (!difference.allFinite()) {  // an input that neither range tells (a lag, a contact): left out
    for (Eigen::Index i = 0; i < difference.size(); ++i)
      if (!std::isfinite(difference[i])) difference[i] = 0.0, rigid.row(i).setZero(), variance[i] = 0.0;
  }
  // Where the workpiece lies is no error of the machine.
  rigid.rightCols<3>() /= std::max(kAtTheOrigin, rigid.rightCols<3>().cwiseAbs().maxCoeff());
  difference -= rigid * shortestLeastSquares(rigid, difference);
  change.rms = std::sqrt(difference.squaredNorm() / nodes);
  change.byChance = std::sqrt(variance.cwiseMax(0.0).sum() / nodes);
  for (std::size_t node = 0; node < nodes; ++node)
    change.largest = std::max(change.largest, difference.segment<3>(3 * node).norm());
  return change;
}

}  // namespace mm
