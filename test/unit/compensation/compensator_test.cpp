#include "compensation/compensator.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <random>

#include "base/error.h"
#include "compensation_support.h"

namespace mm {
namespace {

using test::calibrationOf, test::kUnknown, test::mmtByHand, test::mmtCalibration, test::stateAt, test::value;

const Machine& threeAxis() {
  static const Machine machine = Machine::load("three_axis");
  return machine;
}

TEST(Compensator, appliesTheConstantsOfMmt) {
  const Calibration c = mmtCalibration(threeAxis());
  const Compensator compensator(c);
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> u(-0.02, 0.02);
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector3d q(u(random), u(random), u(random));
    const Correction done = compensator.apply(stateAt(compensator, {q.x(), q.y(), q.z()}));
    EXPECT_TRUE(done.valid) << done.reason;
    EXPECT_LT((done.corrected.position - mmtByHand(c, q)).norm(), 1e-15);
    EXPECT_LT((done.displacement - (mmtByHand(c, q) - q)).norm(), 1e-15);
    EXPECT_EQ(done.rotation.norm(), 0.0);
  }
}

TEST(Compensator, saysTheUncertaintyThatItsParametersHave) {
  Calibration c = mmtCalibration(threeAxis());
  std::mt19937_64 random(2);
  std::normal_distribution<double> normal;
  Eigen::MatrixXd root(21, 21);
  for (int i = 0; i < 21; ++i)
    for (int j = 0; j < 21; ++j) root(i, j) = 1e-6 * normal(random);
  c.covariance = root * root.transpose();
  const Eigen::Vector3d q(0.012, -0.007, 0.018);
  const Compensator compensator(c);
  const Correction done = compensator.apply(stateAt(compensator, {q.x(), q.y(), q.z()}));

  Eigen::Matrix3d sampled = Eigen::Matrix3d::Zero();
  const int samples = 20000;
  for (int s = 0; s < samples; ++s) {
    Eigen::VectorXd z(21);
    for (int i = 0; i < 21; ++i) z[i] = normal(random);
    const Eigen::VectorXd shift = root * z;
    Calibration other = c;
    for (int i = 0; i < 21; ++i) other.values[i].value += shift[i];
    const Eigen::Vector3d d = mmtByHand(other, q) - mmtByHand(c, q);
    sampled += d * d.transpose() / samples;
  }
  EXPECT_LT((done.covariance - sampled).norm(), 0.03 * sampled.norm());
  EXPECT_NEAR(done.sigma, std::sqrt(sampled.trace() / 3), 0.02 * done.sigma);

  Compensator::Options fast;
  fast.sigma = false;
  const Compensator without(c, fast);
  const Correction quick = without.apply(stateAt(without, {q.x(), q.y(), q.z()}));
  EXPECT_EQ(quick.sigma, 0.0);
  EXPECT_EQ(quick.corrected.position, done.corrected.position);
}

TEST(Compensator, correctsTheOrientation) {
  Calibration c = calibrationOf(Machine::load("five_axis"),
                                {EffectSpec("formula").set("direction", "b").set("formula", "k1"),
                                 EffectSpec("formula").set("direction", "x").set("formula", "k1")});
  c.values[0].value = 100 * kArcsecond / c.values[0].toUnit;
  const Compensator probe(c);
  // Whatever unit the constant has, its effect is seen against the nominal chain.
  const State state = stateAt(probe, {0, 0, 0, 0.3, 0.4});
  const Correction done = probe.apply(state);
  ASSERT_TRUE(done.valid) << done.reason;
  const double turned = done.rotation.norm();
  EXPECT_GT(turned, 0.0);
  const double q[] = {0, 0, 0, 0.3 + turned, 0.4}, back[] = {0, 0, 0, 0.3 - turned, 0.4};
  const double miss = std::min(
      (probe.model().machine().nominal(q, kUnknown).orientation - done.corrected.orientation).norm(),
      (probe.model().machine().nominal(back, kUnknown).orientation - done.corrected.orientation).norm());
  EXPECT_LT(miss, 1e-12);
}

TEST(Compensator, isNotValidBeyondTheMargin) {
  const Compensator compensator(mmtCalibration(threeAxis()));  // range 40 mm, margin 4 mm
  EXPECT_TRUE(compensator.apply(stateAt(compensator, {0.0239, 0, -0.0239})).valid);
  const Correction out = compensator.apply(stateAt(compensator, {0, 0.0241, 0}));
  EXPECT_FALSE(out.valid);
  EXPECT_TRUE(out.extrapolating);
  EXPECT_NE(out.reason.find("y = 24.1 mm"), std::string::npos) << out.reason;
  EXPECT_TRUE(out.corrected.position.allFinite());

  Compensator::Options strict;
  strict.margin = 0.0;
  const Compensator exact(mmtCalibration(threeAxis()), strict);
  EXPECT_TRUE(exact.apply(stateAt(exact, {0.020, 0, 0})).valid);
  EXPECT_FALSE(exact.apply(stateAt(exact, {0.0201, 0, 0})).valid);
  strict.margin = -0.1;
  EXPECT_THROW(Compensator(mmtCalibration(threeAxis()), strict), InputError);
}

TEST(Compensator, needsTheTemperatureThatItsModelUsesAndNoOther) {
  Calibration c =
      calibrationOf(threeAxis(), {EffectSpec("thermal_growth").set("direction", "z").set("sensor", "bed")});
  c.values[0].value = 2e-6;
  const Compensator compensator(c);
  State state = stateAt(compensator, {0, 0, 0});
  const Correction lost = compensator.apply(state);
  EXPECT_FALSE(lost.valid);
  EXPECT_TRUE(lost.inputLost);
  EXPECT_NE(lost.reason.find("bed"), std::string::npos);

  state.temperature[0] = 24.0;
  const Correction done = compensator.apply(state);
  EXPECT_TRUE(done.valid) << done.reason;
  EXPECT_NEAR(done.displacement.z(), 8e-6, 1e-15);

  state.temperature[0] = 26.9;  // range 8 K, margin 0.8 K
  const Correction hot = compensator.apply(state);
  EXPECT_FALSE(hot.valid);
  EXPECT_TRUE(hot.extrapolating);
  EXPECT_NE(hot.reason.find("26.9"), std::string::npos) << hot.reason;

  state.temperature = {20.0, 50.0};
  const Correction other = compensator.apply(state);
  EXPECT_TRUE(other.valid);
  EXPECT_NE(other.note.find("air"), std::string::npos);
}

/// What acts on a touch alone says nothing of where the probe is: its temperature may be anything.
TEST(Compensator, needsNoInputOfWhatIsTouched) {
  Calibration c = calibrationOf(threeAxis(), {EffectSpec("artifact_expansion").set("sensor", "air"),
                                              EffectSpec("probe_lobing").set("order", 2)});
  c.domain.features = {"b0"};
  c.domain.featureRadius = {0.004};
  const Compensator compensator(c);
  State state = stateAt(compensator, {0, 0, 0});
  state.temperature = {20.0, 50.0};
  const Correction hot = compensator.apply(state);
  EXPECT_TRUE(hot.valid) << hot.reason;
  EXPECT_NE(hot.note.find("air"), std::string::npos) << hot.note;
  state.temperature[1] = kUnknown;
  EXPECT_TRUE(compensator.apply(state).valid);
}

TEST(Compensator, doesNotGuessTheDirectionOfTravel) {
  Calibration c = calibrationOf(threeAxis(), {EffectSpec("backlash").set("axis", "y")});
  c.values[0].value = 4e-6;
  const Compensator compensator(c);
  State state = stateAt(compensator, {0, 0, 0});
  const Correction unknown = compensator.apply(state);
  EXPECT_FALSE(unknown.valid);
  EXPECT_NE(unknown.reason.find("direction of travel of y"), std::string::npos) << unknown.reason;
  state.travel[1] = 1.0;
  EXPECT_NEAR(compensator.apply(state).displacement.y(), -2e-6, 1e-15);
}

TEST(Compensator, refusesWhatIsNotANumber) {
  const Compensator compensator(mmtCalibration(threeAxis()));
  State state = stateAt(compensator, {0, 0, 0});
  state.position[2] = kUnknown;
  const Correction done = compensator.apply(state);
  EXPECT_FALSE(done.valid);
  EXPECT_NE(done.reason.find("z"), std::string::npos);
  state.position.pop_back();
  EXPECT_THROW(compensator.apply(state), InputError);
}

TEST(Compensator, leavesEffectsOfTimeOutBeyondTheirTime) {
  Calibration c =
      calibrationOf(threeAxis(), {EffectSpec("scale").set("axis", "x"),
                                  EffectSpec("formula").set("direction", "x").set("formula", "k1*t")});
  c.values[0].value = 1e-4;
  c.values[1].value = 1e-3 * (c.values[1].toUnit == 1e6 ? 1e-6 : 1.0);
  const Compensator compensator(c);
  State state = stateAt(compensator, {0.010, 0, 0});
  state.time = 900;
  const Correction young = compensator.apply(state);
  EXPECT_TRUE(young.valid) << young.reason;
  EXPECT_FALSE(young.tooOld);
  EXPECT_GT(std::abs(young.displacement.x() - 1e-6), 1e-9);
  state.time = 1001;
  const Correction old = compensator.apply(state);
  EXPECT_TRUE(old.valid) << old.reason;
  EXPECT_TRUE(old.tooOld);
  EXPECT_NE(old.note.find("formula"), std::string::npos) << old.note;
  EXPECT_NEAR(old.displacement.x(), 1e-6, 1e-15);
}

TEST(Compensator, refusesACalibrationOfOtherParameters) {
  Calibration c = mmtCalibration(threeAxis());
  c.values[3].name = "other";
  EXPECT_THROW(Compensator{c}, InputError);
  c = mmtCalibration(threeAxis());
  c.values.pop_back();
  EXPECT_THROW(Compensator{c}, InputError);
  c = mmtCalibration(threeAxis());
  c.values[0].value = kUnknown;
  EXPECT_THROW(Compensator{c}, InputError);
  c = mmtCalibration(threeAxis());
  c.urdf = Machine::load("five_axis").urdf();
  EXPECT_THROW(Compensator{c}, InputError);
}

TEST(Compensator, sigmaSaysThatPlayIsBeingTakenUp) {
  Calibration c = test::calibrationOf(Machine::load("three_axis"), {EffectSpec("backlash").set("axis", "x")});
  c.values[0].value = 4e-6;
  const Compensator compensator(c);
  MovingState state = test::stateAt(compensator, {0.001, 0, 0});
  state.travel = {1, 1, 1};
  const double settled = compensator.apply(state).sigma;
  for (const auto& [since, left] : {std::pair{0.0, 4e-6}, {1e-6, 3e-6}, {3.9e-6, 0.1e-6}, {5e-6, 0.0}}) {
    state.sinceReversal = {since, 0, 0};  // y and z have no play
    const Correction now = compensator.apply(state);
    ASSERT_TRUE(now.valid) << now.reason;
    EXPECT_NEAR(now.sigma, std::sqrt(settled * settled + left * left / 3.0), 1e-12) << since;
    EXPECT_EQ(now.note.find("backlash of x is being taken up") != std::string::npos, left > 0.0) << now.note;
  }
  state.sinceReversal = {test::kUnknown, 0, 0};
  EXPECT_EQ(compensator.apply(state).sigma, settled);
  // too little to be called a reversal, and already of the play
  for (const auto& [back, off] : {std::pair{0.0, 0.0}, {0.9e-6, 0.9e-6}, {9e-6, 4e-6}}) {
    state.back = {back, 0, 0};
    EXPECT_NEAR(compensator.apply(state).sigma, std::sqrt(settled * settled + off * off / 3.0), 1e-12)
        << back;
  }
}

/// A past in which the lag of the one sensor is elsewhere.
class Past final : public YoungHistory {
 public:
  explicit Past(double value, const Past* other = nullptr) : value_(value), other_(other) {}
  double lagged(int, double, double, double* byTau) const override {
    if (byTau != nullptr) *byTau = 0.0;
    return value_;
  }
  const TemperatureHistory* otherPast() const override { return other_; }

 private:
  double value_;
  const Past* other_;
};

TEST(Compensator, sigmaSaysThatThePastOfATemperatureIsNotKnown) {
  Calibration c = test::calibrationOf(
      Machine::load("three_axis"),
      {EffectSpec("thermal_growth").set("direction", "z").set("sensor", "bed").set("lag", "true")});
  c.values[0].value = 2e-6;   // m/K
  c.values[1].value = 100.0;  // s
  const Compensator compensator(c);
  State state = test::stateAt(compensator, {0.001, 0, 0});
  state.temperature.assign(state.temperature.size(), 24.0);
  const Past elsewhere(21.0), known(24.0), young(24.0, &elsewhere);
  state.history = &known;
  const Correction settled = compensator.apply(state);
  ASSERT_TRUE(settled.valid) << settled.reason;
  EXPECT_FALSE(settled.pastUnknown);
  state.history = &young;
  const Correction now = compensator.apply(state);
  EXPECT_TRUE(now.pastUnknown);
  EXPECT_EQ(now.displacement, settled.displacement);
  EXPECT_NEAR(now.sigma, std::sqrt(settled.sigma * settled.sigma + 36e-12 / 3.0), 1e-12) << "3 K of 2 um/K";
  EXPECT_NE(now.note.find("may be wrong by 6 um"), std::string::npos) << now.note;
}

}  // namespace
}  // namespace mm
