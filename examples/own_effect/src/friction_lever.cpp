#include "friction_lever.h"

#include <cmath>
#include <pluginlib/class_list_macros.hpp>

namespace own_effect {
namespace {

class FrictionLever : public mm::plugin::Effect {
 public:
  FrictionLever(const mm::plugin::Keys& keys, const mm::plugin::Session& session)
      : name_(keys.at("axis")),
        acrossName_(keys.at("across")),
        axis_(session.joint(name_)),
        across_(session.joint(acrossName_)) {
    const auto& lever = session.joints[across_];
    if (session.joints[axis_].rotary || lever.rotary || axis_ == across_)
      throw std::invalid_argument("axis and across must be two different linear joints");
    middle_ = 0.5 * (lever.lower + lever.upper);
  }

  std::vector<mm::plugin::Parameter> parameters() const override {
    mm::plugin::Parameter angle;
    angle.name = "angle";
    angle.unit = "arcsec";
    angle.toUnit = 1.0 / mm::plugin::kArcsecond;
    angle.scale = mm::plugin::kArcsecond;
    angle.bound = 0.01;  // rad
    return {angle};
  }

  void evaluate(const mm::plugin::State& state, const double* p, mm::plugin::Error& error) const override {
    // a direction that is not known makes the error unknown, not zero
    const double side = state.travel[axis_] != 0.0 ? state.travel[axis_] : std::nan("");
    error.reading[axis_] += -0.5 * p[0] * side * (state.position[across_] - middle_);
  }

  std::vector<int> mustMove() const override { return {across_}; }

  std::string cause() const override {
    return "The drive of " + name_ +
           " pulls beside the middle of the friction of its guideways: the carriage " +
           "turns a little at each reversal, and the lever along " + acrossName_ +
           " makes a displacement of it.";
  }
  std::string remedy() const override {
    return "Oil the guideways of " + name_ +
           " evenly, set the preload on both sides alike, or move the drive " +
           "to the middle of the friction.";
  }
  std::string shownBy() const override {
    return "Contacts with " + name_ + " travelling both ways, at several heights along " + acrossName_ + ".";
  }

 private:
  std::string name_, acrossName_;
  int axis_, across_;
  double middle_ = 0.0;  // m
};

}  // namespace

std::unique_ptr<mm::plugin::Effect> FrictionLeverType::create(const mm::plugin::Keys& keys,
                                                              const mm::plugin::Session& session) const {
  return std::make_unique<FrictionLever>(keys, session);
}

std::vector<mm::plugin::Keys> FrictionLeverType::candidates(const mm::plugin::Session& session) const {
  std::vector<mm::plugin::Keys> all;
  for (const auto& axis : session.joints)
    for (const auto& across : session.joints)
      if (!axis.rotary && !across.rotary && axis.name != across.name)
        all.push_back({{"axis", axis.name}, {"across", across.name}});
  return all;
}

}  // namespace own_effect

PLUGINLIB_EXPORT_CLASS(own_effect::FrictionLeverType, mm::plugin::EffectType)
