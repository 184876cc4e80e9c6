#include "uncatalogued.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <memory>

#include "base/erase_if.h"
#include "base/error.h"

namespace mm {
namespace {

using Along = UncataloguedKind::Along;

const UncataloguedKind& kindOf(const std::string& type) {
  for (const UncataloguedKind& kind : uncataloguedKinds())
    if (kind.type == type) return kind;
  throw InputError("'" + type + "' is not an uncatalogued source");
}

/// The axis of workpiece that is most nearly square to two joints.
std::string third(const HiddenSource& source, const Machine& machine, const Chain& chain) {
  const int first = machine.findJoint(source.key("axis")), second = machine.findJoint(source.key("across"));
  Eigen::Index component = 0;
  chain.axis(first).cross(chain.axis(second)).cwiseAbs().maxCoeff(&component);
  return std::string(1, static_cast<char>('x' + component));
}

std::string directionName(const UncataloguedKind& kind, const HiddenSource& source, const Machine& machine,
                          const Chain& chain) {
  switch (kind.along) {
    case Along::kOwnAxis:
      return source.key("axis");
    case Along::kDirection:
      return source.key("direction");
    case Along::kThird:
      return third(source, machine, chain);
    case Along::kApproach:
      break;
  }
  return "approach";
}

/// Puts the values of the keys where their names stand in brackets.
std::string filledIn(std::string text, const HiddenSource& source) {
  for (const auto& [key, value] : source.keys) {
    const std::string name = "[" + key + "]";
    const std::size_t at = text.find(name);
    if (at != std::string::npos) text.replace(at, name.size(), value);
  }
  return text;
}

void build(const UncataloguedKind& kind, const Making& m) {
  const HiddenSource& source = m.source;
  const Workshop& w = m.workshop;
  const std::vector<Condition>& visits = w.visits();
  if (visits.empty())
    throw InputError("'" + source.type + "' cannot be hidden in a plan that measures nothing");
  const auto setting = std::make_shared<const VisitedSetting>(source, w, visits);
  Quantity shape = [&kind, setting](const Condition& c) { return kind.shape({*setting, c}); };
  if (kind.qualified) shape = qualified(shape, setting->linearAxes, visits);
  const Spread spread = spreadOf(shape, visits);
  // Nearly constant: what little it varies would be blown up to the size asked for.
  constexpr double kRounding = 1e-12;  // of the shape, which is of order one
  if (!(spread.deviation > 0.05 * std::abs(spread.mean)) || !(spread.deviation > kRounding))
    throw SourceNotShown("'" + source.text() +
                         "' cannot be hidden: the plan does not vary what it depends on");
  const double factor = source.number("size") / spread.deviation;
  const Quantity error = [shape, factor, mean = spread.mean](const Condition& c) {
    return factor * (shape(c) - mean);
  };
  if (kind.along == Along::kApproach)  // the tip is farther on than it says
    return m.add([error, setting](const Instant& i, Distortion& d) {
      const Eigen::Vector3d motion = VisitedInstant(*setting, i.now).tipMotion();
      const double speed = motion.norm();
      if (speed > 0.0) d.tipShift += error(i.now) / speed * motion;
    });
  // a joint's own motion where a joint has that name, else the axis of workpiece
  const std::string name = directionName(kind, source, w.machine, w.chain);
  const Direction direction{w.machine.findJoint(name), name[0] - 'x'};
  m.add([error, direction](const Instant& i, Distortion& d) { direction.add(d, error(i.now)); });
}

/// Only a probe that is moving when it measures has a speed and a way by which it comes.
bool needsMotion(const UncataloguedKind& kind) {
  return kind.along == Along::kApproach ||
         std::any_of(kind.variables.begin(), kind.variables.end(), [](const std::string& name) {
           return name.find("speed") != std::string::npos || name.find("travel") != std::string::npos;
         });
}

}  // namespace

bool isUncatalogued(const std::string& type) { return type.rfind("uncatalogued_", 0) == 0; }

UncataloguedTruth uncataloguedTruth(const HiddenSource& source, const Machine& machine) {
  const UncataloguedKind& kind = kindOf(source.type);
  UncataloguedTruth truth;
  truth.cause = kind.cause;
  for (const std::string& name : kind.variables) truth.variables.push_back(filledIn(name, source));
  truth.direction = directionName(kind, source, machine, Chain(machine));
  return truth;
}

const std::vector<SourceKind>& judgedKinds() {
  static const std::vector<SourceKind> kinds = [] {
    std::vector<SourceKind> list = sourceKinds();
    eraseIf(list, [](const SourceKind& kind) { return kind.onlyByName; });  // what no effect explains
    for (const UncataloguedKind& kind : uncataloguedKinds()) {
      std::vector<SourceKind::NumberRule> numbers = {{"size", "m", 1e-6, 4e-6, true}};
      numbers.insert(numbers.end(), kind.shapeNumbers.begin(), kind.shapeNumbers.end());
      list.push_back({kind.type, kind.keys, numbers, [&kind](const Making& m) { build(kind, m); },
                      needsMotion(kind) ? SourceKind::Probe::kTouch : SourceKind::Probe::kAny, true});
    }
    return list;
  }();
  return kinds;
}

}  // namespace mm
