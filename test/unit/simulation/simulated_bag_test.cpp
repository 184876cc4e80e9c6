#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>

#include "ros_bridge/bag_session.h"
#include "simulation/simulate.h"

namespace mm {
namespace {

/// Through a bag and back.
Session throughBag(const Simulation& simulation) {
  const std::filesystem::path file =
      std::filesystem::temp_directory_path() / ("simulated_bag_test_" + std::to_string(::getpid()) + ".bag");
  writeSessionBag(simulation.session, file, {}, simulation.motion);
  Session session = readSessionBag(file);
  std::filesystem::remove(file);
  return session;
}

Simulation run(const std::string& plan, const char* machineName) {
  const Machine machine = Machine::load(machineName);
  SimulationRequest request;
  request.hide = {"backlash"};
  return simulate(machine, Plan::load("config/plans/" + plan + ".yaml", machine), request);
}

TEST(SimulatedBag, KeepsReadingsTravelAndApproachOfEveryMeasurement) {
  for (const auto& [plan, machine] :
       std::vector<std::pair<const char*, const char*>>{{"nine_ball_plate", "three_axis"},
                                                        {"interferometer", "three_axis"},
                                                        {"five_axis_ball", "five_axis"}}) {
    const Simulation simulation = run(plan, machine);
    const Session read = throughBag(simulation);
    ASSERT_EQ(read.observations.size(), simulation.session.observations.size());
    for (std::size_t i = 0; i < read.observations.size(); ++i) {
      const Observation &a = simulation.session.observations[i], &b = read.observations[i];
      ASSERT_EQ(a.position, b.position) << plan << " " << i;
      ASSERT_EQ(a.velocity, b.velocity) << plan << " " << i;
      ASSERT_EQ(a.travel, b.travel) << plan << " " << i;
      ASSERT_EQ(a.feature, b.feature);
      ASSERT_NEAR(a.time, b.time, 1e-6);
      ASSERT_TRUE(a.laserReading == b.laserReading ||
                  (std::isnan(a.laserReading) && std::isnan(b.laserReading)));
    }
    ASSERT_EQ(read.temperatures.size(), 4u);
  }
}

}  // namespace
}  // namespace mm
