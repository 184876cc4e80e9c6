#include "simulation/setting.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <memory>

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

Setting::Setting(const HiddenSource& hidden, const Workshop& w, const std::vector<Condition>& visits)
    : source(hidden), lower(w.lower), upper(w.upper) {
  const std::vector<TrueCovariate>& logged = w.settings.covariates;
  for (const auto& [key, value] : source.keys) {
    const auto covariate = std::find_if(logged.begin(), logged.end(),
                                        [&v = value](const TrueCovariate& c) { return c.name == v; });
    named.push_back({key, w.machine.findJoint(value), w.thermal.findBody(value),
                     covariate == logged.end() ? -1 : static_cast<int>(covariate - logged.begin()),
                     value.empty() ? -1 : value[0] - 'x'});
  }
  for (int j = 0; j < w.machine.jointCount(); ++j) {
    axes.push_back(w.chain.axis(j));
    linearAxes.push_back(w.chain.kind(j) == JointKind::kLinear ? axes.back() : Eigen::Vector3d::Zero());
  }
  for (const TrueCovariate& covariate : logged) covariateMeans.push_back(covariate.mean);
  if (visits.empty()) return;
  duration = visits.back().time;
  for (std::size_t b = 0; b < visits.front().bodies.size(); ++b)
    bodies.push_back(spreadOf([b](const Condition& c) { return c.bodies[b]; }, visits));
  for (std::size_t i = 0; i < logged.size(); ++i)
    covariates.push_back(spreadOf([i](const Condition& c) { return c.covariates[i]; }, visits));
}

const Setting::Named& Setting::at(const std::string& key) const {
  return *std::find_if(named.begin(), named.end(), [&](const Named& n) { return n.key == key; });
}

double Instant::position(const std::string& key) const {
  const int j = joint(key);
  return now.drive[j] - 0.5 * (setting.lower[j] + setting.upper[j]);
}

double Instant::place(const std::string& key) const {
  constexpr double kNotMoved = 1e-9;  // m or rad
  const int j = joint(key);
  return position(key) / std::max(kNotMoved, 0.5 * (setting.upper[j] - setting.lower[j]));
}

double Instant::velocity(const std::string& key) const {
  const double v = now.velocity[joint(key)];
  return std::isfinite(v) ? v : 0.0;
}

double Instant::side(const std::string& key) const { return std::tanh(velocity(key) / kBreakaway); }

Eigen::Vector3d Instant::tipMotion() const { return motionAlong(setting.linearAxes, now); }

double Instant::slant() const {
  const Eigen::Vector3d motion = tipMotion();
  const double speed = motion.norm();
  return speed > 0.0 ? std::hypot(motion.x(), motion.y()) / speed : 0.0;
}

double Instant::warmth(const std::string& key) const {
  return temperature(key) - setting.bodies[setting.at(key).body].mean;
}

double Instant::change(const std::string& key) const {
  const int covariate = setting.at(key).covariate;
  return now.covariates[covariate] - setting.covariateMeans[covariate];
}

double Instant::moisture(const std::string& key) const {
  const int covariate = setting.at(key).covariate;
  const Spread& spread = setting.covariates[covariate];
  return (now.covariates[covariate] - spread.mean) / (spread.deviation > 0.0 ? spread.deviation : 1.0);
}

Eigen::Vector3d Instant::unitVector(const std::string& key) const {
  return Eigen::Vector3d::Unit(setting.at(key).component);
}

Direction Instant::direction() const {
  const Setting::Named& named = setting.at("direction");
  return {named.joint, named.component};
}

Tilt Instant::tilt() const {
  return {setting.source.key("lever") == "chain" ? joint() : -1, unitVector("about")};
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

void Making::add(SourceLaw law) const {
  workshop.physics.sources.push_back(
      [law = std::move(law), setting = std::make_shared<const Setting>(source, workshop)](const Condition& c,
                                                                                          Distortion& d) {
        law({*setting, c}, d);
      });
}

}  // namespace mm
