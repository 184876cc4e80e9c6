#include "verification/verify.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
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
  /// @param verdicts that are right.
  void add(std::uint64_t seed, const Verification& v, const std::vector<VerifyVerdict>& verdicts,
           const std::string& finding, bool drifted, const std::string& words = {}) {
    ++runs_;
    const bool verdict = std::find(verdicts.begin(), verdicts.end(), v.verdict) != verdicts.end();
    if (verdict && v.finding == finding && v.drifted == drifted &&
        v.inWords.find(words) != std::string::npos) {
      ++right_;
      if (v.rivals.empty()) ++certain_;
      if (v.moreLeft && !v.drifted) ++qualified_;
      return;
    }
    ADD_FAILURE() << what_ << ", seed " << seed << ": " << nameOf(v.verdict) << " " << v.finding << ", "
                  << v.inWords;
  }
  int qualified() const { return qualified_; }  ///< said rightly, but that more is left than it should be
  ~Tally() {
    std::cout << what_ << ": " << right_ << " of " << runs_ << " said rightly, " << certain_
              << " of them without another explanation, " << qualified_
              << " with more left than calibrated\n";
  }

 private:
  std::string what_;
  int runs_ = 0, right_ = 0, certain_ = 0, qualified_ = 0;
};

int runs() { return mm_test::longTests() ? 100 : 8; }

/// MM_FIRST_SEED: machines that nothing was chosen by.
std::uint64_t firstSeed() {
  const char* asked = std::getenv("MM_FIRST_SEED");
  return asked != nullptr ? std::stoull(asked) : 1000;
}

/// Every second run is rough: the machine wanders, and the noise is correlated.
std::string roughOf(int run) { return run % 2 == 0 ? "" : "drift,correlated"; }

/// Of a table at the wrong place: what two sessions of their own show, with it and without any.
std::vector<VerifyVerdict> rightFor(const Figure& with, const Figure& without) {
  const double difference = with.rms - without.rms, apart = 5.0 * std::hypot(with.std, without.std);
  if (difference > apart) return {VerifyVerdict::kWorse};
  if (difference < 0.0) return {VerifyVerdict::kMixed};
  return {VerifyVerdict::kWorse, VerifyVerdict::kMixed};
}

TEST(Verify, saysRightlyWhatWasLoadedHow) {
  Tally helped("helped"), notLoaded("not loaded"), wrongSign("wrong sign"),
      exchanged("tables of x and y exchanged"), columns("corrections of y and z exchanged"),
      drifted("drifted since"), raw("raw readings, it helps");
  for (int run = 0; run < runs(); ++run) {
    const std::uint64_t seed = firstSeed() + 10 * static_cast<std::uint64_t>(run);
    const std::string rough = roughOf(run);
    const LoadedController controller(seed, rough);
    const auto judged = [&](int i, const std::string& table, const std::vector<std::string>& errors,
                            bool loaded) {
      return controller.judge(controller.measure(seed + static_cast<std::uint64_t>(i), table, rough, errors),
                              loaded);
    };
    const std::string& table = controller.table;
    helped.add(seed, judged(1, table, loadedErrors(), true), {VerifyVerdict::kHelped}, "corrected", false);
    const Verification none = judged(2, {}, loadedErrors(), true);
    notLoaded.add(seed, none, {VerifyVerdict::kNoChange}, "not_corrected", false);
    wrongSign.add(seed, judged(3, toTheOtherSide(table, 3), loadedErrors(), true), {VerifyVerdict::kWorse},
                  "wrong_sign", false, "twice as bad");
    std::string swapped = withExchangedColumns(table, "correction_x_um", "correction_y_um");
    swapped = withExchangedColumns(withExchangedColumns(swapped, "x_mm", "y_mm"), "x_travel", "y_travel");
    const Verification tables = judged(4, swapped, loadedErrors(), true);
    exchanged.add(seed, tables, rightFor(tables.after, none.after), "exchanged", false,
                  "x and y have each other's table");
    const Verification others =
        judged(5, withExchangedColumns(table, "correction_y_um", "correction_z_um"), loadedErrors(), true);
    columns.add(seed, others, rightFor(others.after, none.after), "exchanged", false,
                "y and z have each other's correction");
    // Seven kelvins warmer, and the screw of x has worn.
    const Verification later = judged(6, table, loadedErrors(5.0, 80.0), true);
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
