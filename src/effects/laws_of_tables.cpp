// Tables: one value for each of some positions of a joint, linear between them, constant beyond.
#include <algorithm>
#include <cmath>

#include "effects/law.h"
#include "effects/quantity.h"

namespace mm {
namespace {

constexpr int kMostKnots = 64;
constexpr int kFewest = 3;  // of straightness: the two ends, and one between them

/// Calls `add(knot, share)` for the one or two positions (m or rad, ascending, at least one) whose values,
/// times their shares, sum to the table's value at q.
template <typename Add>
void atKnots(const std::vector<double>& positions, double q, const Add& add) {
  const int count = static_cast<int>(positions.size());
  if (std::isnan(q)) {  // what is not known stays so
    for (int i = 0; i < count; ++i) add(i, q);
    return;
  }
  const auto after = std::upper_bound(positions.begin(), positions.end(), q);
  const int i = static_cast<int>(after - positions.begin());
  if (i == 0) return add(0, 1.0);
  if (i == count) return add(i - 1, 1.0);
  const double share = (q - positions[i - 1]) / (positions[i] - positions[i - 1]);
  add(i - 1, 1.0 - share);
  add(i, share);
}

/// Names of the values at these positions, each once: at_-12.5mm, at_90deg.
std::vector<std::string> namesAt(const std::vector<double>& positions, JointKind kind) {
  constexpr double kShown = 1e-4, kPerShown = 1e4;  // mm or deg: positions are distinct from 1 um on
  const bool linear = kind == JointKind::kLinear;
  std::vector<std::string> names;
  for (const double position : positions) {
    EffectSpec text;
    text.set("at", kShown * std::round(kPerShown * position / (linear ? kMillimetre : kDegree)));
    names.push_back("at_" + text.text("at") + (linear ? "mm" : "deg"));
  }
  for (std::size_t i = 1; i < names.size(); ++i)
    if (names[i] == names[i - 1]) names[i] += "_" + std::to_string(i);
  return names;
}

std::vector<double> measuredPositions(const Domain& domain, int axis) {
  const auto j = static_cast<std::size_t>(axis);
  return j < domain.positions.size() ? domain.positions[j] : std::vector<double>();
}

Law positionTable(SpecReader& read) {
  const int axis = read.joint("axis"), slot = read.layout().axis(axis);
  const Joint& joint = read.jointAt(axis);
  const std::vector<double> positions = measuredPositions(read.domain(), axis);
  if (positions.size() < 2)
    read.fail("a table needs 2 to 64 distinct measured positions of " + joint.name + ", and there are " +
              (positions.empty() ? std::string("more (or none); use positioning_polynomial")
                                 : std::string("fewer")));
  Law law;
  for (const std::string& name : namesAt(positions, joint.kind)) {
    law.nature.choosesFrame.push_back(static_cast<int>(law.parameters.size()));
    law.parameters.push_back(errorParameter(name, joint.kind));
  }
  law.add = [=](const State& s, const double* p, ErrorSink& sink) {
    atKnots(positions, s.position[axis],
            [&](int knot, double share) { sink.add(slot, knot, p[knot], share); });
  };
  law.nature.composite = true;
  law.nature.mustMove = {axis};
  return law;
}

/// The measured positions, or as many as asked for, evenly over the travel that the session covered.
std::vector<double> knotsOf(SpecReader& read, int axis) {
  const Domain& domain = read.domain();
  const int count = read.integer("knots", kFewest, kMostKnots, 0);
  std::vector<double> positions = measuredPositions(domain, axis);
  if (count == 0 && positions.size() >= kFewest) return positions;
  if (count == 0)
    read.fail("without 'knots' a table needs 3 to 64 distinct measured positions of " +
              read.jointAt(axis).name + ", and there are " +
              (positions.empty() ? "more (or none); add for example knots: 9" : "fewer"));
  const double range = observedRange(domain, axis);
  if (!(range > 0.0)) read.fail(read.jointAt(axis).name + " never moved; measure over its travel");
  positions.clear();
  for (int i = 0; i < count; ++i)
    positions.push_back(domain.lower[static_cast<std::size_t>(axis)] + range * i / (count - 1));
  return positions;
}

/// Deviation of the axis along another direction from the straight line through the first and the last knot
/// (ISO 230-1, end-point reference straight line): offset belongs to the datum, slope to squareness.
Law straightnessTable(SpecReader& read) {
  const int axis = read.joint("axis");
  const Direction direction = read.direction("direction");
  if (direction.kind == Direction::Kind::kJoint && direction.index == axis)
    read.fail("axis and direction must differ; along the axis itself use position_table");
  const std::vector<double> positions = knotsOf(read, axis);
  const int last = static_cast<int>(positions.size()) - 1;
  const std::vector<std::string> names = namesAt(positions, read.jointAt(axis).kind);
  Law law;
  law.nature.stage = stageOf(direction);
  for (int knot = 1; knot < last; ++knot)
    law.parameters.push_back(errorParameter(names[knot], direction.quantity));
  law.add = [=, slot = direction.slot(read.layout())](const State& s, const double* p, ErrorSink& sink) {
    atKnots(positions, s.position[axis], [&](int knot, double share) {
      if (knot > 0 && knot < last) sink.add(slot, knot - 1, p[knot - 1], share);
    });
  };
  law.nature.composite = true;
  law.nature.shapeKeys = {"knots"};
  law.nature.mustMove = {axis};
  law.nature.positionsNeeded = last + 1;
  return law;
}

}  // namespace

std::vector<LawRow> lawsOfTables() {
  const EffectSpec position("position_table"), straightness("straightness_table");
  LawRow ofPositions =
      compositeRow({"axis"}, positionTable,
                   {EffectSpec(position).set("axis", "x"), EffectSpec(position).set("axis", "b")});
  ofPositions.valueOfEachPosition = true;
  return {
      std::move(ofPositions),
      compositeRow({"axis", "direction", "knots"}, straightnessTable,
                   {EffectSpec(straightness).set("axis", "x").set("direction", "y"),
                    EffectSpec(straightness).set("axis", "a").set("direction", "b")}),
  };
}

}  // namespace mm
