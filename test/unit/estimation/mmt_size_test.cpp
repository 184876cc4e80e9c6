// MMT at its size, from the simulated session to the corrected point, on the way that `mm calibrate` takes:
// 70 ball positions x 233 contacts, 21 constants, the centres unknown, 0.5 um noise.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <map>
#include <random>
#include <set>

#include "compensation/compensator.h"
#include "long_tests.h"
#include "simulation/simulate.h"
#include "workflow/recalibration.h"

namespace mm {
namespace {

constexpr double kPlanNoise = 0.5e-6;  // m, of the plan

const Simulation& simulation() {
  static const Simulation kSimulation = [] {
    const Machine machine = Machine::load("three_axis");
    SimulationRequest request;
    request.seed = 7;
    return simulate(machine, Plan::load("config/plans/micro_machine_tool.yaml", machine), request);
  }();
  return kSimulation;
}

ModelSpec mmtSpec(const std::vector<std::string>& axes = {"x", "y", "z"}) {
  ModelSpec model;
  for (const std::string& axis : axes)
    model.effects.push_back(EffectSpec("mmt_deviation").set("axis", axis).set("lead_mm", 1.0));
  return model;
}

CalibrateOptions optionsOf(Method method, std::uint64_t seed, unsigned threads = 0) {
  CalibrateOptions options;
  options.method = method;
  options.seed = seed;
  options.threads = threads;
  return options;
}

/// By method and seed, each calibrated once.
const Recalibration& calibrated(Method method, std::uint64_t seed) {
  static std::map<std::pair<Method, std::uint64_t>, Recalibration> kDone;
  const auto key = std::make_pair(method, seed);
  auto found = kDone.find(key);
  if (found == kDone.end())
    found = kDone.emplace(key, recalibrate(simulation().session, mmtSpec(), optionsOf(method, seed))).first;
  return found->second;
}

std::set<std::string> fixedNames(const CalibrationResult& result) {
  std::set<std::string> names;
  for (int u = 0; u < result.problem->unknownCount(); ++u)
    if (result.identifiability.fixed[static_cast<std::size_t>(u)] != 0)
      names.insert(result.problem->unknowns()[static_cast<std::size_t>(u)].name);
  return names;
}

/// RMS (m, per component) of what is left between two fields of points after the best rigid motion.
double rmsModuloMotion(const Eigen::Matrix3Xd& from, const Eigen::Matrix3Xd& to) {
  const Eigen::Matrix4d motion = Eigen::umeyama(from, to, false);
  const Eigen::Matrix3Xd moved =
      (motion.topLeftCorner<3, 3>() * from).colwise() + motion.topRightCorner<3, 1>();
  return std::sqrt((moved - to).squaredNorm() / static_cast<double>(3 * to.cols()));
}

/// RMS and largest distance that corrected points miss the truth by, at fresh points of the calibrated
/// volume, after the best rigid motion.
double fieldError(const Recalibration& done, bool correct = true) {
  constexpr int kPoints = 1000;
  const Compensator compensator(done.calibration);
  std::mt19937_64 generator(99);
  Eigen::Matrix3Xd corrected(3, kPoints), truth(3, kPoints);
  for (int i = 0; i < kPoints; ++i) {
    TrueState at;
    State state = compensator.blankState();
    for (std::size_t j = 0; j < 3; ++j) {
      std::uniform_real_distribution<double> inside(done.calibration.domain.lower[j],
                                                    done.calibration.domain.upper[j]);
      at.position.push_back(inside(generator));
    }
    at.velocity.assign(3, 0.0);
    at.travel.assign(3, 0.0);
    state.position = at.position;
    compensator.model().place(state);
    const Correction c = compensator.apply(state);
    EXPECT_TRUE(c.valid) << c.reason;
    corrected.col(i) = correct ? c.corrected.position : c.nominal.position;
    truth.col(i) = simulation().truth->position(at);
  }
  return rmsModuloMotion(corrected, truth);
}

TEST(MmtSize, ThreeRotationsAreLostAndFixedByConvention) {
  const CalibrationResult& result = calibrated(Method::kStagedMutation, 1).result;
  ASSERT_EQ(result.problem->rowCount(), 70 * 233);
  EXPECT_EQ(result.identifiability.rank, 18);
  EXPECT_EQ(result.identifiability.parameters, 21);
  EXPECT_EQ(fixedNames(result), (std::set<std::string>{"alpha_xy", "alpha_xz", "alpha_yz"}));
  std::set<std::string> words;
  for (const LostDirection& lost : result.identifiability.lost) {
    words.insert(lost.inWords);
    EXPECT_TRUE(lost.byConvention) << lost.inWords;
    std::vector<double> parts;
    for (const auto& [unknown, part] : lost.direction)
      if (result.problem->unknowns()[static_cast<std::size_t>(unknown)].kind == UnknownKind::kEffect &&
          std::abs(part) > 0.02)
        parts.push_back(part);
    ASSERT_EQ(parts.size(), 2u) << lost.inWords;
    EXPECT_NEAR(parts[0], -parts[1], 0.02) << lost.inWords;
  }
  EXPECT_EQ(words, (std::set<std::string>{"alpha_yx and alpha_xy: only their sum is determined",
                                          "alpha_zx and alpha_xz: only their sum is determined",
                                          "alpha_zy and alpha_yz: only their sum is determined"}));
  EXPECT_FALSE(result.identifiability.incomplete());  // exit status 0
  EXPECT_TRUE(result.converged);
  for (int u = 0; u < 21; ++u) {
    if (result.identifiability.fixed[static_cast<std::size_t>(u)] != 0) {
      EXPECT_EQ(result.x[u], 0.0) << u;
    }
  }
}

TEST(MmtSize, TheConventionDoesNotDependOnTheOrderOfTheEffects) {
  const Session& session = simulation().session;
  for (const std::vector<std::string>& axes : {std::vector<std::string>{"z", "y", "x"}, {"y", "x", "z"}}) {
    const Problem problem(session, modelFor(session, mmtSpec(axes).effects));
    const Identifiability found =
        identify(problem, problem.start(), problem.sigmas(kPlanNoise, kPlanNoise).cwiseInverse(), true);
    EXPECT_EQ(found.rank, 18);
    std::set<std::string> fixed;
    for (int u = 0; u < problem.unknownCount(); ++u)
      if (found.fixed[static_cast<std::size_t>(u)] != 0)
        fixed.insert(problem.unknowns()[static_cast<std::size_t>(u)].name);
    EXPECT_EQ(fixed, (std::set<std::string>{"alpha_xy", "alpha_xz", "alpha_yz"}));
  }
}

TEST(MmtSize, TheGeneticAlgorithmComesNearTheOptimum) {
  const std::uint64_t seeds = mm_test::longTests() ? 5 : 1;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    const CalibrationResult& result = calibrated(Method::kStagedMutation, seed).result;
    ASSERT_TRUE(result.genetic);
    std::printf("seed %d: genetic %.4f um in %.2f s, refined %.4f um\n", static_cast<int>(seed),
                1e6 * result.genetic->rms, result.genetic->seconds, 1e6 * result.figures.rms);
    EXPECT_EQ(result.genetic->method, "staged_mutation");
    EXPECT_EQ(result.genetic->generations, 100u);
    EXPECT_NEAR(static_cast<double>(result.genetic->evaluations), 101.0 * 500.0,
                1.0);  // and the best once more
    ASSERT_EQ(result.genetic->curve.size(), 101u);
    EXPECT_GT(result.genetic->curve.front(), 10.0 * result.genetic->curve.back());
    EXPECT_LE(result.genetic->rms, 1.5 * result.figures.rms);
    EXPECT_GE(result.genetic->rms, (1.0 - 1e-6) * result.figures.rms);
  }
}

TEST(MmtSize, NichingIsWhatTheMethodSays) {
  CalibrateOptions options = optionsOf(Method::kNiching, 1);
  options.niching.population = 60;
  options.niching.generations = 20;
  const CalibrationResult result = recalibrate(simulation().session, mmtSpec(), options).result;
  ASSERT_TRUE(result.genetic);
  EXPECT_EQ(result.genetic->method, "niching");
  EXPECT_NEAR(static_cast<double>(result.genetic->evaluations), 21.0 * 60.0, 1.0);
  EXPECT_LT(result.genetic->rms, 0.9 * result.genetic->curve.front());
  const CalibrationResult& other = calibrated(Method::kStagedMutation, 1).result;
  EXPECT_NEAR(result.figures.rms, other.figures.rms, 1e-6 * other.figures.rms);
}

TEST(MmtSize, RefinedIsTheOptimum) {
  const CalibrationResult& refined = calibrated(Method::kStagedMutation, 1).result;
  const double free = refined.problem->unknownCount() - 3, rows = refined.problem->rowCount();
  // what is left of the noise, within four of its standard deviations
  EXPECT_NEAR(refined.figures.rms, kPlanNoise * std::sqrt(1.0 - free / rows),
              4.0 * kPlanNoise / std::sqrt(2.0 * rows));
  EXPECT_NEAR(refined.figures.chi2PerDof, 1.0, 4.0 * std::sqrt(2.0 / rows));
  EXPECT_NEAR(refined.figures.heldOutRms, kPlanNoise, 0.02 * kPlanNoise);
  EXPECT_TRUE(refined.outliers.empty());
  // no small step in any unknown goes further down
  const Eigen::VectorXd& r = refined.residuals;
  for (int u = 0; u < refined.problem->unknownCount(); u += 7) {
    if (refined.identifiability.fixed[static_cast<std::size_t>(u)] != 0) continue;
    for (const double side : {-0.3, 0.3}) {
      Eigen::VectorXd x = refined.x;
      x[u] += side * refined.std(u);
      EXPECT_GT(refined.problem->residuals(x).squaredNorm(), r.squaredNorm()) << u;
    }
  }
  const CalibrationResult& direct = calibrated(Method::kLeastSquares, 1).result;
  for (int u = 0; u < 21; ++u)
    EXPECT_NEAR(direct.x[u], refined.x[u], 1e-3 * std::max(refined.std(u), 1e-15)) << u;
}

TEST(MmtSize, TheFieldIsFoundToAFifthOfAMicrometre) {
  const Recalibration& done = calibrated(Method::kStagedMutation, 1);
  const double before = fieldError(done, false), after = fieldError(done);
  std::printf("field at 1,000 fresh points modulo a rigid motion: %.3f um, uncorrected %.1f um\n",
              1e6 * after, 1e6 * before);
  EXPECT_GT(before, 1e-6);
  EXPECT_LE(after, 0.2e-6);
}

using Figures = std::map<std::string, std::vector<double>>;

/// Everything that a calibration tells, but the seconds.
Figures figuresOf(const CalibrationResult& r) {
  const auto list = [](const auto& m) { return std::vector<double>(m.data(), m.data() + m.size()); };
  return {{"x", list(r.x)},
          {"residuals", list(r.residuals)},
          {"sigma", list(r.sigma)},
          {"weight", list(r.weight)},
          {"held out", list(r.heldOut)},
          {"covariance", list(r.covariance)},
          {"curve", r.genetic->curve},
          {"genetic", {r.genetic->rms, static_cast<double>(r.genetic->evaluations)}},
          {"figures", {r.repeatability, r.figures.rms, r.figures.heldOutRms, r.figures.chi2PerDof}},
          {"before", {r.before.rms, r.before.heldOutRms, r.before.chi2PerDof}},
          {"polish", {static_cast<double>(r.iterations), static_cast<double>(r.outliers.size())}}};
}

void expectSameBits(const Figures& a, const Figures& b, const std::string& what) {
  for (const auto& [name, values] : a) {
    const std::vector<double>& other = b.at(name);
    ASSERT_EQ(values.size(), other.size()) << what << ", " << name;
    std::size_t different = 0;
    for (std::size_t i = 0; i < values.size(); ++i)
      different += std::memcmp(&values[i], &other[i], sizeof(double)) != 0;
    EXPECT_EQ(different, 0u) << what << ", " << name << " of " << values.size();
  }
}

TEST(MmtSize, TheSameSeedGivesTheSameBitsWithOneAndTwoThreads) {
  MM_THOROUGH_ONLY(
      "every day SphereFitness.sameBitsWithOneAndTwoThreads asks it of the search, and "
      "Diagnose.TheSameBitsWhateverTheThreads of least squares");
  for (const Method method : {Method::kStagedMutation, Method::kNiching}) {
    const auto run = [&](unsigned threads) {
      CalibrateOptions options = optionsOf(method, 11, threads);
      options.stagedMutation.generations = mm_test::longTests() ? 100 : 15;
      options.niching.population = mm_test::longTests() ? 200 : 60;
      options.niching.generations = mm_test::longTests() ? 100 : 15;
      return figuresOf(recalibrate(simulation().session, mmtSpec(), options).result);
    };
    const Figures one = run(1);
    expectSameBits(one, run(2), nameOf(method) + ", 1 and 2 threads");
    if (mm_test::longTests()) expectSameBits(one, run(1), nameOf(method) + ", again");
  }
}

}  // namespace
}  // namespace mm
