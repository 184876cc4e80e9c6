#include "effects/effect_words.h"

#include <algorithm>
#include <array>
#include <set>

namespace mm {
namespace {

struct Phrase {
  const char* type;
  const char* words;  // keys in braces
};

/// How the shop calls an effect. Of several phrases of a type the first counts whose keys are all given; keys
/// that a phrase does not use follow it. A type that is not here (a plugin) is told by its own name and keys.
constexpr std::array kPhrases = {
    Phrase{"mmt_deviation", "MMT deviation of {axis}"},
    Phrase{"scale", "scale of {axis}"},
    Phrase{"squareness", "squareness of {of} to {axis}"},
    Phrase{"lead_screw_periodic", "periodic error of {axis}"},
    Phrase{"positioning_polynomial", "positioning error of {axis}"},
    Phrase{"straightness", "straightness of {axis} in {direction}"},
    Phrase{"straightness_table", "straightness table of {axis} in {direction}"},
    Phrase{"position_table", "position table of {axis}"},
    Phrase{"angular_motion", "angular error of {axis} about {about}"},
    Phrase{"backlash", "backlash of {axis}"},
    Phrase{"lost_motion", "lost motion of {axis}"},
    Phrase{"thermal_expansion", "thermal expansion of {axis} with {sensor}"},
    Phrase{"thermal_growth", "thermal growth along {direction} with {sensor}"},
    Phrase{"thermal_bending", "thermal bending of {axis} about {about} with {sensors}"},
    Phrase{"thermal_transient", "growth along {direction} while {sensor} changes"},
    Phrase{"time_drift", "steady drift along {direction}"},
    Phrase{"jump", "jump along {direction} at {at_s} s"},
    Phrase{"warm_up", "warm-up along {direction}"},
    Phrase{"time_cycle", "cycle in time along {direction}"},
    Phrase{"gravity_sag", "sag under gravity along {direction} with {with}"},
    Phrase{"probe_lobing", "probe lobing of order {order}"},
    Phrase{"probe_radius", "effective radius of the probe tip"},
    Phrase{"tip_wear", "wear of the probe tip"},
    Phrase{"ball_radius", "radius of ball {ball}"},
    Phrase{"artifact_position", "position of {feature}"},
    Phrase{"artifact_expansion", "expansion of the artifact with {sensor}"},
    Phrase{"rotary_zero", "zero of {joint}"},
    Phrase{"rotary_axis_offset", "offset of the axis of {joint} along {direction}"},
    Phrase{"rotary_axis_tilt", "tilt of the axis of {joint} about {about}"},
    Phrase{"rotary_eccentricity", "eccentricity of {joint}"},
    Phrase{"rotary_wobble", "wobble of {joint}"},
    Phrase{"covariate_offset", "offset along {direction} with {covariate}"},
    Phrase{"covariate_scale", "scale of {axis} with {covariate}"},
    Phrase{"thermal_network", "thermal network of {axis}"},
    Phrase{"profile", "profile along {direction} over {variable}"},
    Phrase{"profile", "profile along {direction} over {variables}"},
    Phrase{"formula", "{formula} along {direction}"},
};

std::string spaced(std::string text) {
  std::replace(text.begin(), text.end(), '_', ' ');
  return text;
}

std::string valueOf(const EffectSpec::Value& value) {
  std::string text;
  for (std::size_t i = 0; i < value.items.size(); ++i)
    text += (i == 0 ? "" : i + 1 == value.items.size() ? " and " : ", ") + value.items[i];
  return text;
}

/// The phrase with its keys put in; empty where one of them is not given.
std::string filled(const std::string& phrase, const EffectSpec& effect, std::set<std::string>& used) {
  std::string text;
  used.clear();
  for (std::size_t at = 0; at < phrase.size();) {
    const std::size_t open = phrase.find('{', at);
    if (open == std::string::npos) return text + phrase.substr(at);
    const std::size_t close = phrase.find('}', open);
    const std::string key = phrase.substr(open + 1, close - open - 1);
    const EffectSpec::Value* value = effect.find(key);
    if (value == nullptr || value->items.empty()) return {};
    text += phrase.substr(at, open - at) + valueOf(*value);
    used.insert(key);
    at = close + 1;
  }
  return text;
}

/// ", degree 3"; ", period 2 mm"; ", with lag"; nothing for what is false.
std::string keyInWords(const std::string& key, const EffectSpec::Value& value) {
  const std::string text = valueOf(value);
  if (text == "false" || text.empty()) return {};
  if (text == "true") return ", with " + spaced(key);
  if (key == "from_session") return ", from session " + text + " on";
  for (const std::string unit : {"mm", "deg", "um", "s"}) {
    const std::string ending = "_" + unit;
    if (key.size() <= ending.size() || key.compare(key.size() - ending.size(), ending.size(), ending) != 0)
      continue;
    const bool number = text.find_first_not_of("0123456789.eE+-") == std::string::npos;
    return ", " + spaced(key.substr(0, key.size() - ending.size())) + " " + text + (number ? " " + unit : "");
  }
  return ", " + spaced(key) + " " + text;
}

}  // namespace

std::string inWords(const EffectSpec& effect) {
  std::string text;
  std::set<std::string> used;
  for (const Phrase& phrase : kPhrases)
    if (effect.type == phrase.type && text.empty()) text = filled(phrase.words, effect, used);
  if (text.empty()) {
    used.clear();
    text = spaced(effect.type);
  }
  for (const auto& [key, value] : effect.keys)
    if (used.count(key) == 0) text += keyInWords(key, value);
  return text;
}

}  // namespace mm
