#include "simulation/roughness.h"

#include <yaml-cpp/yaml.h>

#include <cstdlib>
#include <sstream>

#include "base/error.h"
#include "base/text.h"

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
  if (!node.IsScalar()) throw InputError(where + ": must be words; possible are " + kWords);
  rough.change(node.Scalar(), where);
  return rough;
}

}  // namespace mm
