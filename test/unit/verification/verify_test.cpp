#include "verification/verify.h"

#include <gtest/gtest.h>

#include <cmath>
#include <iostream>

#include "loaded_controller.h"
#include "long_tests.h"

namespace mm {
namespace {

using namespace test;  // NOLINT: helpers of this test alone

/// What was said in so many runs, and what was not as it should be.
class Tally {
 public:
  explicit Tally(std::string what) : what_(std::move(what)) {}
  void add(std::uint64_t seed, const Verification& v, VerifyVerdict verdict, const std::string& finding,
           bool drifted) {
    ++runs_;
    if (v.verdict == verdict && v.finding == finding && v.drifted == drifted) {
      ++right_;
      if (v.rivals.empty()) ++certain_;
      return;
    }
    ADD_FAILURE() << what_ << ", seed " << seed << ": " << nameOf(v.verdict) << " " << v.finding << ", "
                  << v.inWords;
  }
  ~Tally() {
    std::cout << what_ << ": " << right_ << " of " << runs_ << " said rightly, " << certain_
              << " of them without another explanation\n";
  }

 private:
  std::string what_;
  int runs_ = 0, right_ = 0, certain_ = 0;
};

int runs() { return mm_test::longTests() ? 100 : 8; }

/// Every second run is rough: the machine wanders, and the noise is correlated.
std::string roughOf(int run) { return run % 2 == 0 ? "" : "drift,correlated"; }

TEST(Verify, saysRightlyWhatWasLoadedHow) {
  Tally helped("helped"), notLoaded("not loaded"), wrongSign("wrong sign"),
      exchanged("tables of x and y exchanged"), columns("corrections of y and z exchanged"),
      drifted("drifted since"), raw("raw readings, it helps");
  for (int run = 0; run < runs(); ++run) {
    const std::uint64_t seed = 1000 + 10 * static_cast<std::uint64_t>(run);
    const std::string rough = roughOf(run);
    const LoadedController controller(seed, rough);
    const auto judged = [&](int i, const std::string& table, const std::vector<std::string>& errors,
                            bool loaded) {
      return controller.judge(controller.measure(seed + static_cast<std::uint64_t>(i), table, rough, errors),
                              loaded);
    };
    const std::string& table = controller.table;
    helped.add(seed, judged(1, table, loadedErrors(), true), VerifyVerdict::kHelped, "corrected", false);
    notLoaded.add(seed, judged(2, {}, loadedErrors(), true), VerifyVerdict::kNoChange, "not_corrected",
                  false);
    wrongSign.add(seed, judged(3, toTheOtherSide(table, 3), loadedErrors(), true), VerifyVerdict::kWorse,
                  "wrong_sign", false);
    std::string swapped = withExchangedColumns(table, "correction_x_um", "correction_y_um");
    swapped = withExchangedColumns(withExchangedColumns(swapped, "x_mm", "y_mm"), "x_travel", "y_travel");
    const Verification tables = judged(4, swapped, loadedErrors(), true);
    exchanged.add(seed, tables,
                  tables.verdict == VerifyVerdict::kWorse ? VerifyVerdict::kWorse : VerifyVerdict::kMixed,
                  "exchanged", false);
    EXPECT_NE(tables.inWords.find("x and y have each other's table"), std::string::npos) << tables.inWords;
    const Verification others =
        judged(5, withExchangedColumns(table, "correction_y_um", "correction_z_um"), loadedErrors(), true);
    columns.add(seed, others,
                others.verdict == VerifyVerdict::kWorse ? VerifyVerdict::kWorse : VerifyVerdict::kMixed,
                "exchanged", false);
    EXPECT_NE(others.inWords.find("y and z have each other's correction"), std::string::npos)
        << others.inWords;
    // Seven kelvins warmer, and the screw of x has worn.
    const Verification later = judged(6, table, loadedErrors(5.0, 80.0), true);
    drifted.add(seed, later, VerifyVerdict::kMixed, "corrected", true);
    EXPECT_NE(later.inWords.find("the machine has drifted since"), std::string::npos) << later.inWords;
    EXPECT_FALSE(later.changed.empty()) << later.inWords;
    for (const ChangedEffect& c : later.changed)
      if (c.effect == EffectSpec("backlash").set("axis", "x")) {
        EXPECT_NEAR(c.parameters[0].change, 2.0, 4.0 * c.parameters[0].std + 0.1) << later.inWords;
      }
    raw.add(seed, judged(7, {}, loadedErrors(), false), VerifyVerdict::kHelped, "corrected", false);
  }
}

}  // namespace
}  // namespace mm
