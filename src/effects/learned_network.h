#pragma once
#include <string>
#include <vector>

namespace mm {

/// What an effect whose shape is learned (thermal_network) learned from a session, complete. The effect keeps
/// it; a calibration file keeps it beside the domain that it refers to.
struct LearnedNetwork {
  std::string effect;                // its canonical spec, one line of YAML
  bool active = false;               // false: it was not worth it, and gives nothing
  std::vector<std::string> sensors;  // its inputs, degC, in this order
  std::vector<double> positions;     // its outputs: errors of the axis here; ascending, m or rad
  std::vector<double> numbers;       // of ThermalNetwork::toNumbers(); empty where it is not active
  std::string summary;               // for people: what was learned, or why it is not active
  /// Errors on held-out blocks of time, m or rad: of the network, of the ridge-linear one, and without any.
  double heldOut = 0.0, heldOutRidge = 0.0, heldOutNone = 0.0;
};

}  // namespace mm
