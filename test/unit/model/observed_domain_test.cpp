// Whether the positions of an axis lie on a grid: on one, a wave shorter than two of its distances cannot be
// told from a longer one.
#include "model/observed_domain.h"

#include <gtest/gtest.h>

#include <cmath>

#include "deviations.h"
#include "model/session_states.h"
#include "random_numbers.h"

namespace mm {
namespace {

double spacingOf(const std::vector<double>& positions) {
  Session session(Machine::load("three_axis"));
  for (const double x : positions)
    session.observations.push_back(test_support::deviationOfX(x, kNotMeasured, 0.0, 0.0));
  const Domain domain = observedDomain(session);
  EXPECT_EQ(domain.spacing.size(), 3u);
  EXPECT_EQ(domain.spacing[1], 0.0) << "y stood still";
  return domain.spacing[0];
}

/// Twenty-one targets 2 mm apart, up and down, each met within `jitter`.
std::vector<double> targets(double jitter) {
  test_support::RandomNumbers random(4);
  std::vector<double> at;
  for (int run = 0; run < 6; ++run)
    for (int i = 0; i < 21; ++i)
      at.push_back((run % 2 == 0 ? i : 20 - i) * 2e-3 - 20e-3 + random.uniform(-jitter, jitter));
  return at;
}

TEST(Spacing, IsThatOfEqualDistances) {
  EXPECT_NEAR(spacingOf(targets(0.0)), 2e-3, 1e-12);
  EXPECT_NEAR(spacingOf(targets(5e-6)), 2e-3, 1e-6);  // where the axis stood, not where it was sent
}

TEST(Spacing, IsThatOfTheGridWhereTargetsAreLeftOut) {
  EXPECT_NEAR(spacingOf({0.0, 2e-3, 4e-3, 10e-3, 12e-3, 18e-3}), 2e-3, 1e-12);
  // whole steps, of which no two that were taken are neighbours: a wave of 60 steps is one of 60/61, too
  EXPECT_NEAR(spacingOf({-84e-3, -77e-3, -42e-3, -39e-3, -5e-3, -2e-3, 19e-3, 43e-3, 48e-3, 60e-3, 77e-3}),
              1e-3, 1e-12);
}

TEST(Spacing, IsNoneOfUnequalDistances) {
  EXPECT_EQ(spacingOf(targets(50e-6)), 0.0);  // known, and a short wave is met at many phases
  EXPECT_EQ(spacingOf({0.0, 2.3e-3, 4.1e-3, 9.8e-3, 12e-3}), 0.0);  // as ISO 230-2 asks
  EXPECT_EQ(spacingOf({0.0, 2e-3, 4e-3, 6e-3}), 0.0);               // too few to say
  EXPECT_EQ(spacingOf({3e-3, 3e-3, 3e-3, 3e-3, 3e-3}), 0.0);
}

/// Before y first moves its direction is not known; in the run of x, which shows nothing of y, that is no
/// matter. An effect that needs it was refused, and the whole diagnosis with it.
TEST(States, KnowTheTravelWhereNothingIsMeasuredAlongTheJoint) {
  Session session(Machine::load("three_axis"));
  const double xs[] = {0.0, 5e-3, 0.0, 0.0, 0.0, 0.0}, ys[] = {0.0, 0.0, 0.0, 0.0, 5e-3, 0.0};
  const double ways[] = {kNotMeasured, kNotMeasured, kNotMeasured, kNotMeasured, 1e-3, -1e-3};
  for (int i = 0; i < 6; ++i) {
    Observation o;
    o.kind = ObservationKind::kDeviation;
    o.time = i;
    o.position = {xs[i], ys[i], 0.0};
    o.velocity = {i == 1 ? 1e-3 : -1e-3, ways[i], kNotMeasured};
    const bool alongX = i < 3;
    o.deviation = {alongX ? 1e-6 : kNotMeasured, alongX ? kNotMeasured : 1e-6, kNotMeasured};
    o.deviationStd.assign(3, kNotMeasured);
    session.observations.push_back(o);
  }
  session.prepare();
  const SessionStates states(session, observedDomain(session));
  const double travelOfY[] = {1.0, 1.0, 1.0, 0.0, 1.0, -1.0};
  for (int i = 0; i < 6; ++i) {
    EXPECT_EQ(states.states()[static_cast<std::size_t>(i)].travel[1], travelOfY[i]) << i;
    EXPECT_EQ(states.states()[static_cast<std::size_t>(i)].travel[2], 0.0) << "z never moved";
  }
}

}  // namespace
}  // namespace mm
