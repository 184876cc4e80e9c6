// Lengths from stations of unknown place to the tip, as a tracking interferometer and a ball bar give them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <sstream>

#include "base/error.h"
#include "diagnosis/diagnose.h"
#include "estimation/calibrate.h"
#include "model/observed_domain.h"
#include "random_numbers.h"
#include "read_contacts.h"
#include "session/artifact_file.h"
#include "session_files.h"

namespace mm {
namespace {

using ::testing::HasSubstr;
using Vectors = std::vector<Eigen::Vector3d>;

/// Measures lengths with physics of its own: mm.
class Stations {
 public:
  Vectors stations = {{-350, -120, 60}, {80, -420, 150}, {60, 90, 500}, {300, 280, -40}};
  double scale = 40e-6, square = 60e-6, play = 0.0, noise = 1e-4;
  bool fromZero = false;  // each instrument counts from where it stood first
  bool knowsWays = true;  // velocities are recorded
  std::uint64_t seed = 1;

  std::string csv() const {
    test_support::RandomNumbers random(seed);
    std::string text =
        "time_s,x_mm,y_mm,z_mm,x_velocity_mm_s,y_velocity_mm_s,z_velocity_mm_s,feature,setup,length_mm\n";
    Eigen::Vector3d last(-16, -16, -8), way(1, 1, 1);
    int time = 0;
    for (std::size_t s = 0; s < stations.size(); ++s) {
      double zero = std::nan("");
      for (const Eigen::Vector3d& q : places()) {
        for (int k = 0; k < 3; ++k)
          if (q[k] != last[k]) way[k] = q[k] > last[k] ? 1.0 : -1.0;
        last = q;
        const Eigen::Vector3d tip =
            q + Eigen::Vector3d(scale * q[0] + square * q[1] - 0.5 * play * way[0], 0.0, 0.0);
        const double length = (tip - stations[s]).norm();
        if (std::isnan(zero)) zero = fromZero ? length : 0.0;
        char row[160];
        std::snprintf(row, sizeof row, "%d,%g,%g,%g,%g,%g,%g,T%zu,%s,%.6f\n", time += 3, q[0], q[1], q[2],
                      way[0], way[1], way[2], s + 1, fromZero ? ("S" + std::to_string(s)).c_str() : "",
                      length - zero + random.normal(noise));
        text += row;
      }
    }
    return text;
  }

  static Vectors places() {
    Vectors all;
    for (const double z : {-7.0, 0.0, 7.0})
      for (const double y : {-15.0, -5.0, 5.0, 15.0})
        for (const double x : {-15.0, -7.0, 0.0, 7.0, 15.0}) all.emplace_back(x, y, z);
    Vectors back(all.rbegin() + 1, all.rend());
    all.insert(all.end(), back.begin(), back.end());
    return all;
  }
};

class Lengths : public ::testing::Test {
 protected:
  Artifact artifactOf(const std::string& points = "free") const {
    std::string text = "name: stations\npoints:\n";
    for (int s = 1; s <= 4; ++s) text += "  - {name: T" + std::to_string(s) + ", position: " + points + "}\n";
    return parseArtifact(text, "stations.yaml");
  }
  Session read(const std::string& csv) const {
    const Artifact artifact = artifactOf();
    return readContactsCsv(folder_.write("l.csv", csv), Machine::load("three_axis"), &artifact);
  }
  static CalibrationResult fitted(const Session& session) {
    CalibrateOptions options;
    options.method = Method::kLeastSquares;
    return calibrate(session, modelOf(session), options);
  }
  static Model modelOf(const Session& session) {
    return Model(
        session.machine, observedDomain(session),
        {EffectSpec("scale").set("axis", "x"), EffectSpec("squareness").set("axis", "x").set("of", "y")});
  }
  std::string refusal(const std::string& csv) const {
    return test::messageOf<InputError>([&] { read(csv); });
  }
  test::Folder folder_;
};

TEST_F(Lengths, TellTheMachineAndWhereTheStationsAre) {
  for (const bool fromZero : {false, true}) {
    Stations truth;
    truth.fromZero = fromZero;
    const CalibrationResult r = fitted(read(truth.csv()));
    EXPECT_NEAR(r.x[0], truth.scale, 4.0 * r.std(0)) << fromZero;
    EXPECT_NEAR(r.x[1], truth.square, 4.0 * r.std(1)) << fromZero;
    EXPECT_NEAR(r.figures.rms, 1e-3 * truth.noise, 1e-8) << fromZero;
    for (int s = 0; s < 4; ++s) {
      const int at = r.problem->find(UnknownKind::kFeature, s);
      const Eigen::Vector3d found = 1e3 * r.problem->featureInArtifact(s, r.x);
      for (int k = 0; k < 3; ++k)
        EXPECT_NEAR(found[k], truth.stations[static_cast<std::size_t>(s)][k], 4e3 * r.std(at + k))
            << fromZero << s << k;
      EXPECT_EQ(r.problem->find(UnknownKind::kSetup, s) >= 0, fromZero);
    }
  }
}

/// A length touches nothing: a stylus that has lobes leaves it as it is.
TEST_F(Lengths, AreNoTouches) {
  const Session session = read(Stations().csv());
  const Problem problem(
      session, Model(session.machine, observedDomain(session),
                     {EffectSpec("scale").set("axis", "x"), EffectSpec("probe_lobing").set("order", 2)}));
  EXPECT_TRUE(problem.leftOut().empty());
}

/// One station, of which the instrument was switched off between: two zeros, and the first tells the start.
TEST_F(Lengths, CountFromAZeroOfTheirSetup) {
  Stations truth;
  truth.fromZero = true;
  truth.stations[1] = truth.stations[0];
  std::string csv = truth.csv();
  for (std::size_t at = 0; (at = csv.find(",T2,S1,", at)) != std::string::npos;)
    csv.replace(at, 7, ",T1,S9,");
  // the second zero 0.3 m away
  std::string moved;
  std::istringstream lines(csv);
  for (std::string line; std::getline(lines, line);) {
    if (const auto at = line.find(",S9,"); at != std::string::npos)
      line = line.substr(0, at + 4) + std::to_string(std::stod(line.substr(at + 4)) + 300.0);
    moved += line + "\n";
  }
  const CalibrationResult r = fitted(read(moved));
  EXPECT_NEAR(r.figures.rms, 1e-3 * truth.noise, 1e-8);
  const Eigen::Vector3d found = 1e3 * r.problem->featureInArtifact(0, r.x);
  const int at = r.problem->find(UnknownKind::kFeature, 0);
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(found[k], truth.stations[0][k], 4e3 * r.std(at + k)) << k;
}

TEST_F(Lengths, AHiddenPlayIsNamed) {
  Stations truth;
  truth.play = 3e-3;
  const Session session = read(truth.csv());
  const Diagnosis d = diagnose(session, modelOf(session), {});
  ASSERT_EQ(d.missing.size(), 1U) << d.sentence;
  EXPECT_EQ(d.missing[0].effect.type, "backlash") << d.sentence;
}

TEST_F(Lengths, DerivativesAreThoseOfTheResidual) {
  Stations truth;
  truth.fromZero = true;
  const Session session = read(truth.csv());
  const Problem problem(session, modelOf(session));
  Eigen::VectorXd x = problem.start();
  for (int u = 0; u < problem.unknownCount(); ++u) x[u] += 0.1 * problem.unknowns()[u].scale;
  Model::Workspace work;
  Problem::Derivative derivative;
  Eigen::MatrixXd rows;
  for (const int o : {0, 200, 400}) {
    double r = 0.0, above = 0.0, below = 0.0;
    ASSERT_EQ(problem.residualsOf(o, x, &r, &derivative, work), 1);
    problem.scatter(o, derivative, rows);
    for (int u = 0; u < problem.unknownCount(); ++u) {
      const double step = 1e-2 * problem.unknowns()[u].scale;
      Eigen::VectorXd moved = x;
      moved[u] = x[u] + step;
      problem.residualsOf(o, moved, &above, nullptr, work);
      moved[u] = x[u] - step;
      problem.residualsOf(o, moved, &below, nullptr, work);
      EXPECT_NEAR(rows(0, u), (above - below) / (2.0 * step), 1e-6 * (1.0 + std::abs(rows(0, u))))
          << problem.unknowns()[u].name;
    }
  }
}

TEST_F(Lengths, RefusalsSayWhatToDo) {
  const std::string header = "time_s,x_mm,y_mm,z_mm,feature,setup,length_mm\n";
  EXPECT_THAT(refusal(header + "0,1,2,3,,,5\n"),
              HasSubstr("'feature' must name the point of the artifact file"));
  EXPECT_THAT(refusal(header + "0,1,2,3,T1,,-5\n"), HasSubstr("need a 'setup'"));
  EXPECT_THAT(refusal(header + "0,1,2,3,T9,,5\n"), HasSubstr("feature 'T9' is not in artifact"));
  std::string plane = header;  // tips on a plane: the station or its mirror image
  for (int i = 0; i < 16; ++i)
    plane += std::to_string(i) + "," + std::to_string(i % 4) + "," + std::to_string(i / 4) + ",0,T1,," +
             std::to_string(100 + i % 4) + "\n";
  EXPECT_THAT(refusal(plane), HasSubstr("where 'T1' is cannot be determined from its 16 lengths"));
}

}  // namespace
}  // namespace mm
