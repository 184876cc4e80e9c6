// Errors of rotary joints, ISO 230-7.
#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <set>

#include "effects/law.h"
#include "effects/quantity.h"
#include "effects/tilt.h"

namespace mm {
namespace {

constexpr int kHighestHarmonic = 16;  // harmonic that may be asked for
constexpr int kUsual = 3;             // and that a diagnosis tries

/// True when the axis of rotation is axis k of the joint's fixed side: displaced along it or turned about it,
/// it stays.
bool alongAxis(const Joint& joint, int k) {
  constexpr double kParallel = 1e-9;  // 1 - cosine: rounding of a URDF's axis, 0.05 mrad
  return std::abs(joint.axis[k]) > 1.0 - kParallel;
}

/// Two unit vectors across the axis of rotation, in the axes of the joint's fixed side: two of these axes
/// themselves where the rotation is about the third (then named x, y or z), else any pair (named u, w).
struct RadialDirections {
  RadialDirections(const SpecReader& read, int index);  ///< @throw InputError: the axis is not known

  std::array<Eigen::Vector3d, 2> directions;
  std::array<std::string, 2> names{"u", "w"};
};

RadialDirections::RadialDirections(const SpecReader& read, int index) {
  const Joint& joint = read.jointAt(index);
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

Law rotaryZero(SpecReader& read) {
  Law law = oneTerm(Stage::kAxis, read.layout().axis(read.joint("joint", JointKind::kRotary)),
                    errorParameter("zero", JointKind::kRotary), [](const State&) { return 1.0; });
  law.nature.choosesFrame = {0};
  return law;
}

/// A constant error of place of the axis of rotation, along or about an axis of the joint's fixed side.
Law axisError(SpecReader& read, const std::string& key, bool rotation, const Parameter& parameter) {
  const int joint = read.joint("joint", JointKind::kRotary);
  const int axis = read.axisOf(key, "axis of the joint's fixed side");
  const ErrorLayout layout = read.layout();
  Law law = oneTerm(Stage::kJoint,
                    rotation ? layout.jointRotation(joint, axis) : layout.jointTranslation(joint, axis),
                    parameter, [](const State&) { return 1.0; });
  law.nature.mustMove = {joint};
  return law;
}
Law rotaryAxisOffset(SpecReader& read) {
  Law law = axisError(read, "direction", false, parameter("offset", kUnitMicrometre, 1e-5, 1e-2));
  law.nature.choosesFrame = {0};
  return law;
}
Law rotaryAxisTilt(SpecReader& read) {
  return axisError(read, "about", true, parameter("tilt", kUnitArcsecond, kArcsecond, 0.1));
}

/// Of each rotary joint every axis of its fixed side but its own.
bool acrossAxis(const EffectSpec& spec, const Domain& domain) {
  const std::string& axis = spec.keys.back().second.items.front();
  return !alongAxis(domain.joints[domain.findJoint(spec.text("joint"))], axis[0] - 'x');
}

/// In two radial directions: tilts (rad), or displacements (m) with the scale's own error of reading; a scale
/// that alone is eccentric has only that.
enum class Wave { kTilt, kRadialAndReading, kReading };
/// An error motion of the axis of rotation that comes back with each 1/harmonic of a turn: a cosine and a
/// sine of each of its components.
Law rotaryWave(SpecReader& read, Wave wave) {
  const int joint = read.joint("joint", JointKind::kRotary);
  const RadialDirections radial(read, joint);
  const int harmonic = read.integer("harmonic", 1, kHighestHarmonic);
  Law law;
  law.nature.stage = Stage::kJoint;
  const bool tilts = wave == Wave::kTilt;
  const int radials = wave == Wave::kReading ? 0 : 2, reading = 2 * radials;
  for (int d = 0; d < radials; ++d)
    for (const char* phase : {"_cos", "_sin"})
      law.parameters.push_back(
          errorParameter(radial.names[d] + phase, tilts ? JointKind::kRotary : JointKind::kLinear));
  if (!tilts)
    for (const char* phase : {"cos", "sin"})
      law.parameters.push_back(errorParameter(std::string("reading_") + phase, JointKind::kRotary));
  law.add = [layout = read.layout(), directions = radial.directions, joint, harmonic, tilts, radials,
             reading](const State& s, const double* p, ErrorSink& sink) {
    const double phase = harmonic * s.position[joint];
    const double cosine = std::cos(phase), sine = std::sin(phase);
    for (int d = 0; d < radials; ++d)
      for (int k = 0; k < 3; ++k) {
        const double along = directions[d][k];
        if (along == 0.0) continue;
        const int slot = tilts ? layout.jointRotation(joint, k) : layout.jointTranslation(joint, k);
        sink.add(slot, 2 * d, p[2 * d], cosine * along);
        sink.add(slot, 2 * d + 1, p[2 * d + 1], sine * along);
      }
    if (tilts) return;
    sink.add(layout.axis(joint), reading, p[reading], cosine);
    sink.add(layout.axis(joint), reading + 1, p[reading + 1], sine);
  };
  law.nature.shapeKeys = {"harmonic"};
  if (!tilts) law.nature.shapeKeys.push_back("reading_only");
  // no race is exactly round or exactly an ellipse, and no wave is a pure sine
  std::set<int> others{1, 2, 3, 2 * harmonic};
  others.erase(harmonic);
  for (const int h : others)
    if (h <= kHighestHarmonic) law.freedom.push_back({read.canonical().set("harmonic", h)});
  law.nature.mustMove = {joint};
  law.words["turn"] = harmonic == 1 ? "turn" : "1/" + std::to_string(harmonic) + " turn";
  return law;
}
Law rotaryEccentricity(SpecReader& read) {
  return rotaryWave(read, read.flag("reading_only", false) ? Wave::kReading : Wave::kRadialAndReading);
}
Law rotaryWobble(SpecReader& read) { return rotaryWave(read, Wave::kTilt); }

}  // namespace

std::vector<LawRow> lawsOfRotaryAxes() {
  const Values joint = joints("joint", JointKind::kRotary), harmonic = numbers("harmonic", 1, kUsual);
  return {
      {"rotary_zero", {"joint"}, {joint}, {}, rotaryZero},
      {"rotary_axis_offset",
       {"joint", "direction"},
       {joint, fixed("direction", {"x", "y", "z"})},
       acrossAxis,
       rotaryAxisOffset},
      {"rotary_axis_tilt",
       {"joint", "about"},
       {joint, fixed("about", {"x", "y", "z"})},
       acrossAxis,
       rotaryAxisTilt},
      {"rotary_eccentricity",
       {"joint", "harmonic", "reading_only"},
       {joint, harmonic, fixed("reading_only", {"", "true"})},
       {},
       rotaryEccentricity},
      {"rotary_wobble", {"joint", "harmonic"}, {joint, harmonic}, {}, rotaryWobble},
  };
}

}  // namespace mm
