#include "ros_bridge/effect_plugins.h"

#include <ros/package.h>
#include <tinyxml2.h>

#include <cstdlib>
#include <filesystem>
#include <pluginlib/class_loader.hpp>

#include "machine/error.h"

namespace mm {
namespace {

constexpr char kPackage[] = "measuring_machine";
constexpr char kBase[] = "mm::plugin::EffectType";
using Loader = pluginlib::ClassLoader<plugin::EffectType>;

std::string firstLine(const std::string& text) { return text.substr(0, text.find('\n')); }

/// The descriptions that can be read; of the others pluginlib would speak in its own way.
std::vector<std::string> descriptions(const PluginTrouble& trouble) {
  std::vector<std::string> exported, readable;
  ros::package::getPlugins(kPackage, "plugin", exported);
  for (const std::string& file : exported) {
    tinyxml2::XMLDocument document;
    if (!std::filesystem::exists(file))
      trouble(
          "effect plugins: " + file +
          " does not exist; mend the line <measuring_machine plugin=…/> in the package.xml of its package");
    else if (document.LoadFile(file.c_str()) != tinyxml2::XML_SUCCESS || document.RootElement() == nullptr)
      trouble("effect plugins: " + file + ":" + std::to_string(document.ErrorLineNum()) +
              ": is no XML; mend it");
    else
      readable.push_back(file);
  }
  return readable;
}

void load(Loader& loader, const std::string& name, const PluginTrouble& trouble) {
  const std::string origin = "effect plugin '" + name + "' of package " + loader.getClassPackage(name);
  try {
    std::shared_ptr<const plugin::EffectType> type = loader.createSharedInstance(name);
    if (type->builtWith() != plugin::kInterface)
      throw InputError("it was built with interface " + std::to_string(type->builtWith()) +
                       " of effect_plugin.h, this is " + std::to_string(plugin::kInterface) +
                       "; build it again");
    registerEffectType(pluginEffectType(type, origin, trouble));
  } catch (const pluginlib::CreateClassException&) {
    trouble(origin + " is left out: its library has no class " + loader.getClassType(name) +
            "; export it with PLUGINLIB_EXPORT_CLASS, or mend the plugin's xml");
  } catch (const std::exception& e) {
    trouble(origin + " is left out: " + firstLine(e.what()));
  } catch (...) {
    trouble(origin + " is left out: it threw something that is no std::exception");
  }
}

}  // namespace

void loadEffectPlugins(const PluginTrouble& trouble) {
  if (std::getenv("ROS_PACKAGE_PATH") == nullptr) return;
  try {
    const std::vector<std::string> files = descriptions(trouble);
    if (files.empty()) return;
    // Kept for good: the code of the effects is in the libraries that it holds.
    static Loader* const loader = new Loader(kPackage, kBase, "plugin", files);
    for (const std::string& name : loader->getDeclaredClasses()) load(*loader, name, trouble);
  } catch (const std::exception&) {
    // measuring_machine itself is not on the path: a program run from its build folder has no plugins
  }
}

}  // namespace mm
