#include "thermal/duty_error.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "motor_spindle.h"
#include "random_numbers.h"
#include "spindle_simulation.h"

namespace mm {
namespace {

using namespace test_support;

/// A body that warms with 900 s and the displacement with it; a second that warms faster. Exact.
struct TwoBodies {
  Eigen::MatrixXd t;
  Eigen::VectorXd y;
  TwoBodies(const Duty& duty, int n, double noise) : t(n, 3), y(n) {
    RandomNumbers random(3);
    double slow = 0.0, fast = 0.0, time = 0.0;
    for (int k = 0; k < n; ++k) {
      for (; time < 7200.0 * (k + 1) / n; time += 4.0) {
        slow += 4.0 / 900.0 * (10.0 * duty(time) - slow);
        fast += 4.0 / 300.0 * (10.0 * duty(time) - fast);
      }
      t.row(k) << 20.0 + slow + random.normal(noise), 20.0 + fast + random.normal(noise),
          20.0 + slow + random.normal(4.0 * noise);
      y(k) = 3.0 * slow;
    }
  }
};

TEST(DutyError, IsNothingWhereTheDisplacementFollowsOnAnyDuty) {
  const TwoBodies exact(patentDuty(), 100, 0.0);
  const DutyError duties(exact.t, exact.y, 1);
  EXPECT_EQ(duties.components(), 2);
  EXPECT_LT(duties.of({0}), 1e-6);
  EXPECT_GT(duties.of({1}), 1.0);
  EXPECT_LT(duties.of({0, 2}), 1e-6);  // which read the same
}

TEST(DutyError, TellsNoiseOfTheSensorsFromTheField) {
  const TwoBodies noisy(patentDuty(), 200, 0.1);
  const DutyError duties(noisy.t, noisy.y, 1);
  // two of three sensors read one body: what the field leaves is mostly the noise of the worse of them
  EXPECT_GT(duties.of({2}), 1.4 * duties.of({0}));
  EXPECT_LT(duties.of({0}), 1.0);
  const RandomSpindle spindle(77001);
  const SpindleRun run = spindle.run(patentDuty(), 100, 0.1, 0.5, 5);
  const DutyError many(run.temperatures, run.displacement, 1);
  double noise = 0.0;
  for (int s = 0; s < 54; ++s) noise += many.noise(s) / 54.0;
  EXPECT_NEAR(noise, 0.1, 0.01);
}

/// The error of least squares through one sensor, found on other runs.
double found(const SpindleRun& train, const SpindleRun& test, int s) {
  const double meanT = train.temperatures.col(s).mean(), meanY = train.displacement.mean();
  const Eigen::VectorXd t = train.temperatures.col(s).array() - meanT, y = train.displacement.array() - meanY;
  const double slope = t.dot(y) / t.squaredNorm();
  const Eigen::VectorXd left =
      (test.displacement.array() - meanY) - slope * (test.temperatures.col(s).array() - meanT);
  return left.norm() / std::sqrt(static_cast<double>(left.size()));
}

TEST(DutyError, RanksSensorsAsOtherRunsDo) {
  for (const std::uint64_t seed : {77002, 77003, 77004}) {
    const MotorSpindle spindle(seed);
    const SpindleRun train = spindle.run(patentDuty(), 100, false, seed),
                     test = spindle.run(randomDuty(seed), 100, true, seed + 1);
    const DutyError duties(train.temperatures, train.displacement, 1);
    int agree = 0, pairs = 0;
    for (int a = 0; a < MotorSpindle::kSensors; ++a)
      for (int b = 0; b < a; ++b, ++pairs)
        agree += (duties.of({a}) < duties.of({b})) == (found(train, test, a) < found(train, test, b));
    EXPECT_GT(agree, 0.75 * pairs);
  }
}

TEST(DutyError, HoldsWithFewSamplesAndSensorsOutOfOrder) {
  const TwoBodies some(patentDuty(), 60, 0.1);
  EXPECT_TRUE(std::isfinite(DutyError(some.t.topRows(4), some.y.head(4), 1).of({0, 1, 2})));
  Eigen::MatrixXd t = some.t;
  Eigen::VectorXd y = some.y;
  RandomNumbers random(9);
  for (int i = 59; i > 0; --i) {
    const int j = static_cast<int>(random.uniform(0.0, i + 0.999));
    t.row(i).swap(t.row(j));
    std::swap(y(i), y(j));
  }
  const DutyError shuffled(t, y, 1);
  EXPECT_LT(shuffled.of({0}), shuffled.of({1}));
  EXPECT_THROW(DutyError(some.t, some.y.head(59), 1), InputError);
  EXPECT_THROW(DutyError(some.t.topRows(3), some.y.head(3), 1), InputError);
}

}  // namespace
}  // namespace mm
