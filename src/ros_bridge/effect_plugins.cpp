#include "ros_bridge/effect_plugins.h"

#include <rospack/rospack.h>
#include <tinyxml2.h>

#include <cstdlib>
#include <filesystem>
#include <pluginlib/class_loader.hpp>

#include "base/error.h"

namespace mm {
namespace {

constexpr char kPackage[] = "measuring_machine";
constexpr char kBase[] = "mm::plugin::EffectType";
using Loader = pluginlib::ClassLoader<plugin::EffectType>;

std::string firstLine(const std::string& text) { return text.substr(0, text.find('\n')); }

/// Every description that a package exports to this one; none without a ROS environment. In silence: rospack
/// would print its own lines. A list of packages that another program left half-written is made anew.
std::vector<std::string> exportedDescriptions() {
  rospack::Rospack packages;
  packages.setQuiet(true);
  std::vector<std::string> path, found;
  if (!packages.getSearchPathFromEnv(path)) return {};
  std::string self;
  for (const bool force : {false, true}) {
    packages.crawl(path, force);
    if (!packages.find(kPackage, self)) continue;
    packages.plugins(kPackage, "plugin", "", found);
    break;
  }
  return found;
}

bool describesEffects(const tinyxml2::XMLElement* element) {
  for (; element != nullptr; element = element->NextSiblingElement()) {
    const char* base = element->Attribute("base_class_type");
    if ((base != nullptr && std::string(base) == kBase) || describesEffects(element->FirstChildElement()))
      return true;
  }
  return false;
}

/// The descriptions of effects that can be read; of others pluginlib would speak in its own way.
std::vector<std::string> descriptions(const PluginTrouble& trouble) {
  std::vector<std::string> readable;
  for (const std::string& line : exportedDescriptions()) {
    const std::string file = line.substr(line.find(' ') + 1);  // "package path"
    tinyxml2::XMLDocument document;
    if (!std::filesystem::exists(file))
      trouble("effect plugins: " + file +
              " does not exist; correct the line <measuring_machine plugin=…/> in the package.xml of its "
              "package");
    else if (document.LoadFile(file.c_str()) != tinyxml2::XML_SUCCESS || document.RootElement() == nullptr)
      trouble("effect plugins: " + file + ":" + std::to_string(document.ErrorLineNum()) +
              ": is not XML; correct it");
    else if (describesEffects(document.RootElement()))
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
    trouble(origin + " is ignored: its library has no class " + loader.getClassType(name) +
            "; export it with PLUGINLIB_EXPORT_CLASS, or correct the plugin's xml");
  } catch (const std::exception& e) {
    trouble(origin + " is ignored: " + firstLine(e.what()));
  } catch (...) {
    trouble(origin + " is ignored: it threw something that is not a std::exception");
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
