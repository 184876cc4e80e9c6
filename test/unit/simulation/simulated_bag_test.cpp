#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "read_contacts.h"
#include "ros_bridge/bag_session.h"
#include "simulation/session_csv.h"
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
    EXPECT_TRUE(read.simulated);
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

TEST(SimulatedBag, LengthsComeBackFromTheBagAndFromTheTable) {
  const Machine machine = Machine::load("three_axis");
  const std::string yaml =
      "artifact: {name: beams, pose: known, points: [{name: +x, position_mm: [-100, 0, 0]}]}\n"
      "moves: [{x_mm: -9, reference: length, feature: +x, setup: s}, {x_mm: 9, reference: length, feature: "
      "+x, "
      "setup: s}]\n";
  const Simulation simulation = simulate(machine, Plan::parse(yaml, "plan.yaml", ".", machine), {});
  const Session& session = simulation.session;
  const std::filesystem::path file =
      std::filesystem::temp_directory_path() / ("lengths_" + std::to_string(::getpid()) + ".csv");
  std::ofstream(file) << sessionCsv(session);
  const Session table = readContactsCsv(file, machine, &session.artifact), bag = throughBag(simulation);
  std::filesystem::remove(file);
  for (const Session* read : {&table, &bag}) {
    ASSERT_EQ(read->observations.size(), 2u);
    for (std::size_t i = 0; i < 2; ++i) {
      EXPECT_EQ(read->observations[i].kind, ObservationKind::kLength);
      EXPECT_EQ(read->observations[i].feature, 0);
      EXPECT_EQ(read->observations[i].setup, 0);
      EXPECT_NEAR(read->observations[i].length, session.observations[i].length, 1e-12);
    }
  }
}

}  // namespace
}  // namespace mm
