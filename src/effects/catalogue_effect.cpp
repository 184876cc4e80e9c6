#include "effects/catalogue_effect.h"

namespace mm {

std::vector<std::string> jointNames(const Domain& domain, JointKind kind) {
  std::vector<std::string> names;
  for (const Joint& joint : domain.joints)
    if (joint.kind == kind) names.push_back(joint.name);
  return names;
}

std::vector<std::string> jointNames(const Domain& domain) {
  std::vector<std::string> names;
  for (const Joint& joint : domain.joints) names.push_back(joint.name);
  return names;
}

std::vector<std::pair<std::string, std::string>> coupledJoints(const Domain& domain) {
  std::vector<std::string> names = jointNames(domain, JointKind::kLinear);
  if (names.empty()) names = jointNames(domain);
  std::vector<std::pair<std::string, std::string>> pairs;
  for (const std::string& a : names)
    for (const std::string& b : names)
      if (a != b) pairs.emplace_back(a, b);
  return pairs;
}

std::vector<std::string> directionNames(const Domain& domain) {
  std::vector<std::string> names = jointNames(domain);
  if (jointNames(domain, JointKind::kLinear).size() < 3)
    for (const char* axis : {"x", "y", "z"})
      if (domain.findJoint(axis) < 0) names.emplace_back(axis);
  return names;
}

std::vector<ShapeFreedom> otherValues(const EffectSpec& spec, const std::string& key, int value, int lowest,
                                      int highest, int absent) {
  std::vector<ShapeFreedom> others;
  for (int other = lowest; other <= highest; ++other) {
    if (other == value) continue;
    EffectSpec shape(spec.type);
    for (const auto& kept : spec.keys)
      if (kept.first != key) shape.keys.push_back(kept);
    if (other != absent) shape.set(key, other);
    others.push_back({shape});
  }
  return others;
}

std::vector<std::string> ballNames(const Domain& domain) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < domain.features.size(); ++i)
    if (i >= domain.featureRadius.size() || domain.featureRadius[i] > 0.0)
      names.push_back(domain.features[i]);
  return names;
}

double observedRange(const Domain& domain, int joint) {
  const auto j = static_cast<std::size_t>(joint);
  if (j >= domain.lower.size() || j >= domain.upper.size()) return 0.0;
  const double range = domain.upper[j] - domain.lower[j];
  return range > kStoodStill ? range : 0.0;
}

ScaledPosition::ScaledPosition(const Domain& domain, int joint) : joint_(joint) {
  const double range = observedRange(domain, joint);
  if (range <= 0.0) return;
  centre_ = 0.5 * (domain.lower[joint] + domain.upper[joint]);
  inverse_ = 2.0 / range;
}

}  // namespace mm
