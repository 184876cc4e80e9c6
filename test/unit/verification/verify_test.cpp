#include "verification/verify.h"

#include <gtest/gtest.h>

#include "loaded_controller.h"
#include "verdict_tally.h"

namespace mm {
namespace {

using namespace test;  // NOLINT: helpers of this test alone

int runs() { return mm_test::longTests() ? 100 : 8; }

TEST(Verify, saysRightlyWhatWasLoadedHow) {
  VerdictTally helped("helped"), notLoaded("not loaded"), wrongSign("wrong sign"),
      exchanged("tables of x and y exchanged"), columns("corrections of y and z exchanged"),
      drifted("drifted since"), raw("raw readings, it helps");
  for (int run = 0; run < runs(); ++run) {
    const std::uint64_t seed = firstSeed(1000) + 10 * static_cast<std::uint64_t>(run);
    const std::string rough = roughOf(static_cast<std::uint64_t>(run));
    const LoadedController controller(seed, rough);
    const auto judged = [&](int i, const ControllerAdds& adds, const std::vector<std::string>& errors,
                            bool loaded) {
      return controller.judge(controller.measure(seed + static_cast<std::uint64_t>(i), adds, rough, errors),
                              loaded);
    };
    const ControllerAdds& adds = controller.adds;
    helped.add(seed, judged(1, adds, loadedErrors(), true), {VerifyVerdict::kHelped}, "corrected", false);
    const Verification none = judged(2, {}, loadedErrors(), true);
    notLoaded.add(seed, none, {VerifyVerdict::kNoChange}, "not_corrected", false);
    wrongSign.add(seed, judged(3, toTheOtherSide(adds, {0, 1, 2}), loadedErrors(), true),
                  {VerifyVerdict::kWorse}, "wrong_sign", false, "the errors rose");
    const Verification tables = judged(4, withExchanged(adds, 0, 1, true), loadedErrors(), true);
    exchanged.add(seed, tables, rightFor(tables.after, none.after), "exchanged", false,
                  "x and y have each other's table");
    const Verification others = judged(5, withExchanged(adds, 1, 2, false), loadedErrors(), true);
    columns.add(seed, others, rightFor(others.after, none.after), "exchanged", false,
                "y and z have each other's correction");
    // Seven kelvins warmer, and the screw of x has worn.
    const Verification later = judged(6, adds, loadedErrors(5.0, 80.0), true);
    drifted.add(seed, later, {VerifyVerdict::kMixed}, "corrected", true, "changed since the calibration");
    for (const ChangedEffect& c : later.changed)
      if (c.effect == EffectSpec("backlash").set("axis", "x")) {
        EXPECT_NEAR(c.parameters[0].change, 2.0, 4.0 * c.parameters[0].std + 0.1) << later.inWords;
      }
    raw.add(seed, judged(7, {}, loadedErrors(), false), {VerifyVerdict::kHelped}, "corrected", false);
  }
  // One in a thousand by chance.
  EXPECT_LE(helped.qualified() + raw.qualified(), 1);
}

}  // namespace
}  // namespace mm
