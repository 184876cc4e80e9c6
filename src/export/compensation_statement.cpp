#include "export/compensation_statement.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "base/format.h"
#include "base/quantity_words.h"
#include "base/text.h"
#include "effects/effect_words.h"
#include "effects/inputs.h"
#include "effects/iso230_symbol.h"
#include "effects/registry.h"
#include "machine/joint_units.h"

namespace mm {
namespace {

constexpr const char* kOtherErrors = "errors that depend on more than the position of one axis";

/// The kinds of errors that are compensated, in the order in which they are told.
constexpr const char* kErrorKinds[] = {"positioning errors of linear axes",
                                       "straightness errors of linear axes",
                                       "angular errors of linear axes",
                                       "squareness errors between linear axes",
                                       "positioning errors of rotary axes",
                                       "error motions of rotary axes",
                                       "errors of position and orientation of rotary axes",
                                       kOtherErrors};

std::string errorKind(const std::string& symbol) {
  if (symbol.size() < 3) return kOtherErrors;
  const bool place = symbol[1] == '0';
  const char axis = symbol[2], direction = place ? symbol[0] : symbol[1];
  const std::string linear = "XYZUVWPQR", rotary = "ABC";
  const std::size_t ofAxis = linear.find(axis);
  if (ofAxis == std::string::npos)
    return place ? kErrorKinds[6] : direction == axis ? kErrorKinds[4] : kErrorKinds[5];
  if (place) return kErrorKinds[3];
  if (rotary.find(direction) != std::string::npos) return kErrorKinds[2];
  return linear.find(direction) == ofAxis % 3 ? kErrorKinds[0] : kErrorKinds[1];
}

std::string kindsText(const std::vector<EffectSpec>& compensated, const ErrorSymbols& symbols) {
  std::map<std::string, std::vector<std::string>> byKind;
  for (const EffectSpec& effect : compensated) {
    const std::string symbol = symbols.of(effect), told = symbol.empty() ? inWords(effect) : symbol;
    std::vector<std::string>& list = byKind[errorKind(symbol)];
    if (std::find(list.begin(), list.end(), told) == list.end()) list.push_back(told);
  }
  std::string text;
  for (const char* kind : kErrorKinds)
    if (const auto found = byKind.find(kind); found != byKind.end())
      text += (text.empty() ? "" : "; ") + std::string(kind) + " (" + joined(found->second, ", ") + ")";
  return text.empty() ? "none" : text;
}

std::string nameOfAxis(const Machine& machine, const std::vector<Iso230Axis>& axes, std::size_t joint) {
  const std::string& name = axes[joint].name;
  return name.empty() ? machine.joints()[joint].name : name;
}

std::string chainText(const Machine& machine, const std::vector<Iso230Axis>& axes) {
  std::string text = kinematicChain(machine) + " (w workpiece, b bed, t probe)", otherwise;
  for (std::size_t j = 0; j < axes.size(); ++j) {
    const std::string& joint = machine.joints()[j].name;
    const std::string letter = lower(axes[j].name);
    if (!letter.empty() && letter != joint)
      otherwise += (otherwise.empty() ? "; joint " : ", ") + joint + " is " + axes[j].name;
  }
  return text + otherwise;
}

std::string directionsText(const Calibration& c, const std::vector<EffectSpec>& compensated,
                           const Machine& machine, const std::vector<Iso230Axis>& axes) {
  std::set<int> both;
  for (const EffectSpec& effect : compensated) {
    const Inputs in = inputsOf(*createEffect(effect, c.domain), c.domain);
    both.insert(in.travels.begin(), in.travels.end());
    both.insert(in.reversals.begin(), in.reversals.end());
  }
  std::vector<std::string> uni, bi;
  for (std::size_t j = 0; j < axes.size(); ++j)
    (both.count(j) > 0 ? bi : uni).push_back(nameOfAxis(machine, axes, j));
  std::string text = bi.empty() ? "" : "bidirectional: " + joined(bi, ", ");
  if (!uni.empty())
    text += (text.empty() ? "" : "; ") +
            std::string("unidirectional, one value for both directions of travel: ") + joined(uni, ", ");
  return text;
}

std::string squarenessText(const Calibration& c, const std::vector<EffectSpec>& compensated,
                           const ErrorSymbols& symbols) {
  std::string text;
  for (const Calibration::Value& v : c.values) {
    const EffectSpec& effect = c.effects[v.effect];
    const int sign = symbols.squarenessSign(effect);
    if (sign == 0 || std::find(compensated.begin(), compensated.end(), effect) == compensated.end()) continue;
    text += (text.empty() ? "" : "; ") + symbols.of(effect) + " = " +
            withFactor(expanded(sign * v.value * v.toUnit, v.std * std::abs(v.toUnit), v.unit));
  }
  if (text.empty()) return "none is compensated";
  return text +
         ". Positive: the axis is turned right-handed about the direction that the symbol begins with (C: +Z "
         "of the workpiece), actual minus nominal; the compensation takes it away";
}

std::string volumeText(const Calibration& c, const Machine& machine, const std::vector<Iso230Axis>& axes) {
  std::vector<std::string> ranges;
  const Domain& d = c.domain;
  for (std::size_t j = 0; j < axes.size(); ++j) {
    const JointUnit unit = readingUnit(machine.joints()[j]);
    ranges.push_back(nameOfAxis(machine, axes, j) +
                     format(" %.4g to %.4g ", d.lower[j] / unit.factor, d.upper[j] / unit.factor) +
                     unit.symbol);
  }
  for (std::size_t s = 0; s < d.sensors.size(); ++s)
    if (std::isfinite(d.sensorLower[s]))
      ranges.push_back("temperature " + d.sensors[s] +
                       format(" %.4g to %.4g degC", d.sensorLower[s], d.sensorUpper[s]));
  return joined(ranges, ", ");
}

}  // namespace

std::vector<CompensationFact> compensationFacts(const Calibration& c,
                                                const std::vector<EffectSpec>& compensated) {
  const Machine machine(c.urdf, c.machineName);
  const ErrorSymbols symbols(machine);
  const std::vector<Iso230Axis> axes = iso230Axes(machine);
  return {{"Errors compensated", kindsText(compensated, symbols)},
          {"Kinematic chain", chainText(machine, axes)},
          {"Directions of travel", directionsText(c, compensated, machine, axes)},
          {"Squareness", squarenessText(c, compensated, symbols)},
          {"Compensated volume", volumeText(c, machine, axes)}};
}

}  // namespace mm
