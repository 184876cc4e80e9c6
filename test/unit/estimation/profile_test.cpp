// A profile finds a smooth function that is no effect of the catalogue, says how well, and where it holds.
// The truth is made of bumps of its own.
#include "effects/profile.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "base/units.h"
#include "calibration_file/calibration_yaml.h"
#include "compensation/compensator.h"
#include "random_numbers.h"
#include "workflow/recalibration.h"

namespace mm {
namespace {

using test_support::RandomNumbers;

constexpr double kProfileNoise = 0.3e-6;  // m
constexpr double kDuration = 3600.0;

double bump(double x, double at, double width) { return std::exp(-std::pow((x - at) / width, 2)); }

/// um, of x in mm over -20 to 20.
double bumpy(double x) { return 3.0 * bump(x, 6.0, 5.0) - 2.0 * bump(x, -10.0, 4.0) + 0.05 * x; }
/// um, of a temperature over 20 to 28 degC.
double bent(double t) { return t < 24.0 ? 0.0 : 0.35 * (t - 24.0) * (t - 24.0) / (1.0 + 0.2 * (t - 24.0)); }

/// The same up and down every quarter of an hour.
double bedAt(double time) { return 24.0 + 4.0 * std::sin(2.0 * kPi * time / 900.0); }

/// True minus indicated along x, um.
using Error = std::function<double(const Observation&)>;

Session base() {
  Session session(Machine::load("three_axis"));
  session.source = "test";
  session.artifact.repeatability = kProfileNoise;
  Series bed;
  bed.name = "bed";
  for (double t = 0.0; t <= kDuration; t += 5.0) {
    bed.time.push_back(t);
    bed.value.push_back(bedAt(t));
  }
  session.temperatures = {bed};
  return session;
}

/// Deviations of x at places all over the workspace.
Session deviations(int count, std::uint64_t seed, const Error& error) {
  Session session = base();
  RandomNumbers random(seed);
  for (int i = 0; i < count; ++i) {
    Observation o;
    o.kind = ObservationKind::kDeviation;
    o.time = kDuration * i / count;
    o.row = i + 2;
    o.position = {random.uniform(-20e-3, 20e-3), random.uniform(-15e-3, 35e-3),
                  random.uniform(-20e-3, 20e-3)};
    o.velocity = {random.uniform(-5e-3, 5e-3), 0.0, 0.0};
    o.deviation = {error(o) * kMicrometre + random.normal(kProfileNoise), kNotMeasured, kNotMeasured};
    o.deviationStd.assign(3, kNotMeasured);
    session.observations.push_back(o);
  }
  session.prepare();
  return session;
}

/// Contacts of a touch probe with nine balls whose places are known.
Session contacts(int count, std::uint64_t seed, const Error& error) {
  constexpr double kReach = 5e-3;  // radius of the balls and of the tip
  Session session = base();
  session.artifact.tipRadius = 1e-3;
  for (int b = 0; b < 9; ++b) {
    Feature ball;
    ball.name = "b" + std::to_string(b);
    ball.radius = kReach - session.artifact.tipRadius;
    ball.position =
        Eigen::Vector3d(-14e-3 + 14e-3 * (b % 3), -8e-3 + 17e-3 * (b / 3), -6e-3 + 2e-3 * (b % 4));
    session.artifact.features.push_back(ball);
  }
  RandomNumbers random(seed);
  for (int i = 0; i < count; ++i) {
    Observation o;
    o.time = kDuration * i / count;
    o.row = i + 2;
    o.feature = i % 9;
    const double turn = random.uniform(0.0, 2.0 * kPi), height = random.uniform(0.0, 0.9);
    const double across = std::sqrt(1.0 - height * height);
    const Eigen::Vector3d out(across * std::cos(turn), across * std::sin(turn), height);
    const Eigen::Vector3d tip = session.artifact.features[static_cast<std::size_t>(o.feature)].position +
                                (kReach + random.normal(kProfileNoise)) * out;
    o.approach = -out;
    o.velocity.assign(3, kNotMeasured);
    o.position = {tip.x(), tip.y(), tip.z()};
    for (int step = 0; step < 20; ++step)
      o.position[0] = tip.x() - error(o) * kMicrometre;  // corrected = nominal + error
    session.observations.push_back(o);
  }
  session.prepare();
  return session;
}

Recalibration recalibrated(const Session& session, const std::vector<EffectSpec>& effects) {
  ModelSpec model;
  model.effects = effects;
  CalibrateOptions options;
  options.method = Method::kLeastSquares;
  return recalibrate(session, model, options);
}

/// Where the compensator says the probe is along x, beside the reading; um.
Correction correctionAt(const Compensator& compensator, double x, double bed, double speed = 0.0) {
  State state = compensator.blankState();
  state.time = 10.0;
  state.position = {x, 0.0, 0.0};
  state.velocity = {speed, 0.0, 0.0};
  state.travel = {1.0, 1.0, 1.0};
  state.temperature = {bed};
  compensator.model().place(state);
  return compensator.apply(state);
}

/// Over a grid of the range: a curve has no mean of its own.
double meanOf(const std::function<double(double)>& f, double lower, double upper) {
  double sum = 0.0;
  for (int i = 0; i < 2000; ++i) sum += f(lower + (upper - lower) * (i + 0.5) / 2000) / 2000;
  return sum;
}

struct Judged {
  double rms = 0.0;  // um
  int inside = 0, asked = 0;
  double share() const { return static_cast<double>(inside) / asked; }
};

/// Against the truth at fresh places within the range.
void judge(const Recalibration& done, const std::function<double(double)>& truth, bool byTemperature,
           bool mean, Judged& judged) {
  const Domain& d = done.calibration.domain;
  const double unit = byTemperature ? 1.0 : kMillimetre;
  const double lower = (byTemperature ? d.sensorLower[0] : d.lower[0]) / unit;
  const double upper = (byTemperature ? d.sensorUpper[0] : d.upper[0]) / unit;
  const double level = mean ? meanOf(truth, lower, upper) : 0.0;
  const Compensator compensator(done.calibration);
  const int points = 41;
  double square = 0.0;
  for (int i = 0; i < points; ++i) {
    const double at = lower + (upper - lower) * (i + 0.37) / points;
    const Correction c =
        correctionAt(compensator, byTemperature ? 0.0 : at * unit, byTemperature ? at : 24.0);
    EXPECT_TRUE(c.valid) << c.reason;
    const double missed = c.displacement.x() / kMicrometre - (truth(at) - level);
    judged.inside += std::abs(missed) <= 1.959964 * std::sqrt(c.covariance(0, 0)) / kMicrometre;
    ++judged.asked;
    square += missed * missed / points;
  }
  judged.rms += std::sqrt(square);
}

const EffectSpec kOfX = EffectSpec("profile").set("direction", "x").set("variable", "x");
const EffectSpec kOfBed = EffectSpec("profile").set("direction", "x").set("variable", "bed");

TEST(Profile, findsBumpsFromDeviationsAndItsBandCoversThem) {
  Judged judged;
  const int sessions = 30;
  for (int s = 0; s < sessions; ++s) {
    const Session session =
        deviations(300, 100 + s, [](const Observation& o) { return bumpy(o.position[0] / kMillimetre); });
    const Recalibration done = recalibrated(session, {kOfX});
    EXPECT_TRUE(done.result.converged);
    EXPECT_TRUE(done.result.identifiability.lost.empty());
    EXPECT_NEAR(done.result.figures.chi2PerDof, 1.0, 0.35);
    judge(done, bumpy, false, true, judged);
  }
  std::printf("deviations: RMS %.3f um, band covers %.1f %%\n", judged.rms / sessions,
              100.0 * judged.share());
  EXPECT_LT(judged.rms / sessions, 0.09);  // 12 coefficients, 300 rows: 0.06 of noise alone
  EXPECT_GT(judged.share(), 0.90);
  EXPECT_LT(judged.share(), 0.985);
}

TEST(Profile, findsATemperatureCurveFromContacts) {
  Judged judged;
  const int sessions = 20;
  for (int s = 0; s < sessions; ++s) {
    const Session session = contacts(360, 200 + s, [](const Observation& o) { return bent(bedAt(o.time)); });
    // a tip that stays where it is takes up the mean: its place along x is what a constant would be
    const Recalibration done =
        recalibrated(session, {kOfBed, EffectSpec("formula").set("direction", "x").set("formula", "k1")});
    judge(done, bent, true, false, judged);
  }
  std::printf("contacts: RMS %.3f um, band covers %.1f %%\n", judged.rms / sessions, 100.0 * judged.share());
  EXPECT_LT(judged.rms / sessions, 0.15);
  EXPECT_GT(judged.share(), 0.90);
  EXPECT_LT(judged.share(), 0.99);
}

TEST(Profile, ofTwoVariablesFindsSumAndProduct) {
  const auto truth = [](double x, double bed) {
    return 0.05 * x + 0.3 * (bed - 24.0) + 1.5 * std::sin(x / 8.0) * (bed - 24.0) / 4.0;
  };
  const EffectSpec both = EffectSpec("profile").set("direction", "x").setList("variables", {"x", "bed"});
  Judged judged;
  double square = 0.0;
  for (int s = 0; s < 10; ++s) {
    const Session session = deviations(500, 300 + s, [&](const Observation& o) {
      return truth(o.position[0] / kMillimetre, bedAt(o.time));
    });
    const Recalibration done = recalibrated(session, {both});
    const Compensator compensator(done.calibration);
    for (int i = 0; i < 10; ++i)
      for (int j = 0; j < 10; ++j) {
        const double x = -19.0 + 38.0 * i / 9.0, bed = 20.2 + 7.6 * j / 9.0;
        const Correction c = correctionAt(compensator, x * kMillimetre, bed);
        ASSERT_TRUE(c.valid) << c.reason;
        const double missed = c.displacement.x() / kMicrometre - truth(x, bed);  // its mean is 0
        judged.inside += std::abs(missed) <= 1.959964 * std::sqrt(c.covariance(0, 0)) / kMicrometre;
        ++judged.asked;
        square += missed * missed / 1000.0;
      }
  }
  std::printf("two variables: RMS %.3f um, band covers %.1f %%\n", std::sqrt(square), 100.0 * judged.share());
  EXPECT_LT(std::sqrt(square), 0.12);
  EXPECT_GT(judged.share(), 0.85);
}

/// Where nothing was measured the curve must neither swing out nor pretend to know.
TEST(Profile, bridgesAGapSmoothlyAndSaysHowLittleItKnows) {
  Session session =
      deviations(300, 5, [](const Observation& o) { return bumpy(o.position[0] / kMillimetre); });
  auto& all = session.observations;
  all.erase(
      std::remove_if(all.begin(), all.end(),
                     [](const Observation& o) { return o.position[0] > -4e-3 && o.position[0] < 10e-3; }),
      all.end());
  const Recalibration done =
      recalibrated(session, {sizedProfile(profileSpec("x", {"x"}), 3e-6, modelFor(session, {}).domain())});
  EXPECT_TRUE(done.result.identifiability.lost.empty());
  const Compensator compensator(done.calibration);
  const double known = correctionAt(compensator, -10e-3, 24.0).sigma,
               gap = correctionAt(compensator, 3e-3, 24.0).sigma;
  EXPECT_GT(gap, 3.0 * known);
  EXPECT_LT(gap, 5e-6);
  EXPECT_LT(std::abs(correctionAt(compensator, 3e-3, 24.0).displacement.x()), 6e-6);
}

/// A handful of distinct places and more coefficients than that.
TEST(Profile, needsNoMorePlacesThanThereAre) {
  Session session = base();
  RandomNumbers random(8);
  for (int i = 0; i < 60; ++i) {
    Observation o;
    o.kind = ObservationKind::kDeviation;
    o.time = 60.0 * i;
    o.row = i + 2;
    o.position = {-20e-3 + 8e-3 * (i % 6), 0.0, 0.0};
    o.velocity.assign(3, kNotMeasured);
    o.deviation = {bumpy(o.position[0] / kMillimetre) * kMicrometre + random.normal(kProfileNoise),
                   kNotMeasured, kNotMeasured};
    o.deviationStd.assign(3, kNotMeasured);
    session.observations.push_back(o);
  }
  session.prepare();
  const Recalibration done =
      recalibrated(session, {sizedProfile(profileSpec("x", {"x"}), 2e-6, modelFor(session, {}).domain())});
  EXPECT_TRUE(done.result.converged);
  EXPECT_TRUE(done.result.identifiability.lost.empty());
  EXPECT_LT(done.result.figures.rms, 1.2 * kProfileNoise);
  const Compensator compensator(done.calibration);
  for (double x = -20e-3; x <= 20e-3; x += 1e-3)
    EXPECT_LT(std::abs(correctionAt(compensator, x, 24.0).displacement.x()), 5e-6) << x;
}

TEST(Profile, geneticMethodsEndWhereLeastSquaresDo) {
  const Session session =
      deviations(200, 9, [](const Observation& o) { return bumpy(o.position[0] / kMillimetre); });
  ModelSpec model;
  model.effects = {kOfX, EffectSpec("scale").set("axis", "x"), EffectSpec("backlash").set("axis", "x")};
  const Recalibration exact = recalibrated(session, model.effects);
  for (const Method method : {Method::kStagedMutation, Method::kNiching}) {
    CalibrateOptions options;
    options.method = method;
    options.stagedMutation.population = options.niching.population = 60;
    options.niching.generations = 40;
    const Recalibration done = recalibrate(session, model, options);
    EXPECT_TRUE(done.result.converged);
    for (std::size_t p = 0; p < exact.calibration.values.size(); ++p)
      EXPECT_NEAR(done.calibration.values[p].value, exact.calibration.values[p].value,
                  1e-3 * exact.calibration.values[p].std)
          << exact.calibration.values[p].name;
  }
}

TEST(Profile, isAddedKeptInTheFileAndTakenOut) {
  const Session session = deviations(
      250, 11, [](const Observation& o) { return bumpy(o.position[0] / kMillimetre) + bent(bedAt(o.time)); });
  CalibrateOptions options;
  options.method = Method::kLeastSquares;
  const Recalibration before = recalibrated(session, {kOfX});
  const Recalibration added = addEffect(session, before.calibration, kOfBed, options);
  EXPECT_LT(added.result.figures.rms, 0.6 * before.result.figures.rms);
  Calibration written = added.calibration;
  completeCalibration(written);
  const Calibration read = parseCalibration(calibrationYaml(written), "c.yaml");
  EXPECT_EQ(calibrationYaml(read), calibrationYaml(written));
  const Compensator first(added.calibration), second(read);
  for (const double x : {-18e-3, -3e-3, 12e-3}) {
    const Correction a = correctionAt(first, x, 23.0), b = correctionAt(second, x, 23.0);
    EXPECT_EQ(a.displacement, b.displacement);
    EXPECT_EQ(a.sigma, b.sigma);
    EXPECT_TRUE(b.valid) << b.reason;
  }
  const CalibrationResult compared = compareCalibration(session, read, options);
  EXPECT_NEAR(compared.figures.rms, added.result.figures.rms, 1e-3 * kProfileNoise);
  const Recalibration removed = removeEffect(session, read, kOfBed, options);
  EXPECT_NEAR(removed.result.figures.rms, before.result.figures.rms, 1e-3 * kProfileNoise);
}

TEST(Profile, isNotAppliedWhereItWasNotCalibrated) {
  const Session session = deviations(
      250, 12, [](const Observation& o) { return bent(bedAt(o.time)) + 0.2 * o.velocity[0] / kMillimetre; });
  const Compensator compensator(
      recalibrated(session,
                   {kOfBed, EffectSpec("profile").set("direction", "x").set("variable", "x_velocity")})
          .calibration);
  EXPECT_TRUE(correctionAt(compensator, 0.0, 28.5).valid);  // within the margin: as at the end
  EXPECT_NEAR(correctionAt(compensator, 0.0, 28.5).displacement.x(),
              correctionAt(compensator, 0.0, 28.0).displacement.x(), 1e-9);
  const Correction hot = correctionAt(compensator, 0.0, 35.0);
  EXPECT_FALSE(hot.valid);
  EXPECT_TRUE(hot.extrapolating);
  EXPECT_NE(hot.reason.find("temperature bed = 35 degC is outside"), std::string::npos) << hot.reason;
  EXPECT_TRUE(correctionAt(compensator, 0.0, 24.0, 5e-3).valid);
  const Correction fast = correctionAt(compensator, 0.0, 24.0, 9e-3);
  EXPECT_FALSE(fast.valid);
  EXPECT_TRUE(fast.extrapolating);
  EXPECT_NE(fast.reason.find("x_velocity = 9 mm/s is outside"), std::string::npos) << fast.reason;
  EXPECT_EQ(fast.displacement.x(), correctionAt(compensator, 0.0, 24.0, 8e-3).displacement.x());  // flat
  const Correction unknown = correctionAt(compensator, 0.0, kNotMeasured);
  EXPECT_FALSE(unknown.valid);
  EXPECT_NE(unknown.reason.find("temperature bed is not known"), std::string::npos) << unknown.reason;

  // of the time since the start: said, and left out, beyond the duration
  const Compensator timed(
      recalibrated(session, {EffectSpec("profile").set("direction", "x").set("variable", "t")}).calibration);
  State late = timed.blankState();
  late.time = 2.0 * kDuration;
  timed.model().place(late);
  const Correction old = timed.apply(late);
  EXPECT_TRUE(old.valid) << old.reason;
  EXPECT_TRUE(old.tooOld);
  EXPECT_NE(old.note.find("not applied: profile"), std::string::npos) << old.note;
  EXPECT_EQ(old.displacement.norm(), 0.0);
}

}  // namespace
}  // namespace mm
