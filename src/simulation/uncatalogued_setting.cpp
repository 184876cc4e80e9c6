#include "simulation/uncatalogued_setting.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "base/error.h"

namespace mm {
namespace {

constexpr double kBreakaway = 20e-6;  // m/s at which dry friction has found its direction

}  // namespace

Eigen::Vector3d tipMotion(const std::vector<Eigen::Vector3d>& axes, const Condition& condition) {
  Eigen::Vector3d motion = Eigen::Vector3d::Zero();
  for (std::size_t j = 0; j < axes.size(); ++j)
    if (std::isfinite(condition.velocity[j])) motion += axes[j] * condition.velocity[j];
  return motion;
}

std::vector<Eigen::Vector3d> linearAxes(const Workshop& workshop) {
  std::vector<Eigen::Vector3d> axes;
  for (int j = 0; j < workshop.machine.jointCount(); ++j)
    axes.push_back(workshop.chain.kind(j) == JointKind::kLinear ? workshop.chain.axis(j)
                                                                : Eigen::Vector3d::Zero());
  return axes;
}

Spread spreadOf(const Quantity& quantity, const std::vector<Condition>& visits) {
  Spread spread;
  const double share = 1.0 / static_cast<double>(std::max<std::size_t>(1, visits.size()));
  for (const Condition& visit : visits) spread.mean += share * quantity(visit);
  for (const Condition& visit : visits)
    spread.deviation += share * std::pow(quantity(visit) - spread.mean, 2);
  spread.deviation = std::sqrt(spread.deviation);
  return spread;
}

Setting::Setting(const HiddenSource& source, const Workshop& workshop)
    : source_(source), workshop_(workshop), visits_(workshop.visits()) {
  if (visits_.empty())
    throw InputError("'" + source.type + "' cannot be hidden in a plan that measures nothing");
  duration_ = visits_.back().time;
}

int Setting::joint(const std::string& key) const {
  const int j = workshop_.machine.findJoint(source_.key(key));
  if (j < 0) throw InputError("'" + source_.type + "': no joint is called '" + source_.key(key) + "'");
  return j;
}

Quantity Setting::position(const std::string& key) const {
  const int j = joint(key);
  const double middle = 0.5 * (workshop_.lower[j] + workshop_.upper[j]);
  return [j, middle](const Condition& c) { return c.drive[j] - middle; };
}

Quantity Setting::place(const std::string& key) const {
  const int j = joint(key);
  constexpr double kNotMoved = 1e-9;  // m or rad
  const double half = std::max(kNotMoved, 0.5 * (workshop_.upper[j] - workshop_.lower[j]));
  return [half, q = position(key)](const Condition& c) { return q(c) / half; };
}

Quantity Setting::velocity(const std::string& key) const {
  const int j = joint(key);
  return [j](const Condition& c) { return std::isfinite(c.velocity[j]) ? c.velocity[j] : 0.0; };
}

Quantity Setting::side(const std::string& key) const {
  return [v = velocity(key)](const Condition& c) { return std::tanh(v(c) / kBreakaway); };
}

Quantity Setting::tipSpeed() const {
  return [axes = linearAxes(workshop_)](const Condition& c) { return tipMotion(axes, c).norm(); };
}

Quantity Setting::slant() const {
  return [axes = linearAxes(workshop_)](const Condition& c) {
    const Eigen::Vector3d motion = tipMotion(axes, c);
    const double speed = motion.norm();
    return speed > 0.0 ? std::hypot(motion.x(), motion.y()) / speed : 0.0;
  };
}

Quantity Setting::qualified(const Quantity& error) const {
  const std::vector<Eigen::Vector3d> axes = linearAxes(workshop_);
  const auto terms = [axes](const Condition& c) -> Eigen::RowVector4d {
    constexpr double kNoMotion = 1e-12;  // m: a joint that does not move the tip
    const Eigen::Vector3d motion = tipMotion(axes, c), way = motion / std::max(kNoMotion, motion.norm());
    return {1.0, way.x(), way.y(), way.z()};
  };
  Eigen::MatrixX4d columns(visits_.size(), 4);
  Eigen::VectorXd values(visits_.size());
  for (std::size_t i = 0; i < visits_.size(); ++i) {
    columns.row(i) = terms(visits_[i]);
    values(i) = error(visits_[i]);
  }
  const Eigen::Vector4d fitted = columns.colPivHouseholderQr().solve(values);
  return [error, terms, fitted](const Condition& c) { return error(c) - terms(c).dot(fitted); };
}

Quantity Setting::warmth(const std::string& key) const {
  const int body = workshop_.thermal.findBody(source_.key(key));
  if (body < 0) throw InputError("'" + source_.type + "': no body is called '" + source_.key(key) + "'");
  const Quantity temperature = [body](const Condition& c) { return c.bodies[body]; };
  return [temperature, mean = spreadOf(temperature, visits_).mean](const Condition& c) {
    return temperature(c) - mean;
  };
}

Quantity Setting::moisture(const std::string& key) const {
  for (std::size_t i = 0; i < workshop_.settings.covariates.size(); ++i) {
    if (workshop_.settings.covariates[i].name != source_.key(key)) continue;
    const Quantity value = [i](const Condition& c) { return c.covariates[i]; };
    const Spread spread = spreadOf(value, visits_);
    const double unit = spread.deviation > 0.0 ? spread.deviation : 1.0;
    return [value, unit, spread](const Condition& c) { return (value(c) - spread.mean) / unit; };
  }
  throw InputError("'" + source_.type + "': no covariate is called '" + source_.key(key) + "'");
}

}  // namespace mm
