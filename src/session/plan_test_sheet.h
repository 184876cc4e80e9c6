#pragma once
#include <string>
#include <vector>

#include "base/units.h"
#include "machine/joint_units.h"
#include "session/plan_script.h"
#include "session/plan_tests.h"

namespace mm {

constexpr double kTestDwell = 5.0;      // s before a reading
constexpr double kBeyondStretch = 0.5;  // mm or deg beyond the ends: each is reached from its own side

/// One test on its machine, as its plan is written. SI units.
struct TestSheet {
  TestSheet(const PlanTest& test, const Machine& machine, const PlanTestSize& size);

  const PlanTest& test;
  const Machine& machine;
  PlanTestSize size;
  bool positionsSaid = false;  // by who asks for the plan
  std::string head;            // keys of the plan before its moves
  PlanScript script;           // its moves
  PlanScript::Readings middle;
  double rapid = 0.0, turning = 0.0;  // m/s and rad/s of the plan, between readings

  [[noreturn]] void refuse(const std::string& why) const;  ///< @throw InputError naming machine and test
  const Joint& joint(int j) const { return machine.joints()[static_cast<std::size_t>(j)]; }
  bool turns(int j) const { return joint(j).kind == JointKind::kRotary; }
  double unit(int j) const { return readingUnit(joint(j)).factor; }  ///< mm or deg
  double beyond(int j) const { return kBeyondStretch * unit(j); }    ///< m or rad
  double pace(int j) const { return turns(j) ? turning : rapid; }    ///< m/s or rad/s
  /// How many targets a line of that length (m) has: as said, else as usual, or more where it is long.
  /// @param line in words. @throw InputError where fewer are said than ISO 230-2 has.
  int targets(const std::string& line, double length) const;
  /// The middle, but one joint elsewhere.
  PlanScript::Readings with(int j, double reading) const;
  std::vector<int> rotaryJoints() const;  ///< refuses a machine without
  /// Linear joints of directions of their own, as X, Y, Z of the workpiece: three at most, `fewest` at least;
  /// a second axis of one direction stands still.
  std::vector<int> spatialJoints(std::size_t fewest) const;
  /// The highest speed that every joint of a kind has by its URDF, m/s or rad/s; usual ones where it has
  /// none.
  double slowest(JointKind kind) const;
};

/// Where a joint is measured: its travel, less a margin that leaves room beyond the ends. m or rad.
struct Stretch {
  double from = 0.0, to = 0.0;
  double at(double share) const { return from + share * (to - from); }  ///< of the way, 0 to 1
  double length() const { return to - from; }                           ///< m or rad
};

/// @throw InputError where the travel is too short.
Stretch stretchOf(const TestSheet& sheet, int joint);

// Each writes the moves of its test. All throw InputError where the machine cannot do it.

void writePositioning(TestSheet& t);  ///< ISO 230-2
void writeCircular(TestSheet& t);     ///< ISO 230-4
void writeRotation(TestSheet& t);     ///< ISO 230-7
void writeDiagonal(TestSheet& t);     ///< ISO 230-6
void writeLength(TestSheet& t);       ///< ISO 10360-2
void writeEtve(TestSheet& t);         ///< ISO 230-3, 5
void writeSpindle(TestSheet& t);      ///< ISO 230-3, 6
void writeLinear(TestSheet& t);       ///< ISO 230-3, 7
void writeRotary(TestSheet& t);       ///< ISO 230-3, 8

}  // namespace mm
