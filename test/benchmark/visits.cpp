#include "visits.h"

#include <algorithm>
#include <cmath>

#include "base/dense.h"

namespace mm {
namespace {

constexpr double kBreakaway = 20e-6;  // m/s at which dry friction has found its direction

/// Motion of the tip (m/s, workpiece) by the joints whose axes are given; zero at standstill.
Eigen::Vector3d motionAlong(const std::vector<Eigen::Vector3d>& axes, const Condition& condition) {
  Eigen::Vector3d motion = Eigen::Vector3d::Zero();
  for (std::size_t j = 0; j < axes.size(); ++j)
    if (std::isfinite(condition.velocity[j])) motion += axes[j] * condition.velocity[j];
  return motion;
}

}  // namespace

Spread spreadOf(const Quantity& quantity, const std::vector<Condition>& visits) {
  Spread spread;
  const double share = 1.0 / static_cast<double>(std::max<std::size_t>(1, visits.size()));
  for (const Condition& visit : visits) spread.mean += share * quantity(visit);
  for (const Condition& visit : visits)
    spread.deviation += share * std::pow(quantity(visit) - spread.mean, 2);
  spread.deviation = std::sqrt(spread.deviation);
  return spread;
}

VisitedSetting::VisitedSetting(const HiddenSource& hidden, const Workshop& w,
                               const std::vector<Condition>& visits)
    : Setting(hidden, w) {
  for (int j = 0; j < w.machine.jointCount(); ++j)
    linearAxes.push_back(w.chain.kind(j) == JointKind::kLinear ? axes[j] : Eigen::Vector3d::Zero());
  duration = visits.back().time;
  for (std::size_t b = 0; b < visits.front().bodies.size(); ++b)
    bodies.push_back(spreadOf([b](const Condition& c) { return c.bodies[b]; }, visits));
  for (std::size_t i = 0; i < covariateMeans.size(); ++i)
    covariates.push_back(spreadOf([i](const Condition& c) { return c.covariates[i]; }, visits));
}

double VisitedInstant::place(const std::string& key) const {
  constexpr double kNotMoved = 1e-9;  // m or rad
  const int j = joint(key);
  return position(key) / std::max(kNotMoved, 0.5 * (setting.upper[j] - setting.lower[j]));
}

double VisitedInstant::velocity(const std::string& key) const {
  const double v = now.velocity[joint(key)];
  return std::isfinite(v) ? v : 0.0;
}

double VisitedInstant::side(const std::string& key) const { return std::tanh(velocity(key) / kBreakaway); }

Eigen::Vector3d VisitedInstant::tipMotion() const { return motionAlong(session.linearAxes, now); }

double VisitedInstant::slant() const {
  const Eigen::Vector3d motion = tipMotion();
  const double speed = motion.norm();
  return speed > 0.0 ? std::hypot(motion.x(), motion.y()) / speed : 0.0;
}

double VisitedInstant::warmth(const std::string& key) const {
  return temperature(key) - session.bodies[setting.at(key).body].mean;
}

double VisitedInstant::moisture(const std::string& key) const {
  const int covariate = setting.at(key).covariate;
  const Spread& spread = session.covariates[covariate];
  return (now.covariates[covariate] - spread.mean) / (spread.deviation > 0.0 ? spread.deviation : 1.0);
}

Quantity qualified(const Quantity& error, const std::vector<Eigen::Vector3d>& linearAxes,
                   const std::vector<Condition>& visits) {
  const auto terms = [linearAxes](const Condition& c) -> Eigen::RowVector4d {
    constexpr double kNoMotion = 1e-12;  // m: a joint that does not move the tip
    const Eigen::Vector3d motion = motionAlong(linearAxes, c),
                          way = motion / std::max(kNoMotion, motion.norm());
    return {1.0, way.x(), way.y(), way.z()};
  };
  Eigen::MatrixXd columns(visits.size(), 4);
  Eigen::VectorXd values(visits.size());
  for (std::size_t i = 0; i < visits.size(); ++i) {
    columns.row(i) = terms(visits[i]);
    values(i) = error(visits[i]);
  }
  const Eigen::Vector4d fitted = leastSquares(columns, values);
  return [error, terms, fitted](const Condition& c) { return error(c) - terms(c).dot(fitted); };
}

}  // namespace mm
