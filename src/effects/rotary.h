#pragma once
#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "effects/catalogue_effect.h"

namespace mm {

/// True when the axis of rotation is axis k of the joint's fixed side: displaced along it or turned about it,
/// it stays.
bool alongAxis(const Joint& joint, int k);

/// Two unit vectors across the axis of rotation, in the axes of the joint's fixed side: two of these axes
/// themselves where the rotation is about the third (then named x, y or z), else any pair (named u, w).
struct RadialDirections {
  RadialDirections(const SpecReader& read, int index);  ///< @throw InputError: the axis is not known

  std::array<Eigen::Vector3d, 2> directions;
  std::array<std::string, 2> names{"u", "w"};
};

/// An effect of one rotary joint, which the key `joint` names.
class RotaryEffect : public CatalogueEffect {
 protected:
  RotaryEffect(SpecReader& read, Stage stage);

  const int joint_;
  const std::string name_;  // of the joint
};

/// A constant error of place of the axis of rotation (ISO 230-7), along or about an axis of the joint's fixed
/// side.
class RotaryAxisError : public RotaryEffect {
 public:
  std::vector<int> mustMove() const override { return {joint_}; }
  std::string shownBy() const override;

 protected:
  /// @param key names the axis of the fixed side.
  RotaryAxisError(SpecReader& read, const std::string& key);

  const int axis_;
};

/// An error motion of the axis of rotation that comes back with each 1/harmonic of a turn: a cosine and a
/// sine in two radial directions, four parameters.
class RotaryWave : public RotaryEffect {
 public:
  std::vector<std::string> shapeKeys() const override { return {"harmonic"}; }
  /// The other harmonics of a bearing: no race is exactly round or exactly an ellipse, and no wave is a pure
  /// sine.
  std::vector<ShapeFreedom> freedom(const Domain&) const override;
  std::vector<int> mustMove() const override { return {joint_}; }

 protected:
  /// @param kind of the errors: displacements (m) or tilts (rad).
  RotaryWave(SpecReader& read, JointKind kind);

  /// Angle of the wave, rad.
  double phase(const State& state) const { return harmonic_ * state.position[joint_]; }
  /// Adds the four parameters, the first at p[0]. @param slotOf slot of axis k of the joint's fixed side.
  template <typename SlotOf>
  void addRadial(const State& state, const double* p, ErrorSink& sink, const SlotOf& slotOf) const {
    const double cosine = std::cos(phase(state)), sine = std::sin(phase(state));
    for (int d = 0; d < 2; ++d)
      for (int k = 0; k < 3; ++k) {
        const double along = radial_.directions[d][k];
        if (along == 0.0) continue;
        sink.add(slotOf(k), 2 * d, p[2 * d], cosine * along);
        sink.add(slotOf(k), 2 * d + 1, p[2 * d + 1], sine * along);
      }
  }

  std::string turn_;  // "turn", "1/2 turn" …

 private:
  const RadialDirections radial_;
  const int harmonic_;
};

/// The members of a RotaryAxisError: of each rotary joint, every axis of its fixed side but its own.
std::vector<EffectSpec> acrossRotaryAxes(const std::string& type, const std::string& key,
                                         const Domain& domain);
/// The members of a RotaryWave: harmonics 1 to 3 of each rotary joint.
std::vector<EffectSpec> rotaryHarmonics(const std::string& type, const Domain& domain);

}  // namespace mm
