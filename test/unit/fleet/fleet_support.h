#pragma once
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "base/format.h"
#include "fleet/fleet.h"

namespace mm {

/// Made-up results of a fleet in which nothing happens: machines differ, sessions scatter by what is stated
/// and a little more.
struct MadeUpFleet {
  int machines = 20, sessions = 12;
  std::vector<FleetRecord> records;

  MadeUpFleet(std::uint64_t seed, int machineCount, int sessionCount, int parameters = 9)
      : machines(machineCount), sessions(sessionCount) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    for (int m = 0; m < machines; ++m) {
      std::vector<double> own, sensorOwn;
      for (int p = 0; p < parameters; ++p) own.push_back(2.0 + 0.5 * normal(random));
      for (int s = 0; s < 3; ++s) sensorOwn.push_back(0.3 * normal(random));
      for (int k = 0; k < sessions; ++k) {
        FleetRecord r;
        r.machine = format("m%03d", m + 1);
        r.date = format("20%02d-%02d-15T00:00:00Z", 20 + k / 12, 1 + k % 12);
        r.session = format("/data/%s/%03d.bag", r.machine.c_str(), k);
        r.model = "/data/model.yaml";
        JobResult& j = r.result;
        j.key = r.machine + format("-%03d", k);
        j.status = "done";
        j.asked = true;
        j.verdict = "explained";
        j.rms = 0.3;
        j.heldOutRms = 0.31 * (1.0 + 0.05 * normal(random));
        for (int p = 0; p < parameters; ++p)
          j.parameters.push_back(
              {format("{type: backlash, axis: a%d}", p), "gap", "um",
               own[static_cast<std::size_t>(p)] + 0.1 * normal(random) + 0.05 * normal(random), 0.1, false});
        if (normal(random) > 1.5) j.found.push_back("{type: speed_lag}");
        for (int s = 0; s < 3; ++s)
          j.sensors.push_back({format("s%d", s), 20, 0, 21.0, 0.02 * std::exp(0.2 * normal(random)), 0.5,
                               sensorOwn[static_cast<std::size_t>(s)] + 0.05 * normal(random), 1e-3});
        records.push_back(std::move(r));
      }
    }
  }
  /// The sensors of a quiet room, read in steps of `step` K; machines stand in places of their own
  /// temperature, and the room's differs from one session to the next.
  void readInSteps(std::uint64_t seed, double step) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    Session session(Machine::load("three_axis"));
    for (const char* name : {"s0", "s1", "s2"}) session.temperatures.push_back({name, "degC", {}, {}});
    double place[3] = {};
    for (std::size_t i = 0; i < records.size(); ++i) {
      if (i % static_cast<std::size_t>(sessions) == 0)
        for (double& p : place) p = 20.0 + 0.3 * normal(random);
      const double room = 0.15 * normal(random), swing = 0.1 * normal(random);
      for (int s = 0; s < 3; ++s) {
        std::vector<double>& value = session.temperatures[static_cast<std::size_t>(s)].value;
        value.clear();
        for (int k = 0; k < 40; ++k)
          value.push_back(step *
                          std::round((place[s] + room + swing * k / 40 + 0.02 * normal(random)) / step));
      }
      records[i].result.sensors = sensorHealth(session);
    }
  }
  FleetRecord& at(int machine, int session) {
    return records[static_cast<std::size_t>(machine * sessions + session)];
  }
};

}  // namespace mm
