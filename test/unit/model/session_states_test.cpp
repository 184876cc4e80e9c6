// The way since a reversal, by the rows of a session.
#include "model/session_states.h"

#include <gtest/gtest.h>

#include <cmath>

#include "deviations.h"
#include "model/observed_domain.h"

namespace mm {
namespace {

TEST(SinceReversal, CountsFromTheLastRowBeforeIt) {
  Session session(Machine::load("three_axis"));
  const double x[] = {1e-3, 2e-3, 5e-3, 5e-3, 4e-3, 0.0, 1e-3}, way[] = {1, 1, 1, -1, -1, -1, 1};
  for (int i = 0; i < 7; ++i)
    session.observations.push_back(test_support::deviationOfX(x[i], way[i] * 1e-3, i, 0.0));
  session.prepare();
  const SessionStates states(session, observedDomain(session));
  EXPECT_TRUE(std::isnan(states[0].sinceReversalOf(0))) << "how it came there is not known";
  const double expected[] = {0.0, 1e-3, 4e-3, 0.0, 1e-3, 5e-3, 1e-3};
  for (int i = 1; i < 7; ++i) EXPECT_NEAR(states[i].sinceReversalOf(0), expected[i], 1e-12) << i;
  EXPECT_TRUE(std::isinf(states[6].sinceReversalOf(1))) << "y never moved";
}

// Their temperatures are those of the rows all the same.
TEST(AssumedTimes, AreKnownToNoEffect) {
  Session session(Machine::load("three_axis"));
  for (int i = 0; i < 4; ++i)
    session.observations.push_back(test_support::deviationOfX(i * 1e-3, 1e-3, i, 0.0));
  session.temperatures.push_back({"bed", "degC", {0.0, 1.0, 2.0, 3.0}, {20.0, 21.0, 20.5, 22.0}});
  session.prepare();
  EXPECT_GT(observedDomain(session).duration, 0.0);
  session.timesAssumed = kTimesInOrder;
  const Domain domain = observedDomain(session);
  EXPECT_EQ(domain.duration, 0.0);
  EXPECT_TRUE(domain.gaps.empty());
  const SessionStates states(session, domain);
  for (int i = 0; i < 4; ++i) {
    EXPECT_TRUE(std::isnan(states[i].time)) << i;
    EXPECT_TRUE(std::isfinite(states[i].temperature[0])) << i;
  }
}

/// Between two touches the probe went back and forth.
TEST(SinceReversal, IsNotKnownOfATouch) {
  Session session(Machine::load("three_axis"));
  session.artifact.features = {Feature()};
  session.artifact.features[0].name = "b";
  session.artifact.features[0].radius = 4e-3;
  for (int i = 0; i < 2; ++i) {
    Observation o;
    o.time = i;
    o.position = {i * 1e-3, 0.0, 0.0};
    o.velocity = {1e-3, 0.0, 0.0};
    o.approach = Eigen::Vector3d::UnitX();
    o.feature = 0;
    session.observations.push_back(o);
  }
  session.prepare();
  const SessionStates states(session, observedDomain(session));
  EXPECT_TRUE(std::isnan(states[1].sinceReversalOf(0)));
}

}  // namespace
}  // namespace mm
