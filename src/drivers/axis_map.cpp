#include "drivers/axis_map.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <sstream>

#include "base/error.h"
#include "base/number_text.h"
#include "base/text.h"
#include "base/units.h"

namespace mm {
namespace {

std::map<std::string, std::string> pairsOf(const ControllerSetup& setup, const std::string& name) {
  std::map<std::string, std::string> pairs;
  const auto found = setup.parameters.find(name);
  if (found == setup.parameters.end()) return pairs;
  std::istringstream in(found->second);
  for (std::string word; in >> word;) {
    const std::size_t colon = word.find(':');
    if (colon == std::string::npos || colon == 0 || colon + 1 == word.size())
      throw InputError("parameter '" + name + "' of the controller: '" + word + "' is not <joint>:<value>");
    const std::string joint = word.substr(0, colon);
    if (std::none_of(setup.axes.begin(), setup.axes.end(), [&](const auto& a) { return a.name == joint; }))
      throw InputError("parameter '" + name + "' of the controller: the machine has no joint '" + joint +
                       "'");
    if (!pairs.emplace(joint, word.substr(colon + 1)).second)
      throw InputError("parameter '" + name + "' of the controller names joint '" + joint + "' twice");
  }
  return pairs;
}

double valueOf(const std::string& parameter, const std::string& text) {
  std::istringstream in(text);
  double value = 0.0;
  if (!(in >> value) || !(in >> std::ws).eof() || !std::isfinite(value))
    throw InputError("parameter '" + parameter + "' of the controller: '" + text + "' is not a number");
  return value;
}

}  // namespace

AxisMap::AxisMap(const ControllerSetup& setup, const std::string& letters) {
  const auto chosen = pairsOf(setup, "axes");
  const auto signs = pairsOf(setup, "sign"), zeros = pairsOf(setup, "zero");
  for (const ControllerAxis& axis : setup.axes) {
    std::string letter = axis.name;
    if (!chosen.empty()) {
      const auto found = chosen.find(axis.name);
      if (found == chosen.end()) continue;
      letter = found->second;
    }
    if (letter.size() == 1)
      letter[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(letter[0])));
    const std::size_t place = letter.size() == 1 ? letters.find(letter[0]) : std::string::npos;
    if (place == std::string::npos)
      throw InputError("joint '" + axis.name + "': '" + letter +
                       "' is not an axis of this controller, which has " + letters +
                       "; name it in the parameter 'axes', as in x:X y:Y");
    if (std::count(places_.begin(), places_.end(), place) > 0)
      throw InputError("axis " + letter + " of the controller moves two joints, the second is '" + axis.name +
                       "'");
    axes_.push_back(axis);
    names_.push_back(axis.name);
    letters_.push_back(letter[0]);
    places_.push_back(place);
    units_.push_back(axis.rotary ? kDegree : kMillimetre);
    const auto sign = signs.find(axis.name);
    const double side = sign == signs.end() ? 1.0 : valueOf("sign", sign->second);
    if (side != 1.0 && side != -1.0)
      throw InputError("parameter 'sign' of the controller: the sign of '" + axis.name + "' must be 1 or -1");
    signs_.push_back(static_cast<int>(side));
    const auto zero = zeros.find(axis.name);
    zeros_.push_back(zero == zeros.end() ? 0.0 : valueOf("zero", zero->second));
  }
  if (axes_.empty())
    throw InputError("the controller moves no joint of the machine; see its parameter 'axes'");
}

double AxisMap::toJoint(std::size_t j, double control) const {
  return signs_[j] * (control - zeros_[j]) * units_[j];
}

double AxisMap::toControl(std::size_t j, double joint) const {
  return zeros_[j] + signs_[j] * joint / units_[j];
}

std::size_t AxisMap::needed() const { return 1 + *std::max_element(places_.begin(), places_.end()); }

double numberParameterOf(const ControllerSetup& setup, const std::string& name, double standard, double lower,
                         double upper) {
  const auto found = setup.parameters.find(name);
  if (found == setup.parameters.end()) return standard;
  const double value = valueOf(name, found->second);
  if (!(value >= lower && value <= upper))
    throw InputError("parameter '" + name + "' of the controller is " + found->second + "; it must be from " +
                     numberText(lower) + " to " + numberText(upper));
  return value;
}

std::string textParameterOf(const ControllerSetup& setup, const std::string& name,
                            const std::string& standard) {
  const auto found = setup.parameters.find(name);
  return found == setup.parameters.end() ? standard : found->second;
}

void refuseUnknownParametersOf(const ControllerSetup& setup, const std::string& controller,
                               const std::vector<std::string>& known) {
  for (const auto& [name, value] : setup.parameters)
    if (std::count(known.begin(), known.end(), name) == 0)
      throw InputError("parameter '" + name + "' is not known to the " + controller +
                       " controller; possible are " + joined(known, ", "));
}

ProbeEdge seenEdge(const AxesState& state, bool closed, double period) {
  ProbeEdge edge;
  edge.time = state.time;
  edge.timeUncertainty = period + state.timeUncertainty;
  edge.closed = closed;
  edge.motion = state.motion;
  return edge;
}

}  // namespace mm
