#pragma once
#include <cmath>
#include <limits>

#include "base/units.h"
#include "calibration_file/calibration.h"
#include "compensation/compensator.h"

namespace mm::test {

inline constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

/// A calibration of the effects on a machine, observed over x, y, z -20 to 20 mm, b and a -1 to 1 rad, 18 to
/// 26 degC, 1000 s; all parameters zero, variances 1e-16 (SI).
inline Calibration calibrationOf(const Machine& machine, const std::vector<EffectSpec>& effects) {
  Calibration c;
  c.id = "test";
  c.machineName = machine.name();
  c.urdf = machine.urdf();
  c.domain.setMachine(machine);
  for (const Joint& joint : machine.joints()) {
    const double reach = joint.kind == JointKind::kLinear ? 0.020 : 1.0;
    c.domain.lower.push_back(-reach);
    c.domain.upper.push_back(reach);
    c.domain.positions.emplace_back();
  }
  c.domain.sensors = {"bed", "air"};
  c.domain.sensorLower = {18, 18};
  c.domain.sensorUpper = {26, 26};
  c.domain.duration = 1000;
  c.effects = effects;
  const Model model(machine, c.domain, effects);
  for (int p = 0; p < model.parameterCount(); ++p) {
    const Parameter& parameter = model.parameter(p);
    c.values.push_back(
        {model.effectOf(p), parameter.name, parameter.unit, parameter.toUnit, 0.0, 1e-8, false});
  }
  const auto n = static_cast<Eigen::Index>(c.values.size());
  c.covariance = 1e-16 * Eigen::MatrixXd::Identity(n, n);
  return c;
}

inline double& value(Calibration& c, const std::string& name) {
  for (Calibration::Value& v : c.values)
    if (v.name == name) return v.value;
  throw std::logic_error("test: no parameter " + name);
}

/// The 21 constants of MMT at sizes found on real machines (some um over the workspace).
inline Calibration mmtCalibration(const Machine& machine) {
  std::vector<EffectSpec> specs;
  for (const char* axis : {"x", "y", "z"})
    specs.push_back(EffectSpec("mmt_deviation").set("axis", axis).set("lead_mm", 1.0));
  Calibration c = calibrationOf(machine, specs);
  for (int axis = 0; axis < 3; ++axis) {
    const double own[] = {2e-4 * (axis + 1), 1e-4, -0.5e-4 * axis,     0.02,
                          -0.01 * axis,      1e-3, -2e-3 + 1e-3 * axis};
    for (int k = 0; k < 7; ++k) c.values[7 * axis + k].value = own[k];
  }
  return c;
}

/// MMT eq. (13) and (14) at the readings q (m) of x, y, z with the constants of mmtCalibration, written out.
inline Eigen::Vector3d mmtByHand(Calibration c, const Eigen::Vector3d& q) {
  const std::string names = "xyz";
  Eigen::Vector3d corrected = q;
  for (int i = 0; i < 3; ++i) {
    const std::string own(1, names[i]);
    const double turn = 2 * kPi * q[i] / 1e-3;
    corrected[i] +=
        value(c, "C" + own + own + "1") * q[i] +
        q[i] * (value(c, "S" + own + own) * std::sin(turn) + value(c, "K" + own + own) * std::cos(turn));
    for (int j = 0; j < 3; ++j) {
      if (j == i) continue;
      const std::string pair = names.substr(j, 1) + own;
      corrected[i] +=
          value(c, "C" + pair) * q[j] * q[j] + q[j] * std::cos(kPi / 2 + value(c, "alpha_" + pair));
    }
  }
  return corrected;
}

inline State stateAt(const Compensator& compensator, std::vector<double> position) {
  State state = compensator.blankState();
  state.position = std::move(position);
  compensator.model().place(state);
  return state;
}

}  // namespace mm::test
