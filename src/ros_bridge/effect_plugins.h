#pragma once
#include "ros_bridge/plugin_effect.h"

namespace mm {

/// Adds the effects of the user's own packages to the registry: pluginlib classes with the base
/// `mm::plugin::EffectType` (include/measuring_machine/effect_plugin.h). A plugin that cannot be loaded,
/// throws or has a name that is taken is left out, and `trouble` hears one line about it. Without a ROS
/// environment (ROS_PACKAGE_PATH) there are none. To be called once, before a model is read.
void loadEffectPlugins(const PluginTrouble& trouble);

}  // namespace mm
