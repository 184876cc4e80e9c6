// Reading and drawing hidden sources: the part of the catalogue that deals with text.
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <sstream>

#include "base/error.h"
#include "base/format.h"
#include "base/nearest_name.h"
#include "base/text.h"
#include "base/units.h"
#include "simulation/catalogue.h"
#include "simulation/quantity.h"

namespace mm {
namespace {

using Key = SourceKind::Key;

/// A source as it was written, before anything is known about it.
struct Written {
  std::string type, size;           // size of the short form
  std::vector<std::string> places;  // of the short form, in the order of the keys
  std::map<std::string, std::string> named;
};

std::vector<std::string> split(const std::string& text, char at) {
  std::vector<std::string> parts;
  std::stringstream stream(text);
  for (std::string part; std::getline(stream, part, at);) parts.push_back(part);
  return parts;
}

Written readMapping(const std::string& text, const std::string& where) {
  Written written;
  try {
    for (const auto& entry : YAML::Load(text)) {
      const std::string key = entry.first.Scalar();
      if (entry.second.IsSequence() && key == "sensors" && entry.second.size() == 2) {
        written.named["warm"] = entry.second[0].Scalar();
        written.named["cold"] = entry.second[1].Scalar();
      } else if (key == "type") {
        written.type = entry.second.Scalar();
      } else if (!entry.second.IsScalar()) {
        throw InputError(where + ": '" + key + "' must be a plain value");
      } else {
        written.named[key] = entry.second.Scalar();
      }
    }
  } catch (const YAML::Exception& e) {
    throw InputError(where + ": '" + text + "' is not YAML: " + e.msg);
  }
  return written;
}

Written readShort(const std::string& text, const std::string& where) {
  Written written;
  const std::vector<std::string> parts = split(text, ',');
  std::string head = parts.empty() ? "" : parts[0];
  const std::size_t equals = head.find('=');
  if (equals != std::string::npos) {
    written.size = trim(head.substr(equals + 1));
    head = head.substr(0, equals);
  }
  const std::size_t colon = head.find(':');
  written.type = trim(head.substr(0, colon));
  if (colon != std::string::npos)
    for (const std::string& place : split(head.substr(colon + 1), '/'))
      written.places.emplace_back(trim(place));
  for (std::size_t i = 1; i < parts.size(); ++i) {
    const std::size_t at = parts[i].find('=');
    if (at == std::string::npos) throw InputError(where + ": '" + parts[i] + "' must be key=value");
    const std::string_view part = parts[i];
    written.named[std::string(trim(part.substr(0, at)))] = trim(part.substr(at + 1));
  }
  return written;
}

const std::map<std::string, std::string> kOtherNames = {{"screw_periodic", "lead_screw_periodic"},
                                                        {"screw_cumulative", "positioning_polynomial"},
                                                        {"cross_talk", "squareness"},
                                                        {"ball_position", "artifact_position"}};

/// What may be drawn for a key. @param source with the keys before it.
std::vector<std::string> choices(const SourceKind::KeyRule& key, const HiddenSource& source,
                                 const Workshop& w) {
  const Key kind = key.kind;
  std::vector<std::string> names;
  const std::string first = source.keys.empty() ? "" : source.keys[0].second;
  for (const Joint& joint : w.machine.joints()) {
    const bool linear = joint.kind == JointKind::kLinear;
    if ((kind == Key::kLinear && linear) || (kind == Key::kRotary && !linear) ||
        (kind == Key::kOtherLinear && linear && joint.name != first) ||
        (kind == Key::kLevel && linear && std::abs(w.chain.axis(w.machine.findJoint(joint.name)).z()) < 0.5))
      names.push_back(joint.name);
  }
  if (kind == Key::kDirection || kind == Key::kOtherDirection || kind == Key::kAbout)
    for (const char* name : {"x", "y", "z"})
      if (kind != Key::kOtherDirection || name != first) names.push_back(name);
  if (kind == Key::kAcross && w.machine.findJoint(first) >= 0)
    for (const char* name : {"x", "y", "z"})
      if (std::abs(w.chain.axis(w.machine.findJoint(first))(name[0] - 'x')) < 0.99) names.push_back(name);
  if (kind == Key::kBody || kind == Key::kColdBody)
    for (const std::string& name : w.settings.thermal.sensors)
      if (kind == Key::kBody ? name != "air" : name != source.key("warm")) names.push_back(name);
  if (kind == Key::kCovariate)
    for (const TrueCovariate& covariate : w.settings.covariates) names.push_back(covariate.name);
  if (kind == Key::kBall)
    for (const Feature& feature : w.artifact.features)
      if (feature.known && feature.kind == FeatureKind::kBall) names.push_back(feature.name);
  if (key.name == "lever") names = {"workpiece", "chain"};
  if (key.name == "order") names = {"2", "3", "4"};
  if (key.name == "harmonic") names = {"1", "2", "3"};
  return names;
}

/// What may be written, though it would not be drawn.
bool alsoAllowed(Key kind, const std::string& value, const HiddenSource& source, const SourceKind& rule,
                 const Workshop& w) {
  const int joint = w.machine.findJoint(value);
  if (kind == Key::kLinear) return joint >= 0 && rule.numbers[0].dimension == "travel";
  if (kind == Key::kDirection) return joint >= 0;
  if (kind == Key::kOtherDirection) return joint >= 0 && value != source.keys[0].second;
  if (kind == Key::kBody) return value == "air" && w.thermal.findBody(value) >= 0;
  if (kind == Key::kBall) return rule.type == "ball_radius" && w.artifact.findFeature(value) >= 0;
  return false;
}

void fillKeys(const SourceKind& rule, const Written& written, const std::string& where, Random& random,
              const Workshop& w, HiddenSource& source) {
  if (written.places.size() > rule.keys.size())
    throw InputError(where + ": '" + rule.type + "' acts at " + std::to_string(rule.keys.size()) +
                     " place(s), not " + std::to_string(written.places.size()));
  for (std::size_t i = 0; i < rule.keys.size(); ++i) {
    const SourceKind::KeyRule& key = rule.keys[i];
    const std::vector<std::string> names = choices(key, source, w);
    const double draw = random.uniform();
    const auto named = written.named.find(key.name);
    std::string value = key.standard;
    if (i < written.places.size()) value = written.places[i];
    if (named != written.named.end()) value = named->second;
    if (value.empty()) {
      if (names.empty())
        throw InputError(where + ": nothing here has '" + rule.type + "' (no " + key.name + " to choose)");
      value = names[static_cast<std::size_t>(draw * names.size())];
    } else if (std::find(names.begin(), names.end(), value) == names.end() &&
               !alsoAllowed(key.kind, value, source, rule, w)) {
      throw InputError(where + ": '" + rule.type + "' has no " + key.name + " '" + value +
                       "'; possible are " + joined(names, ", "));
    }
    source.keys.emplace_back(key.name, value);
  }
}

/// "backlash=2.4um": a size in the middle of those that are drawn.
std::string exampleOf(const SourceKind& rule, const SourceKind::NumberRule& number,
                      const std::string& dimension, double factor) {
  const PeopleUnit unit = peopleUnit(dimension);
  const bool first = number.name == rule.numbers.front().name;
  return rule.type + (first ? "=" : "," + number.name + "=") +
         format("%.2g", std::sqrt(number.lower * number.upper) * factor / unit.factor) + unit.name;
}

void fillNumbers(const SourceKind& rule, const Written& written, const std::string& where, Random& random,
                 const Workshop& w, HiddenSource& source) {
  const int joint = source.keys.empty() ? -1 : w.machine.findJoint(source.keys[0].second);
  const bool rotary = joint >= 0 && w.machine.joints()[joint].kind == JointKind::kRotary;
  for (std::size_t i = 0; i < rule.numbers.size(); ++i) {
    const SourceKind::NumberRule& number = rule.numbers[i];
    const bool angle = number.dimension == "travel" && rotary;
    const std::string dimension = number.dimension == "travel" ? (rotary ? "rad" : "m") : number.dimension;
    const double perMetre =
        angle ? 10.0 : 1.0;  // rad of a rotary joint for m of a linear one: an arm of 0.1 m
    double value = random.logUniform(number.lower, number.upper) * perMetre;
    const double sign = random.sign();
    if (number.eitherSign) value *= sign;
    const auto named = written.named.find(number.name);
    const auto size = written.named.find("size");
    const auto read = [&](const std::string& text) {
      try {
        return parseQuantity(text, dimension, where + ": " + number.name);
      } catch (const InputError& e) {
        throw InputError(std::string(e.what()) + "; e.g. " + exampleOf(rule, number, dimension, perMetre));
      }
    };
    if (i == 0 && !written.size.empty()) value = read(written.size);
    if (i == 0 && size != written.named.end()) value = read(size->second);
    if (named != written.named.end()) value = read(named->second);
    source.numbers.push_back({number.name, value, dimension});
  }
}

/// `period_mm: 5`, as the catalogue of effects has it, is `period: 5 mm`.
void takeUnitsOfKeys(const SourceKind& rule, Written& written, const std::string& where) {
  for (const SourceKind::NumberRule& number : rule.numbers)
    for (const char* unit : {"mm", "um", "m", "deg", "arcsec", "s", "h"}) {
      const auto given = written.named.find(number.name + "_" + unit);
      if (given == written.named.end()) continue;
      if (written.named.count(number.name) > 0)
        throw InputError(where + ": '" + number.name + "' is given twice");
      written.named[number.name] = given->second + " " + unit;
      written.named.erase(given);
    }
}

void refuseUnknown(const SourceKind& rule, const Written& written, const std::string& where) {
  for (const auto& [name, value] : written.named) {
    std::vector<std::string> known = {"size"};
    for (const SourceKind::KeyRule& key : rule.keys) known.push_back(key.name);
    for (const SourceKind::NumberRule& number : rule.numbers) known.push_back(number.name);
    if (std::find(known.begin(), known.end(), name) == known.end())
      throw InputError(where + ": '" + rule.type + "' has no key '" + name + "'" + didYouMean(name, known) +
                       "; known are " + joined(known, ", "));
  }
  if (!written.size.empty() && written.named.count("size") > 0)
    throw InputError(where + ": the size is given twice");
}

/// Why a source cannot be in this session, in words; empty: it can.
std::string misfit(const SourceKind& kind, const Workshop& w) {
  if (kind.probe == SourceKind::Probe::kTouch && !w.touches)
    return "is of a touch probe, but the plan touches nothing";
  if (kind.probe == SourceKind::Probe::kLaser && !w.settings.laser.present)
    return "is of a laser probe, but the plan measures with a touch probe";
  if (kind.type == "artifact_expansion" && w.artifact.features.empty())
    return "needs an artifact, but the plan has none";
  return {};
}

/// Whether it may be drawn: there is something for each of its keys.
bool fits(const SourceKind& kind, const Workshop& w) {
  if (kind.onlyByName || !misfit(kind, w).empty()) return false;
  HiddenSource source;
  for (const SourceKind::KeyRule& key : kind.keys) {
    const std::vector<std::string> names = choices(key, source, w);
    if (names.empty()) return false;
    source.keys.emplace_back(key.name, names[0]);
  }
  return true;
}

const SourceKind& kindOf(const std::string& type, const std::string& where, Random& random,
                         const Workshop& w) {
  const auto other = kOtherNames.find(type);
  const std::string name = other != kOtherNames.end() ? other->second : type;
  const double draw = random.uniform();
  std::vector<const SourceKind*> fitting;
  for (const SourceKind& kind : w.kinds) {
    if (kind.type == name) {
      if (const std::string why = misfit(kind, w); !why.empty())
        throw InputError(where + ": '" + kind.type + "' " + why);
      return kind;
    }
    if (fits(kind, w)) fitting.push_back(&kind);
  }
  if (name == "random" && !fitting.empty()) return *fitting[static_cast<std::size_t>(draw * fitting.size())];
  std::vector<std::string> known;
  for (const SourceKind& kind : w.kinds) known.push_back(kind.type);
  throw InputError(where + ": nothing called '" + type + "' can be hidden" + didYouMean(type, known) +
                   "; possible are random, " + joined(known, ", "));
}

}  // namespace

std::string HiddenSource::key(const std::string& name) const {
  for (const auto& [key, value] : keys)
    if (key == name) return value;
  return "";
}

double HiddenSource::number(const std::string& name) const {
  for (const Number& number : numbers)
    if (number.name == name) return number.value;
  throw InputError("the source '" + type + "' has no number '" + name + "'");
}

std::string HiddenSource::text() const {
  std::ostringstream out;
  out << "{type: " << type;
  for (const auto& [key, value] : keys) out << ", " << key << ": " << value;
  out.precision(9);
  for (const Number& number : numbers) {
    const PeopleUnit unit = peopleUnit(number.dimension);
    out << ", " << number.name << ": " << number.value / unit.factor << " " << unit.name;
  }
  out << "}";
  return out.str();
}

HiddenSource hideSource(const std::string& text, const std::string& from, std::uint64_t seed,
                        const std::string& stream, Workshop& workshop) {
  Random random(seed, stream);
  const std::string plain(trim(text));
  const std::string where = from + " '" + plain + "'";
  Written written = !plain.empty() && plain[0] == '{' ? readMapping(plain, where) : readShort(plain, where);
  const SourceKind& kind = kindOf(written.type, where, random, workshop);
  takeUnitsOfKeys(kind, written, where);
  refuseUnknown(kind, written, where);
  HiddenSource source;
  source.type = kind.type;
  fillKeys(kind, written, where, random, workshop, source);
  fillNumbers(kind, written, where, random, workshop, source);
  kind.build({source, workshop, random});
  return source;
}

}  // namespace mm
