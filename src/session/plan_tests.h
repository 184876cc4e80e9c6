#pragma once
#include <string>
#include <vector>

#include "machine/machine.h"

namespace mm {

/// How much a test measures. 0: not said, or nothing that the test has.
struct PlanTestSize {
  int positions = 0;      // targets of a line, points or steps of a turn
  int runs = 0;           // how often they are measured, in each direction
  double hours = 0.0;     // h of load, or of waiting
  double everyMin = 0.0;  // min between readings
};

struct TestSheet;

/// A test of a standard, which an independent instrument measures.
struct PlanTest {
  std::string name;           // of `mm plan new --test`
  std::string standard;       // "ISO 230-3, 5: environmental temperature variation error"
  std::string needs;          // the instrument
  PlanTestSize usual;         // what it has, and how much of it unless said otherwise
  void (*write)(TestSheet&);  // its moves
  int fewest = 0;             // positions
};

/// Those that `testPlan` knows, by standard.
const std::vector<PlanTest>& planTests();

/// The plan of a test as YAML, within the travels of a machine; other joints stand in the middle.
/// @param test a name of planTests(). @param size what is said of it; 0: as usual. @param name of the plan.
/// @throw InputError where the machine lacks the axes or the travel, or a size is not one of the test.
std::string testPlan(const std::string& test, const PlanTestSize& size, const Machine& machine,
                     const std::string& name);

}  // namespace mm
