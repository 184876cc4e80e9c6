#include "session/plan_tests.h"

#include "base/error.h"
#include "base/format.h"
#include "base/names_of.h"
#include "base/nearest_name.h"
#include "session/plan_test_sheet.h"

namespace mm {
namespace {

/// A size as said, or as usual; refused where the test has none.
template <typename Number>
Number sized(const PlanTest& test, const char* option, Number said, Number usual) {
  if (said != 0 && usual == 0) throw InputError(std::string(option) + ": --test " + test.name + " has none");
  return said != 0 ? said : usual;
}

PlanTestSize sizeOf(const PlanTest& test, const PlanTestSize& said) {
  const PlanTestSize& usual = test.usual;
  const PlanTestSize size{sized(test, "--positions", said.positions, usual.positions),
                          sized(test, "--runs", said.runs, usual.runs),
                          sized(test, "--hours", said.hours, usual.hours),
                          sized(test, "--every-min", said.everyMin, usual.everyMin)};
  if (size.positions < test.fewest)
    throw InputError(format("--positions: is %d, but --test %s needs %d or more", size.positions,
                            test.name.c_str(), test.fewest));
  return size;
}

}  // namespace

const std::vector<PlanTest>& planTests() {
  static const std::vector<PlanTest> kTests = {
      {"positioning",
       "ISO 230-2: positioning of each axis",
       "an interferometer along each linear axis; a polygon and an autocollimator at each rotary one",
       {11, 5, 0.0, 0.0},
       writePositioning,
       5},
      {"etve",
       "ISO 230-3, 5: environmental temperature variation error",
       "displacement sensors at one place",
       {0, 0, 24.0, 5.0},
       writeEtve},
      {"spindle",
       "ISO 230-3, 6: thermal distortion by a rotating spindle",
       "displacement sensors at a mandrel; the speed of the spindle as a covariate in rpm",
       {0, 0, 4.0, 5.0},
       writeSpindle},
      {"linear",
       "ISO 230-3, 7: thermal distortion by moving linear axes",
       "an interferometer or a linear comparator along each linear axis",
       {0, 0, 4.0, 5.0},
       writeLinear},
      {"rotary",
       "ISO 230-3, 8: thermal distortion by moving rotary axes",
       "displacement sensors at one place",
       {0, 0, 4.0, 5.0},
       writeRotary},
      {"circular",
       "static readings on circles in both senses, evaluated as ISO 230-4; no servo errors",
       "a grid encoder or a tracker",
       {36, 1, 0.0, 0.0},
       writeCircular,
       12},
      {"diagonal",
       "ISO 230-6: body and face diagonals",
       "an interferometer along each diagonal",
       {11, 5, 0.0, 0.0},
       writeDiagonal,
       5},
      {"rotation",
       "ISO 230-7: error motion of each rotary axis",
       "displacement sensors at a ball, or a tracker",
       {25, 3, 0.0, 0.0},
       writeRotation,
       12},
      {"length",
       "ISO 10360-2: five lengths in seven positions, each end from outside",
       "an interferometer or a gauge along each line",
       {0, 3, 0.0, 0.0},
       writeLength},
  };
  return kTests;
}

std::string testPlan(const std::string& test, const PlanTestSize& said, const Machine& machine,
                     const std::string& name) {
  for (const PlanTest& one : planTests()) {
    if (one.name != test) continue;
    TestSheet sheet(one, machine, sizeOf(one, said));
    sheet.positionsSaid = said.positions != 0;
    one.write(sheet);
    return "# " + one.standard + ". Needs " + one.needs + ".\nname: " + name + "\n" +
           format("speeds: {rapid_mm_s: %.6g, rapid_deg_s: %.6g}\n", sheet.rapid / kMillimetre,
                  sheet.turning / kDegree) +
           sheet.head + sheet.script.yaml();
  }
  throw InputError("--test: '" + test + "' is not among " + listOf(allNames(planTests())));
}

}  // namespace mm
