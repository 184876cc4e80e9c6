#include "design/posture_proposals.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "base/dense.h"
#include "base/range.h"
#include "base/units.h"
#include "estimation/identifiability.h"
#include "estimation/whitened.h"
#include "machine/linear_inverse.h"

namespace mm {
namespace {

constexpr int kAngles = 7;              // of each rotary joint
constexpr double kTilt = 35 * kDegree;  // of the contacts about the probe's direction
constexpr double kLeastRange = 2e-3;    // m: half the range of readings to propose where one was used only
constexpr std::size_t kMost = 8;        // postures
constexpr double kWorthwhile = 0.9;     // a posture that leaves more of the sum of variances is not proposed
constexpr double kTwice = 0.5;

/// Observations of one posture: rows first … first + count - 1 of the hypothetical session.
struct Candidate {
  ProposedPosture posture;
  std::vector<Observation> contacts;
};

/// Every combination of angles of the rotary joints, at rest of the others.
std::vector<std::vector<double>> anglesOf(const Machine& machine, const std::vector<double>& rest) {
  std::vector<std::vector<double>> all{rest};
  for (int j = 0; j < machine.jointCount(); ++j) {
    const Joint& joint = machine.joints()[j];
    if (joint.kind != JointKind::kRotary) continue;
    const bool limited = joint.upper > joint.lower && joint.upper - joint.lower < 2.0 * kPi;
    const double low = limited ? joint.lower : -kPi, high = limited ? joint.upper : kPi;
    std::vector<std::vector<double>> next;
    for (const auto& q : all)
      for (int i = 0; i < kAngles; ++i) {
        next.push_back(q);
        next.back()[j] = low + (high - low) * i / (kAngles - 1);
      }
    all = std::move(next);
    if (all.size() > 2500) break;
  }
  return all;
}

std::vector<Candidate> candidatesOf(const Problem& problem, const Eigen::VectorXd& x) {
  const Session& session = problem.session();
  const Machine& machine = session.machine;
  Range range;
  for (const Observation& o : session.observations) range.add(o.laserReading);
  std::vector<double> readings{kNotMeasured};
  if (range.any()) {
    const double middle = 0.5 * (range.lower + range.upper), half = std::max(0.5 * range.size(), kLeastRange);
    readings = {middle - half, middle + half};
  }
  std::vector<Candidate> all;
  std::vector<char> done(session.artifact.features.size(), 0);
  for (const Observation& o : session.observations) {
    if (o.kind != ObservationKind::kContact || done[o.feature]++ != 0) continue;
    const Feature& feature = session.artifact.features[o.feature];
    const Eigen::Vector3d centre = problem.featureInWorkpiece(o.feature, o.placement, x);
    for (const auto& angles : anglesOf(machine, o.position))
      for (const double reading : readings) {
        const Eigen::Matrix3d probe = machine.nominal(angles.data(), reading).orientation;
        const double distance = feature.kind != FeatureKind::kBall ? 0.0
                                : std::isfinite(reading)
                                    ? feature.radius
                                    : feature.radius + session.artifact.tipRadiusOf(o.stylus);
        Candidate c;
        bool feasible = true;
        for (int i = 0; i < (distance > 0.0 ? 5 : 1) && feasible; ++i) {
          const Eigen::Vector3d side = i == 0 ? Eigen::Vector3d::Zero()
                                       : i < 3
                                           ? Eigen::Vector3d((i == 1 ? 1.0 : -1.0) * std::tan(kTilt), 0, 0)
                                           : Eigen::Vector3d(0, (i == 3 ? 1.0 : -1.0) * std::tan(kTilt), 0);
          const Eigen::Vector3d towards = (probe * (Eigen::Vector3d::UnitZ() + side)).normalized();
          Observation at = o;
          at.position = angles;
          at.laserReading = reading;
          at.approach = std::isfinite(reading) ? Eigen::Vector3d(probe.col(2)) : towards;
          feasible = placeTip(machine, centre - distance * towards, reading, at.position) &&
                     withinLimits(machine.joints(), at.position);
          if (i == 0) c.posture = {feature.name, at.position, reading};
          c.contacts.push_back(std::move(at));
        }
        if (feasible) all.push_back(std::move(c));
      }
  }
  return all;
}

}  // namespace

PostureAdvice proposePostures(const Problem& problem, const Eigen::VectorXd& x,
                              const Eigen::VectorXd& inverseSigma) {
  PostureAdvice advice;
  const Machine& machine = problem.session().machine;
  int linear = 0, rotary = 0;
  for (const Joint& j : machine.joints()) ++(j.kind == JointKind::kLinear ? linear : rotary);
  if (rotary == 0 || linear < 3 || problem.model().parameterCount() == 0) return advice;
  const std::vector<Candidate> candidates = candidatesOf(problem, x);
  if (candidates.empty()) return advice;

  Session next(machine);
  next.artifact = problem.session().artifact;
  next.temperatures = problem.session().temperatures;
  next.covariates = problem.session().covariates;
  next.source = problem.session().source;
  for (const Candidate& c : candidates)
    next.observations.insert(next.observations.end(), c.contacts.begin(), c.contacts.end());
  const Problem future(next, problem.model(), problem.datum());
  if (future.unknownCount() != problem.unknownCount()) return advice;

  const int count = problem.unknownCount();
  const std::vector<char> none(static_cast<std::size_t>(count), 0);
  const WhitenedSystem now(problem, x, inverseSigma, none);
  const Eigen::MatrixXd later =
      linearise(future, x).jacobian() * now.scale.asDiagonal() * inverseSigma.maxCoeff();
  // what is not determined is at least within its bound
  Eigen::MatrixXd information = now.jacobian.transpose() * now.jacobian;
  for (int u = 0; u < count; ++u) {
    const Unknown& unknown = problem.unknowns()[u];
    information(u, u) += std::pow(unknown.scale / unknown.bound, 2);
  }
  Eigen::MatrixXd covariance = inverseOfSymmetric(information);
  std::vector<int> wanted;
  for (int u = 0; u < count; ++u)
    if (problem.unknowns()[u].kind == UnknownKind::kEffect) wanted.push_back(u);
  const auto sumOf = [&](const Eigen::MatrixXd& c) {
    double sum = 0.0;
    for (const int u : wanted) sum += c(u, u);
    return sum;
  };
  const Eigen::MatrixXd before = covariance;
  while (advice.postures.size() < kMost) {
    double least = sumOf(covariance) * kWorthwhile;
    int best = -1;
    Eigen::MatrixXd after;
    int observation = 0;
    for (std::size_t c = 0; c < candidates.size(); ++c) {
      const int first = future.firstRow(observation);
      observation += static_cast<int>(candidates[c].contacts.size());
      const Eigen::MatrixXd rows = later.middleRows(first, future.firstRow(observation) - first);
      if (!rows.allFinite()) continue;
      const Eigen::MatrixXd moved = covariance * rows.transpose();
      const Eigen::MatrixXd gain = solveSymmetric(
          Eigen::MatrixXd::Identity(rows.rows(), rows.rows()) + rows * moved, moved.transpose());
      double sum = 0.0;
      for (const int u : wanted) sum += covariance(u, u) - moved.row(u).dot(gain.col(u));
      if (!(sum < least)) continue;
      least = sum;
      best = static_cast<int>(c);
      after = covariance - moved * gain;
    }
    if (best < 0) break;
    covariance = after;
    advice.postures.push_back(candidates[static_cast<std::size_t>(best)].posture);
  }
  for (const int u : wanted) {
    const Unknown& unknown = problem.unknowns()[u];
    const double was = std::sqrt(std::max(0.0, before(u, u))),
                 is = std::sqrt(std::max(0.0, covariance(u, u)));
    if (is < kTwice * was)
      advice.gains.push_back({displayName(problem, u), unknown.unit, was * unknown.scale * unknown.toUnit,
                              is * unknown.scale * unknown.toUnit});
  }
  return advice;
}

}  // namespace mm
