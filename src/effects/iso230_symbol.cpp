#include "effects/iso230_symbol.h"

#include <Eigen/Geometry>
#include <array>
#include <cmath>

#include "effects/effect_words.h"

namespace mm {
namespace {

enum class ErrorOf {
  kAxisAlongItself,  // key `axis`
  kAxisInDirection,  // keys `axis` and `direction`
  kAxisAbout,        // `axis`, `about`: an axis of workpiece
  kOtherInAxis,      // `of` moves, the error is along `axis`
  kWithInDirection,  // `with` moves, the error is along `direction`
  kOneVariable,      // `variable` moves, the error is along `direction`
  kZero,             // `joint`
  kPlace,            // `joint`, `direction`: an axis of its fixed side
  kOrientation,      // `joint`, `about`: an axis of its fixed side
  kRadialAndReading,
  kTilts
};

struct SymbolRow {
  const char* type;
  ErrorOf is;
};

constexpr std::array<SymbolRow, 19> kSymbolRows = {{{"scale", ErrorOf::kAxisAlongItself},
                                                    {"positioning_polynomial", ErrorOf::kAxisAlongItself},
                                                    {"lead_screw_periodic", ErrorOf::kAxisAlongItself},
                                                    {"position_table", ErrorOf::kAxisAlongItself},
                                                    {"backlash", ErrorOf::kAxisAlongItself},
                                                    {"lost_motion", ErrorOf::kAxisAlongItself},
                                                    {"straightness", ErrorOf::kAxisInDirection},
                                                    {"straightness_table", ErrorOf::kAxisInDirection},
                                                    {"angular_motion", ErrorOf::kAxisAbout},
                                                    {"angular_reversal", ErrorOf::kAxisAbout},
                                                    {"straightness_reversal", ErrorOf::kAxisInDirection},
                                                    {"squareness", ErrorOf::kOtherInAxis},
                                                    {"gravity_sag", ErrorOf::kWithInDirection},
                                                    {"profile", ErrorOf::kOneVariable},
                                                    {"rotary_zero", ErrorOf::kZero},
                                                    {"rotary_axis_offset", ErrorOf::kPlace},
                                                    {"rotary_axis_tilt", ErrorOf::kOrientation},
                                                    {"rotary_eccentricity", ErrorOf::kRadialAndReading},
                                                    {"rotary_wobble", ErrorOf::kTilts}}};

/// 0, 1, 2 for x, y, z; else -1.
int workpieceAxis(const std::string& name) {
  return name.size() == 1 && name[0] >= 'x' && name[0] <= 'z' ? name[0] - 'x' : -1;
}

/// "Y", "B"; empty: of no direction of the machine.
std::string directionLetter(const Eigen::Vector3d& direction, JointKind kind) {
  const int k = alongWorkpieceAxis(direction);
  if (k < 0) return {};
  return std::string(1, (kind == JointKind::kLinear ? "XYZ" : "ABC")[k]);
}

bool parallel(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return alongWorkpieceAxis(a) >= 0 && alongWorkpieceAxis(a) == alongWorkpieceAxis(b);
}

std::string joined(const std::string& first, const std::string& second) {
  return first.empty() || second.empty() ? "" : first + second;
}

}  // namespace

ErrorSymbols::ErrorSymbols(const Machine& machine) : axes_(iso230Axes(machine)) {
  for (const Joint& joint : machine.joints()) joints_.push_back(joint.name);
}

const Iso230Axis* ErrorSymbols::axis(const std::string& joint) const {
  for (std::size_t j = 0; j < joints_.size(); ++j)
    if (joints_[j] == joint && !axes_[j].name.empty()) return &axes_[j];
  return nullptr;
}

/// Letter of a direction while `moving` moves: of a joint, or of an axis of workpiece where no joint has that
/// name. Empty where the motion turns the direction.
std::string ErrorSymbols::letterOf(const std::string& direction, const Iso230Axis* moving) const {
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    if (joints_[j] != direction) continue;
    const Iso230Axis& along = axes_[j];
    const bool turned = moving != nullptr && moving->kind == JointKind::kRotary && &along > moving &&
                        !parallel(along.direction, moving->direction);
    return turned ? "" : directionLetter(along.direction, along.kind);
  }
  const int k = workpieceAxis(direction);
  return k < 0 ? "" : directionLetter(Eigen::Vector3d::Unit(k), JointKind::kLinear);
}

std::string ErrorSymbols::motion(const std::string& direction, const std::string& joint) const {
  const Iso230Axis* moving = axis(joint);
  if (moving == nullptr) return {};
  const std::string letter = letterOf(direction, moving);
  return letter.empty() ? "" : "E" + letter + moving->name;
}

/// Error motions of a rotary axis across itself: tilts, else displacements with the reading.
std::string ErrorSymbols::rotations(const std::string& joint, bool tilts) const {
  const Iso230Axis* of = axis(joint);
  if (of == nullptr) return {};
  const int own = alongWorkpieceAxis(of->direction);
  std::string text;
  for (int k = 0; k < 3; ++k)
    if (k != own)
      text += (text.empty() ? "E" : ", E") + std::string(1, (tilts ? "ABC" : "XYZ")[k]) + of->name;
  return tilts ? text : text + ", E" + std::string(1, "ABC"[own]) + of->name;
}

int ErrorSymbols::squarenessSign(const EffectSpec& effect) const {
  if (effect.type != "squareness") return 0;
  const Iso230Axis *along = axis(effect.text("axis")), *turned = axis(effect.text("of"));
  if (along == nullptr || turned == nullptr || along->kind != JointKind::kLinear ||
      turned->kind != JointKind::kLinear || parallel(along->direction, turned->direction))
    return 0;
  // turned by an angle about k, its direction u changes by the angle times k x u; that is along the other
  // axis
  const Eigen::Vector3d about = turned->direction.cross(along->direction);
  const int k = alongWorkpieceAxis(about);
  return k < 0 ? 0 : about[k] > 0.0 ? 1 : -1;
}

std::string ErrorSymbols::of(const EffectSpec& effect) const {
  const SymbolRow* row = nullptr;
  for (const SymbolRow& r : kSymbolRows)
    if (effect.type == r.type) row = &r;
  if (row == nullptr) return {};
  const auto text = [&](const char* key) { return effect.text(key); };
  const Iso230Axis* rotary = axis(text("joint"));
  const int about = workpieceAxis(text(row->is == ErrorOf::kPlace ? "direction" : "about"));
  switch (row->is) {
    case ErrorOf::kAxisAlongItself:
      return motion(text("axis"), text("axis"));
    case ErrorOf::kAxisInDirection:
      return motion(text("direction"), text("axis"));
    case ErrorOf::kWithInDirection:
      return motion(text("direction"), text("with"));
    case ErrorOf::kOneVariable:
      return motion(text("direction"), text("variable"));
    case ErrorOf::kAxisAbout: {
      const Iso230Axis* moving = axis(text("axis"));
      return moving == nullptr || about < 0 ? "" : "E" + std::string(1, "ABC"[about]) + moving->name;
    }
    case ErrorOf::kOtherInAxis: {
      if (squarenessSign(effect) == 0) return motion(text("axis"), text("of"));
      const Iso230Axis *along = axis(text("axis")), *turned = axis(text("of"));
      return directionLetter(turned->direction.cross(along->direction), JointKind::kRotary) + "0" +
             turned->name;
    }
    case ErrorOf::kZero:
      return rotary == nullptr ? ""
                               : joined(directionLetter(rotary->direction, rotary->kind), "0" + rotary->name);
    case ErrorOf::kPlace:
    case ErrorOf::kOrientation:
      if (rotary == nullptr || about < 0) return {};
      return joined(directionLetter(rotary->fixedSide.col(about),
                                    row->is == ErrorOf::kPlace ? JointKind::kLinear : JointKind::kRotary),
                    "0" + rotary->name);
    case ErrorOf::kRadialAndReading:
      return text("reading_only") == "true" ? motion(text("joint"), text("joint"))
                                            : rotations(text("joint"), false);
    case ErrorOf::kTilts:
      return rotations(text("joint"), true);
  }
  return {};
}

std::string inWords(const EffectSpec& effect, const ErrorSymbols& symbols) {
  const std::string symbol = symbols.of(effect);
  return inWords(effect) + (symbol.empty() ? "" : " (" + symbol + ")");
}

}  // namespace mm
