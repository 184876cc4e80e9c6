#pragma once
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "interpreters/klipper_mesh.h"
#include "interpreters/table_text.h"

namespace mm {

struct KlipperSkew {
  double xy = 0.0, xz = 0.0, yz = 0.0;  // tangents
};

/// [z_thermal_adjust], mm and degC.
struct KlipperThermal {
  double coefficient = 0.0;  // mm / K
  double most = 99999999.0;
  std::optional<double> reference;  // REF_TEMP; else the temperature at which z was homed
  bool enabled = true;
};

/// What Klipper does to positions after its configuration was read and the commands of its start were run.
struct KlipperState {
  KlipperSkew skew;
  std::optional<KlipperThermal> thermal;
  std::optional<KlipperMesh> mesh;
  double fadeStart = 0.0, fadeEnd = 0.0, fadeTarget = 0.0;  // mm; no fading where fadeEnd is infinite
};

/// Reads printer.cfg, then start.gcode. @throw InputError naming file, line, option and value for what
/// Klipper would answer with an error.
KlipperState readKlipperState(const std::filesystem::path& folder);

}  // namespace mm
