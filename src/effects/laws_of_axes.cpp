// Errors of a joint's reading, of a guideway and of what a member carries.
#include <algorithm>
#include <cmath>

#include "base/legendre.h"
#include "effects/covariate.h"
#include "effects/law.h"
#include "effects/quantity.h"
#include "effects/tilt.h"

namespace mm {
namespace {

/// Both keys name joints between which geometry couples the readings.
bool coupled(const EffectSpec& spec, const Domain& domain) {
  const std::string first = spec.text("axis"),
                    second = spec.text(spec.find("of") != nullptr ? "of" : "direction");
  const auto pairs = coupledJoints(domain);
  return std::find(pairs.begin(), pairs.end(), std::make_pair(first, second)) != pairs.end();
}

Law scale(SpecReader& read) {
  const int axis = read.joint("axis");
  const Joint& joint = read.jointAt(axis);
  Law law = oneTerm(Stage::kAxis, read.layout().axis(axis), slopeParameter("scale", joint.kind, joint.kind),
                    [axis](const State& s) { return s.position[axis]; });
  // A lead that is wrong is rarely wrong by the same everywhere.
  const EffectSpec further = EffectSpec("positioning_polynomial").set("axis", joint.name);
  law.freedom = {{EffectSpec(further).set("degree", 2)}, {EffectSpec(further).set("degree", 3)}};
  law.nature.mustMove = {axis};
  return law;
}

Law squareness(SpecReader& read) {
  const int axis = read.joint("axis"), of = read.joint("of");
  if (axis == of) read.fail("axis and of must be different joints; for an axis on itself use scale");
  Law law = oneTerm(Stage::kAxis, read.layout().axis(axis),
                    slopeParameter("slope", read.jointAt(axis).kind, read.jointAt(of).kind),
                    [of](const State& s) { return s.position[of]; });
  law.nature.choosesFrame = {0};
  law.nature.mustMove = {of};
  return law;
}

Law positioningPolynomial(SpecReader& read) {
  const int axis = read.joint("axis"), degree = read.integer("degree", 2, 5);
  const Joint& joint = read.jointAt(axis);
  const ScaledPosition scaled(read.domain(), axis);
  Law law = oneTerm(Stage::kAxis, read.layout().axis(axis), errorParameter("amplitude", joint.kind),
                    [degree, scaled](const State& s) { return legendre(degree, scaled(s)); });
  law.nature.shapeKeys = {"degree"};
  law.freedom = otherValues(read.canonical(), "degree", degree, 2, 5);
  // a lead that changes is rarely right on average
  law.freedom.push_back({EffectSpec("scale").set("axis", joint.name)});
  law.nature.mustMove = {axis};
  return law;
}

Law straightness(SpecReader& read) {
  const int axis = read.joint("axis");
  const Direction direction = read.direction("direction");
  if (direction.kind == Direction::Kind::kJoint && direction.index == axis)
    read.fail("axis and direction must differ; along the axis itself use positioning_polynomial");
  const int degree = read.integer("degree", 2, 5);
  const ScaledPosition scaled(read.domain(), axis);
  Law law = oneTerm(stageOf(direction), direction.slot(read.layout()),
                    errorParameter("amplitude", direction.quantity),
                    [degree, scaled](const State& s) { return legendre(degree, scaled(s)); });
  law.nature.shapeKeys = {"degree"};
  law.freedom = otherValues(read.canonical(), "degree", degree, 2, 5);
  law.nature.mustMove = {axis};
  return law;
}

constexpr double kPlace =
    0.3;  // of the Abbe offsets: from where a carriage turns to where the artifact stands

/// The size of half a step to either side by the direction of travel.
double halfByTravel(const State& s, int axis) {
  return s.travel[axis] == 0.0 ? kUnknown : -0.5 * s.travel[axis];
}

/// Further degrees; and a carriage turns about a place of its own, not about the origin: beside the angle
/// there is a displacement of the same degree in the directions across `about`.
std::vector<ShapeFreedom> besideAngle(const SpecReader& read, const std::string& axis, int about, int degree,
                                      int highest) {
  std::vector<ShapeFreedom> all = otherValues(read.canonical(), "degree", degree, 1, highest, 1);
  for (const Joint& joint : read.domain().joints) {
    if (!isAcross(joint, about)) continue;
    const bool own = joint.name == axis;
    EffectSpec shift(degree > 1 ? (own ? "positioning_polynomial" : "straightness")
                                : (own ? "scale" : "squareness"));
    shift.set("axis", degree > 1 ? axis : joint.name);
    if (!own) shift.set(degree > 1 ? "direction" : "of", degree > 1 ? joint.name : axis);
    if (degree > 1) shift.set("degree", degree);
    all.push_back({shift, kPlace});
  }
  return all;
}

constexpr int kHighestDegree = 5;

Law angularMotion(SpecReader& read) {
  const int axis = read.joint("axis"), about = read.axisOf("about"),
            degree = read.integer("degree", 1, kHighestDegree, 1);
  Law law;
  law.nature.stage = Stage::kVolume;
  law.parameters = {parameter("angle", kUnitArcsecond, kArcsecond, 0.02)};
  law.add = [layout = read.layout(), about, degree, scaled = ScaledPosition(read.domain(), axis)](
                const State& s, const double* p, ErrorSink& sink) {
    addTilt(layout, about, s, 0, p[0], legendre(degree, scaled(s)), sink);
  };
  law.nature.shapeKeys = {"degree"};
  law.freedom = besideAngle(read, read.jointAt(axis).name, about, degree, kHighestDegree);
  law.nature.mustMove = {axis};
  return law;
}

Law angularReversal(SpecReader& read) {
  const int axis = read.joint("axis", JointKind::kLinear), about = read.axisOf("about");
  Law law;
  law.nature.stage = Stage::kVolume;
  law.parameters = {parameter("angle", kUnitArcsecond, kArcsecond, 0.02)};
  law.add = [layout = read.layout(), axis, about](const State& s, const double* p, ErrorSink& sink) {
    addTilt(layout, about, s, 0, p[0], halfByTravel(s, axis), sink);
  };
  // it tips about a place of its own: what the arm from there makes is the same everywhere
  const std::string& own = read.jointAt(axis).name;
  for (const Joint& joint : read.domain().joints) {
    if (!isAcross(joint, about)) continue;
    EffectSpec step(joint.name == own ? "backlash" : "straightness_reversal");
    step.set("axis", own);
    if (joint.name != own) step.set("direction", joint.name);
    law.freedom.push_back({step, kPlace});
  }
  law.nature.met = 0.3;  // a play along the axis is met more often
  return law;
}

Law straightnessReversal(SpecReader& read) {
  const int axis = read.joint("axis", JointKind::kLinear);
  const Direction direction = read.direction("direction");
  if (direction.kind == Direction::Kind::kJoint && direction.index == axis)
    read.fail("axis and direction must differ; along the axis itself use backlash");
  Law law =
      oneTerm(stageOf(direction), direction.slot(read.layout()), errorParameter("step", direction.quantity),
              [axis](const State& s) { return halfByTravel(s, axis); });
  law.nature.met = 0.3;  // a play along the axis is met more often
  return law;
}

Law backlash(SpecReader& read) {
  const int axis = read.joint("axis");
  Law law = oneTerm(Stage::kAxis, read.layout().axis(axis), errorParameter("gap", read.jointAt(axis).kind),
                    [axis](const State& s) { return halfByTravel(s, axis); });
  law.nature.variesAlong = {axis};  // a nut wears most where it works most: the play changes along the screw
  law.nature.variesInTime = true;   // and it loosens, or warms
  return law;
}

Law lostMotion(SpecReader& read) {
  constexpr int kShortest = -5, kLongest = -2;  // powers of two, of the range
  constexpr double kOther = 0.4;                // share of what is lost over another distance
  const int axis = read.joint("axis"), slot = read.layout().axis(axis);
  const Joint& joint = read.jointAt(axis);
  const bool linear = joint.kind == JointKind::kLinear;
  const double observed = observedRange(read.domain(), axis);
  const double range = observed > 0.0 ? observed : linear ? 10.0 * kMillimetre : 10.0 * kDegree;
  Parameter distance =
      parameter("distance", linear ? kUnitMillimetre : kUnitDegree, 0.1 * range, 10.0 * range, 0.1 * range);
  distance.minimum = 0.0;
  distance.maximum = range;  // what is lost evenly over more is a play and a scale
  Law law;
  law.parameters = {errorParameter("gap", joint.kind), errorParameter("at_once", joint.kind), distance};
  law.add = [axis, slot](const State& s, const double* p, ErrorSink& sink) {
    const double travel = s.travel[axis], way = s.sinceReversalOf(axis), over = p[2];
    const double side = travel == 0.0 ? kUnknown : -0.5 * travel;
    const double left = over > 0.0 ? std::exp(-way / over) : way > 0.0 ? 0.0 : 1.0;
    sink.add(slot, 0, p[0], side * (1.0 - left));
    sink.add(slot, 1, p[1], side * left);
    if (!sink.wantsDerivatives()) return;
    const bool changes = over > 0.0 && left > 0.0;  // infinitely far away nothing does
    sink.derivative(slot, 2, changes ? side * (p[1] - p[0]) * left * way / (over * over) : 0.0 * side);
  };
  law.nature.secondPartOfFirst = true;  // what is lost at once, of the gap
  for (int k = kShortest; k <= kLongest; ++k) law.starts.push_back(std::ldexp(range, k));
  // over less the session saw a play, over more hardly a bend: a play and a scale
  law.shortest = std::ldexp(range, kShortest - 1);
  law.longest = std::ldexp(range, kLongest + 1);
  law.beside = {{0.5, kOther}, {2.0, kOther}};  // no drive winds up by one exponential
  law.nature.met = 0.3;                         // a play is met more often
  return law;
}

Law speedLag(SpecReader& read) {
  const ErrorLayout layout = read.layout();
  std::vector<char> moved;
  for (int j = 0; j < layout.joints(); ++j) moved.push_back(observedRange(read.domain(), j) > 0.0);
  Law law;
  law.parameters = {parameter("delay", {"ms", 1e3}, 1e-3, 1.0)};
  law.parameters[0].seldomNegative = true;
  law.add = [layout, moved](const State& s, const double* p, ErrorSink& sink) {
    for (int j = 0; j < layout.joints(); ++j) {
      const double velocity = s.velocity[j];
      // a joint that the session never moved stands still, also where its velocity was not logged
      sink.add(layout.axis(j), 0, p[0], std::isnan(velocity) && !moved[j] ? 0.0 : -velocity);
    }
  };
  law.nature.met = 0.3;  // most controllers latch in hardware
  return law;
}

Law gravitySag(SpecReader& read) {
  const Direction direction = read.direction("direction");
  const int with = read.joint("with", JointKind::kLinear);
  if (direction.quantity != JointKind::kLinear)
    read.fail("direction must be the vertical, not a rotary joint");
  const int power = read.integer("power", 2, 3);
  const Domain& domain = read.domain();
  const double lower = with < static_cast<int>(domain.lower.size()) ? domain.lower[with] : 0.0;
  const double observed = observedRange(domain, with);
  const double reach = std::pow(observed > 0.0 ? observed : 0.1, power);
  Law law = oneTerm(stageOf(direction), direction.slot(read.layout()),
                    parameter("sag", {"um/m^" + std::to_string(power), 1e6}, 1e-6 / reach, 1e-3 / reach),
                    [with, power, lower](const State& s) {
                      const double extension = s.position[with] - lower;
                      return power == 2 ? extension * extension : extension * extension * extension;
                    });
  law.nature.shapeKeys = {"power"};
  law.freedom = otherValues(read.canonical(), "power", power, 2, 3);
  law.nature.mustMove = {with};
  return law;
}

/// The vertical is the joint z, else z of the workpiece.
bool hasVertical(const EffectSpec&, const Domain& domain) {
  const int z = domain.findJoint("z");
  return z < 0 || domain.joints[z].kind == JointKind::kLinear;
}

/// A covariate rarely acts evenly along an axis: a load bends it where it stands.
/// At which value a logged quantity does nothing is not known: what it does at all times is as much as what
/// it does over its range in the session.
constexpr double kZeroOfQuantity = 1.0;

Law covariateScale(SpecReader& read) {
  const int axis = read.joint("axis"), covariate = read.covariate("covariate");
  const Joint& joint = read.jointAt(axis);
  const double reference = covariateReference(read.domain(), covariate),
               range = covariateRange(read.domain(), covariate);
  Law law = oneTerm(Stage::kAxis, read.layout().axis(axis),
                    parameter("slope", errorUnit(joint.kind) / readingUnit(joint.kind) / Unit{"unit", 1.0},
                              1e-4 / range, 0.02 / range),
                    [axis, covariate, reference](const State& s) {
                      return s.position[axis] * (s.covariate[covariate] - reference);
                    });
  law.nature.variesAlong = law.nature.mustMove = {axis};
  law.freedom.push_back({EffectSpec("scale").set("axis", joint.name), kZeroOfQuantity});
  return law;
}

Law covariateOffset(SpecReader& read) {
  const Direction direction = read.direction("direction");
  const int covariate = read.covariate("covariate");
  const double reference = covariateReference(read.domain(), covariate),
               range = covariateRange(read.domain(), covariate);
  const Parameter whole = errorParameter("slope", direction.quantity);
  return oneTerm(stageOf(direction), direction.slot(read.layout()),
                 parameter("slope", errorUnit(direction.quantity) / Unit{"unit", 1.0}, whole.scale / range,
                           whole.bound / range),
                 [covariate, reference](const State& s) { return s.covariate[covariate] - reference; });
}

}  // namespace

std::vector<LawRow> lawsOfAxes() {
  return {
      {"scale", {"axis"}, {joints("axis")}, {}, scale},
      {"squareness", {"axis", "of"}, {joints("axis"), joints("of")}, coupled, squareness},
      {"positioning_polynomial",
       {"axis", "degree"},
       {joints("axis"), numbers("degree", 2, 5)},
       {},
       positioningPolynomial},
      {"straightness",
       {"axis", "direction", "degree"},
       {joints("axis"), joints("direction"), numbers("degree", 2, 5)},
       coupled,
       straightness},
      {"angular_motion",
       {"axis", "about", "degree"},
       {joints("axis", JointKind::kLinear), fixed("about", {"x", "y", "z"}),
        numbers("degree", 1, kHighestDegree, 1)},
       {},
       angularMotion},
      {"angular_reversal",
       {"axis", "about"},
       {joints("axis", JointKind::kLinear), fixed("about", {"x", "y", "z"})},
       {},
       angularReversal},
      {"straightness_reversal",
       {"axis", "direction"},
       {joints("axis", JointKind::kLinear), joints("direction")},
       coupled,
       straightnessReversal},
      {"backlash", {"axis"}, {joints("axis")}, {}, backlash},
      {"lost_motion", {"axis"}, {joints("axis")}, {}, lostMotion},
      {"speed_lag", {}, {}, {}, speedLag},
      {"gravity_sag",
       {"direction", "with", "power"},
       {fixed("direction", {"z"}), joints("with", JointKind::kLinear), numbers("power", 2, 3)},
       hasVertical,
       gravitySag},
      {"covariate_offset", {"direction", "covariate"}, {directions(), covariates()}, {}, covariateOffset},
      {"covariate_scale", {"axis", "covariate"}, {joints("axis"), covariates()}, {}, covariateScale},
  };
}

}  // namespace mm
