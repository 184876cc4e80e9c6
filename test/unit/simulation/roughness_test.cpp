#include "simulation/roughness.h"

#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/units.h"
#include "simulation/setting.h"
#include "simulation/simulate.h"
#include "simulation/wander.h"

namespace mm {
namespace {

constexpr double kNoise = 0.3e-6;  // m

std::string plate(int points, const std::string& instrument) {
  return R"(
artifact:
  name: pair
  pose: known
  probe: {tip_radius_mm: 1.0}
  balls:
    - {name: b0, centre_mm: [-9, -6, -5], radius_mm: 4}
    - {name: b1, centre_mm: [9, 20, 3], radius_mm: 4}
clearance: {z_mm: 14}
touch: {points: )" +
         std::to_string(points) +
         R"(, cone_deg: 75, order: interleaved, speeds_mm_s: [1, 3], pause: {every: 50, wait_s: 300}}
instrument:
  thermal: {ambient: {start_degC: 21, ramp_K_per_h: 1, swing_K: 1, swing_period_min: 10}}
)" + instrument;
}

Simulation simulated(const std::string& plan, const std::string& rough, std::uint64_t seed = 1,
                     std::vector<std::string> hide = {},
                     const std::vector<SourceKind>& kinds = sourceKinds()) {
  SimulationRequest request;
  request.kinds = &kinds;
  request.seed = seed;
  request.hide = std::move(hide);
  request.rough = rough;
  const Machine machine = Machine::load("three_axis");
  return simulate(machine, Plan::parse(plan, "plan.yaml", ".", machine), request);
}

std::string withNoise(int points, const std::string& more = "") {
  return plate(points, "  noise: {repeatability_um: 0.3}\n" + more);
}

double mean(const std::vector<double>& v) {
  double sum = 0.0;
  for (const double x : v) sum += x;
  return sum / static_cast<double>(v.size());
}

double rmsAboutMean(const std::vector<double>& v) {
  const double centre = mean(v);
  double sum = 0.0;
  for (const double x : v) sum += (x - centre) * (x - centre);
  return std::sqrt(sum / static_cast<double>(v.size()));
}

/// Correlation with the value before.
double memory(const std::vector<double>& v) {
  const double centre = mean(v), rms = rmsAboutMean(v);
  double sum = 0.0;
  for (std::size_t i = 1; i < v.size(); ++i) sum += (v[i] - centre) * (v[i - 1] - centre);
  return sum / (static_cast<double>(v.size() - 1) * rms * rms);
}

/// What the readings of a joint are beyond those of the same session without noise, m.
std::vector<double> noiseOf(const Simulation& s, int joint) {
  const auto contacts = static_cast<int>(s.session.observations.size());
  const Simulation clean = simulated(plate(contacts / 2, "  noise: {repeatability_um: 0}\n"), "");
  std::vector<double> noise;
  for (int i = 0; i < contacts; ++i)
    noise.push_back(s.session.observations[i].position[joint] -
                    clean.session.observations[i].position[joint]);
  return noise;
}

/// Where the tip is beyond what the readings say, along a joint of the three-axis machine, m.
std::vector<double> errors(const Simulation& s, int joint) {
  std::vector<double> e;
  for (const TrueState& state : s.states)
    e.push_back((s.truth->position(state) - s.truth->nominal(state))(joint));
  return e;
}

TEST(Roughness, IsReadFromWords) {
  Roughness rough;
  EXPECT_TRUE(rough.none());
  rough.change("drift, form=0.5,quantised", "--rough");
  EXPECT_DOUBLE_EQ(rough.drift, 1.0);
  EXPECT_DOUBLE_EQ(rough.form, 0.5);
  EXPECT_DOUBLE_EQ(rough.quantised, 3.0);
  EXPECT_EQ(rough.text(), "drift=1,form=0.5,quantised=3");
  Roughness again;
  again.change(rough.text(), "--rough");
  EXPECT_EQ(again.text(), rough.text());
  rough.change("none,all=2", "--rough");
  EXPECT_EQ(rough.text(), "drift=2,correlated=2,form=2,sensors=2,tails=2");
  EXPECT_DOUBLE_EQ(rough.noiseFactor(), 4.0);
  rough.change("", "--rough");
  EXPECT_EQ(rough.text(), "drift=2,correlated=2,form=2,sensors=2,tails=2");
  rough.change("none", "--rough");
  EXPECT_TRUE(rough.none());
}

std::string messageOf(const std::string& words) {
  try {
    Roughness().change(words, "--rough");
  } catch (const InputError& e) {
    return e.what();
  }
  return "";
}

TEST(Roughness, SaysWhichWordIsWrongAndWhatIsPossible) {
  EXPECT_NE(messageOf("drift,drfit").find("--rough: 'drfit' is not a disturbance; available: drift"),
            std::string::npos);
  EXPECT_NE(messageOf("drift=much").find("'much' of 'drift'"), std::string::npos);
  EXPECT_FALSE(messageOf("drift=-1").empty());
  EXPECT_FALSE(messageOf("drift=nan").empty());
  EXPECT_FALSE(messageOf("form=").empty());
  EXPECT_FALSE(messageOf("drift,,form").empty());
}

TEST(Roughness, IsReadFromAPlan) {
  const auto read = [](const std::string& yaml) {
    return InstrumentSettings::parse("instrument: {rough: " + yaml + "}", "plan.yaml").rough;
  };
  EXPECT_EQ(read("all").text(), "drift=1,correlated=1,form=1,sensors=1,tails=1");
  EXPECT_EQ(read("'drift,form=2'").text(), "drift=1,form=2");
  for (const char* wrong : {"{drift: 1}", "[drift]", "drfit", "drift=-1", "drift=much"})
    EXPECT_THROW(read(wrong), InputError) << wrong;
}

TEST(Roughness, DriftHasTheSizeThatWasAskedForInEachJoint) {
  for (const double size : {0.5, 2.0})
    for (const std::uint64_t seed : {1, 2, 3}) {
      const Simulation s = simulated(withNoise(150), "drift=" + std::to_string(size), seed);
      for (int joint = 0; joint < 3; ++joint) {
        const std::vector<double> e = errors(s, joint);
        EXPECT_NEAR(rmsAboutMean(e), size * kNoise, 0.001 * kNoise);
        EXPECT_GT(memory(e), 0.95);  // slow: from one contact to the next it hardly changes
      }
    }
}

TEST(Roughness, DriftOfTheJointsIsIndependent) {
  double products = 0.0;
  constexpr int kSeeds = 40;
  std::vector<double> times;
  for (int i = 0; i < 200; ++i) times.push_back(10.0 * i);
  for (int seed = 0; seed < kSeeds; ++seed) {
    Random x(seed, "rough drift x"), y(seed, "rough drift y");
    const Wander a(0, 1.0, times, x), b(1, 1.0, times, y);
    double product = 0.0;
    for (const double time : times) product += a.at(time) * b.at(time) / 200.0;
    EXPECT_LT(std::abs(product), 1.0);
    products += product / kSeeds;
  }
  EXPECT_NEAR(products, 0.0, 0.25);
}

TEST(Roughness, DriftGoesOnWhileTheMachineStandsAndHasNoJumps) {
  std::vector<double> times;
  for (int i = 0; i < 100; ++i) times.push_back(i < 50 ? 10.0 * i : 7200.0 + 10.0 * i);
  Random random(5, "drift");
  const Wander drift(0, 1.0, times, random);
  double largest = 0.0, moved = 0.0;
  for (double t = 0.0; t < 8000.0; t += 1.0)
    largest = std::max(largest, std::abs(drift.at(t + 1.0) - drift.at(t)));
  for (double t = 500.0; t < 7700.0; t += 1.0) moved += std::pow(drift.at(t + 1.0) - drift.at(t), 2);
  EXPECT_LT(largest, 0.3);
  EXPECT_GT(std::sqrt(moved), 0.2);
  EXPECT_EQ(drift.at(1e6), drift.at(2e6));
  EXPECT_EQ(drift.at(-1.0), drift.at(0.0));
}

TEST(Roughness, NothingDriftsWhereNothingIsMeasuredTwice) {
  Random random(5, "drift");
  const Wander drift(0, 1.0, {10.0}, random);
  EXPECT_EQ(drift.at(5.0), 0.0);
}

TEST(Roughness, CorrelatedNoiseRemembersTheContactBefore) {
  const Simulation s = simulated(withNoise(750), "correlated"),
                   twice = simulated(withNoise(750), "correlated=2"), white = simulated(withNoise(750), "");
  for (int joint = 0; joint < 3; ++joint) {
    const std::vector<double> noise = noiseOf(s, joint);
    EXPECT_NEAR(memory(noise), 0.7, 0.07);
    EXPECT_NEAR(rmsAboutMean(noise), kNoise, 0.12 * kNoise);
    EXPECT_NEAR(rmsAboutMean(noiseOf(twice, joint)), 2.0 * kNoise, 0.24 * kNoise);
    EXPECT_NEAR(memory(noiseOf(white, joint)), 0.0, 0.07);
    EXPECT_NEAR(rmsAboutMean(noiseOf(white, joint)), kNoise, 0.05 * kNoise);
  }
}

/// The noise that `tails` has, without what is wild.
std::string tailsAlone() { return plate(1500, "  noise: {repeatability_um: 0.3, student_dof: 3}\n"); }

TEST(Roughness, TailsAreHeavyAtTheSameStandardDeviation) {
  // Of Student's t with three degrees of freedom and standard deviation 1 a half is within 0.4416.
  std::vector<double> size;
  double square = 0.0;
  const Simulation s = simulated(tailsAlone(), "");
  for (int joint = 0; joint < 3; ++joint)
    for (const double n : noiseOf(s, joint)) {
      size.push_back(std::abs(n) / kNoise);
      square += n * n / (kNoise * kNoise);
    }
  std::sort(size.begin(), size.end());
  EXPECT_NEAR(size[size.size() / 2], 0.4416, 0.02);
  EXPECT_NEAR(std::sqrt(square / size.size()), 1.0, 0.15);  // it settles slowly: no fourth moment
  EXPECT_GT(size.back(), 6.0);
}

TEST(Roughness, OneContactInAHundredIsWild) {
  const Simulation calm = simulated(tailsAlone(), ""), wild = simulated(withNoise(1500), "tails");
  int off = 0;
  for (std::size_t i = 0; i < calm.states.size(); ++i) {
    Eigen::Vector3d moved;
    for (int j = 0; j < 3; ++j)
      moved(j) = wild.session.observations[i].position[j] - calm.session.observations[i].position[j];
    const double along = moved.dot(calm.session.observations[i].approach) / kNoise;
    EXPECT_NEAR((moved / kNoise - along * calm.session.observations[i].approach).norm(), 0.0, 1e-6);
    if (std::abs(along) < 1e-6) continue;
    ++off;
    EXPECT_GT(std::abs(along), 4.0 - 1e-6);
    EXPECT_LT(std::abs(along), 8.0 + 1e-6);
  }
  EXPECT_NEAR(off, 30, 17);
}

TEST(Roughness, QuantisedReadingsAreMultiplesOfTheStep) {
  const Simulation s = simulated(withNoise(100), "quantised"), fine = simulated(withNoise(100), "");
  for (std::size_t i = 0; i < s.states.size(); ++i)
    for (int j = 0; j < 3; ++j) {
      const double reading = s.session.observations[i].position[j], steps = reading / (3.0 * kNoise);
      EXPECT_NEAR(steps, std::round(steps), 1e-6);
      EXPECT_LE(std::abs(reading - fine.session.observations[i].position[j]), 1.5 * kNoise * (1.0 + 1e-9));
    }
}

TEST(Roughness, BallsHaveFormRadiusAndCentreErrors) {
  double form = 0.0, radius = 0.0, centre = 0.0;
  int balls = 0;
  const Artifact stated = simulated(withNoise(2), "").session.artifact;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    const Simulation s = simulated(withNoise(2), "form=2", seed);
    const TrueArtifact& artifact = s.truth->physics().artifact;
    for (int f = 0; f < 2; ++f, ++balls) {
      std::vector<double> shape;
      Random all(seed, "all round");
      for (int k = 0; k < 2000; ++k) {
        const double x = all.normal(), y = all.normal(), z = all.normal();
        shape.push_back(artifact.radius(f, Eigen::Vector3d(x, y, z).normalized(), kReferenceTemperature));
      }
      EXPECT_NEAR(rmsAboutMean(shape), 2.0 * kNoise, 0.2 * kNoise);
      form += std::pow(rmsAboutMean(shape), 2);
      radius += std::pow(mean(shape) - stated.features[f].radius, 2);
      centre += (artifact.centre(f, kReferenceTemperature) - stated.features[f].position).squaredNorm() / 3.0;
    }
  }
  EXPECT_NEAR(std::sqrt(form / balls), 2.0 * kNoise, 0.05 * kNoise);
  EXPECT_NEAR(std::sqrt(radius / balls), 2.0 * kNoise, 0.4 * kNoise);
  EXPECT_NEAR(std::sqrt(centre / balls), 2.0 * kNoise, 0.25 * kNoise);
}

TEST(Roughness, FormIsSmooth) {
  const Simulation s = simulated(withNoise(2), "form");
  const TrueArtifact& artifact = s.truth->physics().artifact;
  for (double angle = 0.0; angle < 2.0 * kPi; angle += 1.0 * kDegree) {
    const auto at = [&](double a) {
      return artifact.radius(0, {std::cos(a), std::sin(a), 0.0}, kReferenceTemperature);
    };
    EXPECT_LT(std::abs(at(angle + 1.0 * kDegree) - at(angle)), 0.4 * kNoise);
  }
}

TEST(Roughness, SensorsAreNoisyStepwiseLateAndOff) {
  const Simulation s = simulated(withNoise(200), "sensors"), smooth = simulated(withNoise(200), "");
  ASSERT_EQ(s.session.temperatures.size(), smooth.session.temperatures.size());
  std::vector<double> offsets;
  for (std::size_t k = 0; k < s.session.temperatures.size(); ++k) {
    const Series &rough = s.session.temperatures[k], &calm = smooth.session.temperatures[k];
    ASSERT_EQ(rough.time, calm.time);
    std::vector<double> bends, off;
    for (std::size_t i = 0; i < rough.value.size(); ++i) {
      EXPECT_NEAR(std::remainder(rough.value[i], 0.0625), 0.0, 1e-9);
      off.push_back(rough.value[i] - calm.value[i]);
      // second differences: the temperatures themselves are straight lines over 20 s
      if (i > 1) bends.push_back(rough.value[i] - 2.0 * rough.value[i - 1] + rough.value[i - 2]);
    }
    offsets.push_back(mean(off));
    // noise 0.05 K and steps of 0.0625 K, which add a twelfth of their square
    EXPECT_NEAR(rmsAboutMean(bends) / std::sqrt(6.0), std::hypot(0.05, 0.0625 / std::sqrt(12.0)), 0.01);
  }
  EXPECT_GT(rmsAboutMean(offsets), 0.02);
  EXPECT_LT(rmsAboutMean(offsets), 0.6);
}

TEST(Roughness, SensorsLagByAHalfToFiveMinutes) {
  for (const std::uint64_t seed : {1, 2, 3, 4}) {
    const Simulation s = simulated(withNoise(150), "sensors", seed);
    const Series& air = *std::find_if(s.session.temperatures.begin(), s.session.temperatures.end(),
                                      [](const Series& series) { return series.name == "air"; });
    double best = 0.0, least = 1e9;
    for (double lag = 0.0; lag < 400.0; lag += 5.0) {
      std::vector<double> off;  // by the sensor's own offset, besides
      for (double t = 900.0; t < air.time.back(); t += 10.0)
        off.push_back(air.at(t) - s.truth->temperature(3, t - lag));
      if (rmsAboutMean(off) < least) least = rmsAboutMean(off), best = lag;
    }
    // a swing of a period of 600 s is late by atan(2 pi lag / 600) of it
    const double lag = Random(seed, "rough sensor air").logUniform(30.0, 300.0);
    EXPECT_NEAR(best, std::atan(2.0 * kPi * lag / 600.0) * 600.0 / (2.0 * kPi), 15.0) << lag;
  }
}

TEST(Roughness, TheSameSeedGivesTheSameBits) {
  const Simulation a = simulated(withNoise(60), "all,quantised", 7),
                   b = simulated(withNoise(60), "all,quantised", 7),
                   c = simulated(withNoise(60), "all,quantised", 8);
  for (std::size_t i = 0; i < a.states.size(); ++i)
    EXPECT_EQ(a.session.observations[i].position, b.session.observations[i].position);
  EXPECT_EQ(a.session.temperatures[0].value, b.session.temperatures[0].value);
  EXPECT_NE(a.session.temperatures[0].value, c.session.temperatures[0].value);
  EXPECT_NE(a.session.observations[5].position, c.session.observations[5].position);
}

TEST(Roughness, WithNoneOfItNothingChanges) {
  const Simulation a = simulated(withNoise(60), ""), b = simulated(withNoise(60, "  rough: none\n"), "none"),
                   c = simulated(withNoise(60, "  rough: all\n"), "none");
  for (std::size_t i = 0; i < a.states.size(); ++i) {
    EXPECT_EQ(a.session.observations[i].position, b.session.observations[i].position);
    EXPECT_EQ(a.session.observations[i].position, c.session.observations[i].position);
  }
}

/// A kind whose error is made of all that the session goes through, at most its size.
const std::vector<SourceKind>& kindsByVisits() {
  static const std::vector<SourceKind> kinds = {
      {"visits", {}, {{"size", "m", 1e-6, 4e-6}}, [](const Making& m) {
         double sum = 0.0;
         for (const Condition& c : m.workshop.visits())
           sum += c.time * c.drive[0] + c.velocity[1] + c.bodies[0];
         m.add([sum](const Instant& i, Distortion& d) { d.travel[0] += i.number("size") * std::sin(sum); });
       }}};
  return kinds;
}

TEST(Roughness, WhatIsHiddenIsTheSameOnARoughMachine) {
  for (const std::vector<SourceKind>* kinds : {&sourceKinds(), &kindsByVisits()})
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
      const auto hiding = [&](const char* rough) {
        return simulated(withNoise(40), rough, seed, {"random"}, *kinds);
      };
      const Simulation smooth = hiding(""), rough = hiding("all,quantised");
      ASSERT_EQ(smooth.hidden.size(), 1u);
      EXPECT_EQ(smooth.hidden[0].text(), rough.hidden[0].text());
      // the error that it makes, to the last bit: roughness away, it is the same instrument
      const Simulation drifting = hiding("drift");
      ASSERT_EQ(drifting.truth->physics().sources.size(), smooth.truth->physics().sources.size() + 3u);
      for (std::size_t i = 0; i < smooth.states.size(); i += 7) {
        Condition now;
        now.time = smooth.states[i].time;
        now.drive = now.slide = smooth.states[i].position;
        now.velocity = smooth.states[i].velocity;
        now.bodies.assign(8, 22.0);
        now.covariates.assign(4, 45.0);
        const auto& sources = drifting.truth->physics().sources;
        for (std::size_t k = 0; k < smooth.truth->physics().sources.size(); ++k) {
          Distortion a(3), b(3);
          smooth.truth->physics().sources[k](now, a);
          sources[k + 3](now, b);
          EXPECT_EQ(a.travel, b.travel) << smooth.hidden[0].text();
          EXPECT_EQ(a.tipShift, b.tipShift) << smooth.hidden[0].text();
        }
      }
    }
}

TEST(Roughness, MeasuredLengthsAndAnglesAreRoughToo) {
  const Machine machine = Machine::load("five_axis");
  const auto measure = [&](const std::string& joint, const std::string& range, const std::string& rough) {
    const std::string yaml =
        "reference: [{joint: " + joint + ", " + range + R"(, points: 21, runs: 8, dwell_s: 5}]
instrument: {noise: {repeatability_um: 0.3, reference_um: 0.1, reference_arcsec: 0.2}}
)";
    SimulationRequest request;
    request.rough = rough;
    return simulate(machine, Plan::parse(yaml, "plan.yaml", ".", machine), request);
  };
  const int x = machine.findJoint("x"), b = machine.findJoint("b");
  for (const auto& [joint, name, range, size] :
       {std::tuple(x, "x", "from_mm: 10, to_mm: 150", 0.1e-6),
        std::tuple(b, "b", "from_deg: -60, to_deg: 60", 0.2 * kArcsecond)}) {
    const Simulation clean = measure(name, range, ""), drift = measure(name, range, "drift=4"),
                     steps = measure(name, range, "quantised"),
                     correlated = measure(name, range, "correlated");
    std::vector<double> moved, noise;
    for (std::size_t i = 0; i < clean.states.size(); ++i) {
      moved.push_back(drift.session.observations[i].deviation[joint] -
                      clean.session.observations[i].deviation[joint]);
      noise.push_back(correlated.session.observations[i].deviation[joint]);
      const double step = steps.session.observations[i].deviation[joint] / (3.0 * size);
      EXPECT_NEAR(step, std::round(step), 1e-6);
    }
    EXPECT_NEAR(rmsAboutMean(moved), 4.0 * size, 0.02 * size) << name;
    EXPECT_NEAR(memory(noise), 0.7, 0.15) << name;
    EXPECT_NEAR(rmsAboutMean(noise), size, 0.3 * size) << name;
  }
}

TEST(Roughness, TheTruthSaysHowRoughTheSessionIs) {
  SimulationRequest request;
  request.rough = "drift=2";
  const Machine machine = Machine::load("three_axis");
  const Plan plan = Plan::parse(withNoise(4, "  rough: form\n"), "plan.yaml", ".", machine);
  EXPECT_NE(truthYaml(simulate(machine, plan, request), request).find("rough: drift=2,form=1\n"),
            std::string::npos);
  EXPECT_EQ(truthYaml(simulated(withNoise(4), ""), {}).find("rough"), std::string::npos);
}

}  // namespace
}  // namespace mm
