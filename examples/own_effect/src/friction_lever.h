#pragma once
#include <measuring_machine/effect_plugin.h>

namespace own_effect {

/// `friction_lever {axis, across}`: the drive pulls beside the middle of the friction of its guideways, so
/// the carriage of `axis` turns a little at each reversal. At the height `across` of the tip above the middle
/// of the session's travel the reading is wrong by -1/2 * angle * sign(v_axis) * (q_across - middle), m.
class FrictionLeverType : public mm::plugin::EffectType {
 public:
  std::string name() const override { return "friction_lever"; }
  std::vector<mm::plugin::Key> keys() const override { return {{"axis", ""}, {"across", ""}}; }
  /// @throw std::invalid_argument where a key names no linear joint, or both name the same.
  std::unique_ptr<mm::plugin::Effect> create(const mm::plugin::Keys& keys,
                                             const mm::plugin::Session& session) const override;
  /// Every linear joint with every other one.
  std::vector<mm::plugin::Keys> candidates(const mm::plugin::Session& session) const override;
};

}  // namespace own_effect
