#include "fleet/sensor_health.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace mm {
namespace {

Session withSensors() {
  Session session(Machine::load("three_axis"));
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  for (const char* name : {"bed", "frame", "motor"}) session.temperatures.push_back({name, "degC", {}, {}});
  for (int i = 0; i < 60; ++i) {
    const double t = 10.0 * i;
    for (Series& s : session.temperatures) s.time.push_back(t);
    session.temperatures[0].value.push_back(20.0 + 1e-3 * t + 0.02 * normal(random));
    session.temperatures[1].value.push_back(21.0 + 1e-3 * t + 0.2 * normal(random));
    session.temperatures[2].value.push_back(25.0);
  }
  return session;
}

TEST(SensorHealth, tellsNoiseFromDriftAndAStuckSensorFromAQuietOne) {
  const std::vector<SensorHealth> all = sensorHealth(withSensors());
  ASSERT_EQ(all.size(), 3u);
  EXPECT_NEAR(all[0].noise, 0.02, 0.012);
  EXPECT_NEAR(all[1].noise, 0.2, 0.12);
  EXPECT_GT(all[0].span, 0.5);
  EXPECT_EQ(all[2].span, 0.0);
  EXPECT_NEAR(all[2].offset, 25.0 - 20.8, 0.1);
  EXPECT_EQ(all[0].setAside, 0);
}

TEST(SensorHealth, theOnlySensorHasNoOffset) {
  Session session = withSensors();
  session.temperatures.resize(1);
  EXPECT_TRUE(std::isnan(sensorHealth(session)[0].offset));
}

}  // namespace
}  // namespace mm
