// Klipper: a position goes through the skew, then the thermal adjustment of z, then the mesh (each registers
// its set_move_transform before the one of the step before: klippy:ready, klippy:connect, reading of the
// configuration).
#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/units.h"
#include "interpreters/klipper_state.h"
#include "interpreters/table_sum.h"
#include "interpreters/targets.h"

namespace mm {
namespace {

class KlipperInterpreter : public Interpreter {
 public:
  explicit KlipperInterpreter(KlipperState state) : state_(std::move(state)) {}

  std::map<std::string, double> motors(const CommandedState& command) const override {
    const bool skewed = state_.skew.xy != 0.0 || state_.skew.xz != 0.0 || state_.skew.yz != 0.0;
    if (!skewed && !state_.mesh && !state_.thermal) return command.position;
    double x = commanded(command, "x") / kMillimetre, y = commanded(command, "y") / kMillimetre,
           z = commanded(command, "z") / kMillimetre;
    const KlipperSkew& skew = state_.skew;
    x = x - y * skew.xy - z * (skew.xz - skew.xy * skew.yz);
    y = y - z * skew.yz;
    z += thermal(command);
    const double factor = meshFactor(z);
    z += (state_.mesh ? factor * state_.mesh->at(x, y) : 0.0) + state_.fadeTarget;
    std::map<std::string, double> motors = command.position;
    motors["x"] = x * kMillimetre;
    motors["y"] = y * kMillimetre;
    motors["z"] = z * kMillimetre;
    return motors;
  }

  JointPoints points() const override {
    JointPoints points;
    if (state_.skew.xy != 0.0 || state_.skew.xz != 0.0) points["x"];
    if (state_.skew.yz != 0.0) points["y"];
    if (state_.thermal && state_.thermal->enabled && state_.thermal->coefficient != 0.0) points["z"];
    if (!state_.mesh) return points;
    points["z"];
    const auto add = [&](const char* joint, std::vector<double> at) {
      for (double& position : at) position *= kMillimetre;
      addPoints(joint, at, points);
    };
    add("x", state_.mesh->alongX());
    add("y", state_.mesh->alongY());
    return points;
  }

 private:
  /// mm. Steps of the z motor are not counted: Klipper leaves changes below one of them out.
  double thermal(const CommandedState& command) const {
    if (!state_.thermal || !state_.thermal->enabled || state_.thermal->coefficient == 0.0) return 0.0;
    const double reference = state_.thermal->reference ? *state_.thermal->reference
                                                       : temperature(command, "z_thermal_adjust_homed");
    const double change = temperature(command, "z_thermal_adjust") - reference;
    const double adjust = -state_.thermal->coefficient * change;
    return std::abs(adjust) > std::abs(state_.thermal->most)
               ? std::copysign(1.0, adjust) * state_.thermal->most
               : adjust;
  }

  static double temperature(const CommandedState& command, const char* sensor) {
    const auto found = command.temperature.find(sensor);
    if (found == command.temperature.end())
      throw InputError(
          std::string("z_thermal_adjust needs the temperature '") + sensor +
          "', which the command does not have; SET_Z_THERMAL_ADJUST REF_TEMP sets the reference");
    return found->second;
  }

  double meshFactor(double z) const {
    if (z >= state_.fadeEnd) return 0.0;
    if (z >= state_.fadeStart) return (state_.fadeEnd - z) / (state_.fadeEnd - state_.fadeStart);
    return 1.0;
  }

  KlipperState state_;
};

}  // namespace

std::unique_ptr<Interpreter> interpretKlipper(const std::filesystem::path& folder) {
  return std::make_unique<KlipperInterpreter>(readKlipperState(folder));
}

}  // namespace mm
