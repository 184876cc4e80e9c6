// Whoever cancels is answered within a second: no stretch of a calibration or diagnosis runs longer without
// asking.
#include <gtest/gtest.h>
#include <time.h>

#include <algorithm>
#include <atomic>

#include "base/cancel_scope.h"
#include "base/error.h"
#include "diagnosis/diagnose.h"
#include "long_tests.h"
#include "model/model_spec.h"
#include "model/observed_domain.h"
#include "nine_ball_plate.h"
#include "simulation/simulate.h"

namespace mm {
namespace {

constexpr double kLongest = 1.0;  // s of the processor: what else runs on it does not count

double processorSeconds() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

/// Measures the time between two questions of one thread, and says yes from the n-th of all threads on: how
/// many fall to one thread differs from run to run.
class Clock {
 public:
  explicit Clock(int yesFrom = 1 << 30) : yesFrom_(yesFrom), last_(processorSeconds()) {}
  std::function<bool()> asked() {
    return [this] {
      if (pthread_equal(thread_, pthread_self()) != 0) mark();
      return ++count_ >= yesFrom_;
    };
  }
  void mark() {
    const double now = processorSeconds();
    longest_ = std::max(longest_, now - last_);
    last_ = now;
  }
  double longest() const { return longest_; }
  int count() const { return count_; }

 private:
  const pthread_t thread_ = pthread_self();
  const int yesFrom_;
  std::atomic<int> count_{0};
  double last_, longest_ = 0.0;
};

Session plate(const std::vector<std::string>& hide) {
  const Machine machine = Machine::load("three_axis");
  return simulate(machine, test::everydayPlate(machine), {hide, 3, ""}).session;
}

/// Nonlinear in every way: a period that is searched for, and a formula.
std::vector<EffectSpec> hardModel() {
  return {parseEffectSpec("{type: scale, axis: x}", "test"),
          parseEffectSpec("{type: lead_screw_periodic, axis: x, period_mm: unknown}", "test"),
          parseEffectSpec("{type: formula, direction: z, formula: \"k1*exp(-k2*t)\", start: [1, 0.001]}",
                          "test")};
}

CalibrationResult calibrated(const Session& session, Clock& clock, Method method) {
  CalibrateOptions options;
  options.method = method;
  options.stagedMutation.generations = 3;
  options.stagedMutation.population = 100;
  options.niching.generations = 3;
  options.niching.population = 50;
  options.cancelled = clock.asked();
  CalibrationResult r =
      calibrate(session, Model(session.machine, observedDomain(session), hardModel()), options);
  clock.mark();
  return r;
}

// The third method is asked by KeepsTheBestSoFarWheneverItComes, which needs its whole way.
TEST(Cancel, IsAskedForOftenInEveryStageOfACalibration) {
  const Session session = plate({});
  for (const Method method : {Method::kLeastSquares, Method::kNiching}) {
    Clock clock;
    calibrated(session, clock, method);
    EXPECT_LT(clock.longest(), kLongest) << nameOf(method);
    EXPECT_GT(clock.count(), 20) << nameOf(method);
  }
}

TEST(Cancel, KeepsTheBestSoFarWheneverItComes) {
  const Session session = plate({});
  Clock whole;
  calibrated(session, whole, Method::kStagedMutation);
  EXPECT_LT(whole.longest(), kLongest);
  EXPECT_GT(whole.count(), 20);
  const int parts = mm_test::thoroughTests() ? 6 : 2;
  for (int part = 0; part < parts; ++part) {
    Clock clock(1 + part * (whole.count() - 1) / parts);
    const CalibrationResult r = calibrated(session, clock, Method::kStagedMutation);
    EXPECT_TRUE(r.cancelled) << "asked at " << clock.count() << " of " << whole.count();
    EXPECT_FALSE(r.converged);
    EXPECT_TRUE(r.x.allFinite());
    EXPECT_LT(clock.longest(), kLongest);
  }
}

TEST(Cancel, EndsADiagnosisWhereverItIs) {
  std::vector<std::string> hidden{"backlash:x=3um"};
  if (mm_test::thoroughTests()) hidden.emplace_back("thermal_growth:z/bed=0.6um/K");
  const Session session = plate(hidden);
  const auto diagnosed = [&](Clock& clock) {
    DiagnoseOptions options;
    options.cancelled = clock.asked();
    options.calibrate.cancelled = options.cancelled;
    diagnose(session, Model(session.machine, observedDomain(session), std::vector<EffectSpec>()), options);
    clock.mark();
  };
  Clock whole;
  diagnosed(whole);
  EXPECT_LT(whole.longest(), kLongest);
  EXPECT_GT(whole.count(), 100);
  const int parts = mm_test::thoroughTests() ? 8 : 2;
  for (int part = 0; part < parts; ++part) {
    Clock clock(1 + part * (whole.count() - 1) / parts);
    EXPECT_THROW(diagnosed(clock), Cancelled) << "asked at " << clock.count() << " of " << whole.count();
    EXPECT_LT(clock.longest(), kLongest);
  }
}

TEST(Cancel, ScopesNestAndEnd) {
  EXPECT_NO_THROW(CancelScope::check());
  const CancelScope outer([] { return true; });
  {
    const CancelScope inner([] { return false; });
    EXPECT_NO_THROW(CancelScope::check());
  }
  EXPECT_THROW(CancelScope::check(), Cancelled);
}

}  // namespace
}  // namespace mm
