#include "simulation/roughness.h"

#include <yaml-cpp/yaml.h>

#include <cmath>
#include <cstdlib>
#include <sstream>
#include <vector>

#include "base/error.h"
#include "base/text.h"
#include "base/yaml_mapping.h"

namespace mm {
namespace {

constexpr double kLargest = 1e3;  // repeatabilities: beyond it nothing else would be left of a session

/// One way of being rough.
struct Way {
  const char* name;
  double Roughness::*size;
  double standard;
  bool ofAll;
};

constexpr Way kWays[] = {
    {"drift", &Roughness::drift, 1.0, true}, {"correlated", &Roughness::correlated, 1.0, true},
    {"form", &Roughness::form, 1.0, true},   {"sensors", &Roughness::sensors, 1.0, true},
    {"tails", &Roughness::tails, 1.0, true}, {"quantised", &Roughness::quantised, 3.0, false}};

constexpr char kWords[] =
    "drift, correlated, form, sensors, tails, quantised, all, none, each with a size if it is not to be the "
    "usual one, such as drift=2";

double sizeOf(const std::string& text, const std::string& word, const std::string& where) {
  char* end = nullptr;
  const double size = std::strtod(text.c_str(), &end);
  if (text.empty() || *end != '\0' || !(size >= 0.0) || size > kLargest)
    throw InputError(where + ": the size '" + text + "' of '" + word +
                     "' must be a factor of the repeatability from 0 to 1000, such as " + word + "=2");
  return size;
}

void set(const YamlMapping& map, const std::string& key, double lower, double upper, double& value) {
  if (map.has(key)) value = map.number(key, 1.0, lower, upper);
}

/// What can be set of one way beside its size.
void readWay(const std::string& name, const YAML::Node& node, const std::string& source, double standard,
             double& size, Roughness& rough) {
  std::vector<std::string> keys = {"size"};
  if (name == "drift") keys.emplace_back("settlings");
  if (name == "correlated") keys.emplace_back("correlation");
  if (name == "sensors") keys.insert(keys.end(), {"noise_K", "step_K", "offset_K", "lag_s"});
  if (name == "tails") keys.insert(keys.end(), {"dof", "wild_share", "wild_sizes"});
  const YamlMapping map(node, source, "rough: " + name, keys);
  size = standard;
  set(map, "size", 0.0, kLargest, size);
  set(map, "settlings", 0.0, 1000.0, rough.settlings);
  set(map, "correlation", -0.99, 0.99, rough.correlation);
  set(map, "noise_K", 0.0, 100.0, rough.sensorNoise);
  set(map, "step_K", 0.0, 100.0, rough.sensorStep);
  set(map, "offset_K", 0.0, 100.0, rough.sensorOffset);
  set(map, "dof", 2.01, 1e6, rough.tailDof);
  set(map, "wild_share", 0.0, 1.0, rough.wildShare);
  const auto range = [&](const char* key, double& lower, double& upper) {
    if (!map.has(key)) return;
    const std::vector<double> values = map.numbers(key, 1.0);
    if (values.size() != 2 || values[0] < 0.0 || values[1] < values[0])
      map.fail(key, "must be two numbers from 0 on, [from, to]");
    lower = values[0];
    upper = values[1];
  };
  range("lag_s", rough.sensorLagLower, rough.sensorLagUpper);
  range("wild_sizes", rough.wildLower, rough.wildUpper);
  if (map.has("lag_s") && rough.sensorLagLower <= 0.0) map.fail("lag_s", "must be above 0 s");
}

}  // namespace

double Roughness::noiseFactor() const {
  return (correlated > 0.0 ? correlated : 1.0) * (tails > 0.0 ? tails : 1.0);
}

std::string Roughness::text() const {
  std::ostringstream out;
  for (const Way& way : kWays)
    if (this->*way.size > 0.0) out << (out.tellp() > 0 ? "," : "") << way.name << "=" << this->*way.size;
  return out.tellp() > 0 ? out.str() : "none";
}

void Roughness::change(const std::string& words, const std::string& where) {
  std::istringstream in(words);
  std::string item;
  while (std::getline(in, item, ',')) {
    item = std::string(trim(item, " \t"));
    const std::size_t equals = item.find('=');
    const std::string word = item.substr(0, equals);
    bool known = false;
    for (const Way& way : kWays) {
      const bool named = word == way.name, all = word == "all" && way.ofAll, none = word == "none";
      if (!named && !all && !none) continue;
      known = true;
      this->*way.size = none                          ? 0.0
                        : equals == std::string::npos ? way.standard
                                                      : sizeOf(item.substr(equals + 1), word, where);
    }
    if (!known) throw InputError(where + ": '" + word + "' is not a disturbance; available: " + kWords);
  }
}

Roughness Roughness::read(const YAML::Node& node, const std::string& source) {
  Roughness rough;
  const std::string where = source + ":" + std::to_string(node.Mark().line + 1) + ": rough";
  if (node.IsScalar()) rough.change(node.Scalar(), where);
  if (node.IsSequence())
    for (const YAML::Node& word : node) {
      if (!word.IsScalar()) throw InputError(where + ": a list is of words; possible are " + kWords);
      rough.change(word.Scalar(), where);
    }
  if (!node.IsMap()) return rough;
  std::vector<std::string> names;
  for (const Way& way : kWays) names.emplace_back(way.name);
  const YamlMapping map(node, source, "rough", names);
  for (const Way& way : kWays) {
    if (!map.has(way.name)) continue;
    const YAML::Node value = map.node(way.name);
    if (value.IsMap())
      readWay(way.name, value, source, way.standard, rough.*way.size, rough);
    else
      rough.*way.size = map.number(way.name, 1.0, 0.0, kLargest);
  }
  return rough;
}

}  // namespace mm
