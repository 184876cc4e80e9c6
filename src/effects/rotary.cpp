#include "effects/rotary.h"

#include <set>

#include "effects/quantity.h"
#include "effects/tilt.h"

namespace mm {
namespace {

constexpr int kHighestHarmonic = 16;  // harmonic that may be asked for
constexpr int kUsual = 3;             // and that a diagnosis tries

}  // namespace

bool alongAxis(const Joint& joint, int k) {
  constexpr double kParallel = 1e-9;  // 1 - cosine: rounding of a URDF's axis, 0.05 mrad
  return std::abs(joint.axis[k]) > 1.0 - kParallel;
}

RadialDirections::RadialDirections(const SpecReader& read, int index) {
  const Joint& joint = read.domain().joints[index];
  if (joint.axis.isZero(0.0)) read.fail("the axis of joint '" + joint.name + "' is not known to the domain");
  for (int k = 0; k < 3; ++k) {
    if (!alongAxis(joint, k)) continue;
    for (int d = 0; d < 2; ++d) {
      const int axis = (k + 1 + d) % 3;
      directions[d] = Eigen::Vector3d::Unit(axis);
      names[d] = axisName(axis);
    }
    return;
  }
  directions[0] = joint.axis.unitOrthogonal();
  directions[1] = joint.axis.cross(directions[0]);
}

RotaryEffect::RotaryEffect(SpecReader& read, Stage stage)
    : CatalogueEffect(read, stage),
      joint_(read.joint("joint", JointKind::kRotary)),
      name_(read.domain().joints[joint_].name) {}

RotaryAxisError::RotaryAxisError(SpecReader& read, const std::string& key)
    : RotaryEffect(read, Stage::kJoint), axis_(read.axisOf(key, "axis of the joint's fixed side")) {}

std::string RotaryAxisError::shownBy() const {
  return "Postures that turn " + name_ +
         " over most of its range, and the other joints with it, at one ball.";
}

RotaryWave::RotaryWave(SpecReader& read, JointKind kind)
    : RotaryEffect(read, Stage::kJoint),
      radial_(read, joint_),
      harmonic_(read.integer("harmonic", 1, kHighestHarmonic)) {
  turn_ = harmonic_ == 1 ? "turn" : "1/" + std::to_string(harmonic_) + " turn";
  for (const std::string& direction : radial_.names)
    for (const char* phase : {"cos", "sin"})
      parameters_.push_back(errorParameter(direction + "_" + phase, kind));
}

std::vector<ShapeFreedom> RotaryWave::freedom(const Domain&) const {
  std::set<int> others{1, 2, 3, 2 * harmonic_};
  others.erase(harmonic_);
  std::vector<ShapeFreedom> freedom;
  for (const int h : others)
    if (h <= kHighestHarmonic) freedom.push_back({EffectSpec(spec()).set("harmonic", h)});
  return freedom;
}

std::vector<EffectSpec> acrossRotaryAxes(const std::string& type, const std::string& key,
                                         const Domain& domain) {
  std::vector<EffectSpec> specs;
  for (const Joint& joint : domain.joints)
    for (int k = 0; k < 3; ++k)
      if (joint.kind == JointKind::kRotary && !alongAxis(joint, k))
        specs.push_back(EffectSpec(type).set("joint", joint.name).set(key, axisName(k)));
  return specs;
}

std::vector<EffectSpec> rotaryHarmonics(const std::string& type, const Domain& domain) {
  std::vector<EffectSpec> specs;
  for (const std::string& joint : jointNames(domain, JointKind::kRotary))
    for (int harmonic = 1; harmonic <= kUsual; ++harmonic)
      specs.push_back(EffectSpec(type).set("joint", joint).set("harmonic", harmonic));
  return specs;
}

}  // namespace mm
