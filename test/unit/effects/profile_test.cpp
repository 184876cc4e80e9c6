#include "effects/profile.h"

#include <gtest/gtest.h>

#include "base/error.h"
#include "base/units.h"
#include "effects/smooth_basis.h"
#include "effects_support.h"

namespace mm {
namespace {

TEST(SmoothBasis, isOrthonormalAndWithoutAMean) {
  const int n = 16, steps = 20000;
  const SmoothBasis basis(n, 2.0);
  std::vector<double> mean(n, 0.0), values(n);
  std::vector<std::vector<double>> product(n, std::vector<double>(n, 0.0));
  for (int s = 0; s < steps; ++s) {
    basis.values(-1.0 + (2.0 * s + 1.0) / steps, values.data());
    for (int i = 0; i < n; ++i) {
      mean[i] += values[i] / steps;
      for (int j = 0; j < n; ++j) product[i][j] += values[i] * values[j] / steps;
    }
  }
  for (int i = 0; i < n; ++i) {
    EXPECT_NEAR(mean[i], 0.0, 1e-5);
    for (int j = 0; j < n; ++j) EXPECT_NEAR(product[i][j], i == j ? 1.0 : 0.0, 1e-5) << i << " " << j;
  }
}

TEST(SmoothBasis, bendsNoMoreAtItsEndsThanABeamThatIsFreeThere) {
  const int n = 32;
  const SmoothBasis basis(n, 2.0);
  std::vector<double> end(n), before(n), beyond(n), inside(n);
  const double h = 1e-4;
  basis.values(1.0, end.data());
  basis.values(1.0 - h, before.data());
  basis.values(1.0 - 2.0 * h, inside.data());
  basis.values(1.5, beyond.data());
  EXPECT_NEAR(end[0], std::sqrt(3.0), 1e-12);
  for (int i = 0; i < n; ++i) {
    EXPECT_EQ(beyond[i], end[i]);  // flat beyond
    if (i > 0) {
      EXPECT_NEAR(std::abs(end[i]), 2.0, 1e-9);
    }
    EXPECT_NEAR((end[i] - 2.0 * before[i] + inside[i]) / (h * h), 0.0, 30.0 * (i + 1)) << i;
  }
}

TEST(SmoothBasis, priorFallsWithRoughnessAndHasUnitPower) {
  for (const double smoothness : {1.0, 2.0}) {
    const SmoothBasis basis(12, smoothness);
    double square = 0.0;
    for (int i = 0; i < 12; ++i) {
      square += basis.priorStd(i) * basis.priorStd(i);
      if (i > 1) {
        EXPECT_LT(basis.priorStd(i), basis.priorStd(i - 1));
      }
    }
    EXPECT_NEAR(square, 1.0, 1e-12);
  }
  EXPECT_EQ(SmoothBasis(1, 2.0).size(), 1);
}

class ProfileEffect : public ::testing::Test {
 protected:
  EffectPtr make(const std::string& yaml) { return createEffect(specOf(yaml), domain); }
  State state() { return randomState(machine, domain, random); }
  std::string refusal(const std::string& yaml) {
    try {
      make(yaml);
    } catch (const InputError& error) {
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
      return error.what();
    }
    return "accepted";
  }
  void expectRefused(const std::string& yaml, const std::vector<std::string>& parts) {
    const std::string message = refusal(yaml);
    for (const std::string& part : parts)
      EXPECT_NE(message.find(part), std::string::npos) << message << "\n lacks: " << part;
  }
  Machine machine = Machine::load("three_axis");
  Domain domain = domainOf(machine, false);
  std::mt19937_64 random{4};
};

TEST_F(ProfileEffect, refusesWhatItCannotUse) {
  expectRefused("{type: profile, direction: x}", {"'variable' is missing"});
  expectRefused("{type: profile, variable: bed}", {"'direction' is missing"});
  expectRefused("{type: profile, direction: x, variable: bedd}",
                {"'bedd'", "did you mean 'bed'", "humidity"});
  expectRefused("{type: profile, direction: x, variable: [bed, y]}", {"'variable'", "not a list"});
  expectRefused("{type: profile, direction: x, variables: bed}", {"'variables'", "[a, b]"});
  expectRefused("{type: profile, direction: x, variables: [bed]}", {"'variables'", "write variable: a"});
  expectRefused("{type: profile, direction: x, variables: [bed, bed]}", {"two different"});
  expectRefused("{type: profile, direction: x, variables: [bed, q]}", {"'q'", "not a recorded variable"});
  expectRefused("{type: profile, direction: x, variable: y, variables: [bed, y]}", {"not both"});
  expectRefused("{type: profile, direction: w, variable: y}", {"'w'", "approach"});
  expectRefused("{type: profile, direction: x, variable: y, functions: 0}", {"'functions'", "1 and 32", "0"});
  expectRefused("{type: profile, direction: x, variables: [x, y], functions: 9}",
                {"'functions'", "1 and 8", "9"});
  expectRefused("{type: profile, direction: x, variable: y, smoothness: 9}", {"'smoothness'", "9"});
  expectRefused("{type: profile, direction: x, variable: y, size_um: 0}", {"'size_um'", "0"});
  expectRefused("{type: profile, direction: x, variable: y, size_arcsec: 3}", {"size_um", "size_arcsec"});
  expectRefused("{type: profile, direction: x, variable: y, size: 3}", {"'size'", "allowed: direction"});
  domain.upper[1] = domain.lower[1];
  domain.velocityLower[0] = domain.velocityUpper[0] = kNan;
  domain.duration = 0.0;
  expectRefused("{type: profile, direction: x, variable: y}", {"'y'", "never changed"});
  expectRefused("{type: profile, direction: x, variable: x_velocity}", {"'x_velocity'", "not recorded"});
  expectRefused("{type: profile, direction: x, variable: t}", {"'t'", "never changed"});
}

TEST_F(ProfileEffect, isTheSumOfItsFunctionsAndTheirProducts) {
  const EffectPtr one = make("{type: profile, direction: z, variable: bed}");
  EXPECT_EQ(one->parameterCount(), 12);
  const EffectPtr two = make("{type: profile, direction: z, variables: [x, bed], functions: 3}");
  ASSERT_EQ(two->parameterCount(), 3 + 3 + 9);
  EXPECT_EQ(two->parameters()[0].name, "a1");
  EXPECT_EQ(two->parameters()[3].name, "b1");
  EXPECT_EQ(two->parameters()[6].name, "a1b1");
  EXPECT_EQ(two->parameters()[8].name, "a1b3");
  const State s = state();
  const Collector sink = evaluate(*two, domain, s, std::vector<double>(15, 1e-6));
  const int slot = ErrorLayout(3).axis(2);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      EXPECT_NEAR(sink.slopes[slot][6 + 3 * i + j], sink.slopes[slot][i] * sink.slopes[slot][3 + j], 1e-14);
}

TEST_F(ProfileEffect, priorIsAsWideAsTheSizeSays) {
  for (const char* yaml : {"{type: profile, direction: z, variable: bed, size_um: 3}",
                           "{type: profile, direction: z, variables: [x, bed], size_um: 3}",
                           "{type: profile, direction: approach, variable: x, functions: 1, size_um: 3}"}) {
    double square = 0.0;
    for (const Parameter& p : make(yaml)->parameters()) {
      EXPECT_GT(p.priorStd, 0.0);
      EXPECT_GT(p.bound, p.priorStd);  // so that what no data touch is as wide as its prior, not lost
      square += p.priorStd * p.priorStd;
    }
    EXPECT_NEAR(std::sqrt(square), 3e-6, 1e-12) << yaml;
  }
  EXPECT_EQ(make("{type: scale, axis: x}")->parameters()[0].priorStd, 0.0);
}

TEST_F(ProfileEffect, staysFlatBeyondItsRange) {
  const EffectPtr effect = make("{type: profile, direction: z, variables: [x, bed]}");
  std::vector<double> p;
  for (const Parameter& q : effect->parameters()) p.push_back(q.priorStd);
  State at = state();
  const auto value = [&](double x, double bed) {
    at.position[0] = x;
    at.temperature[0] = bed;
    return evaluate(*effect, domain, at, p).values[ErrorLayout(3).axis(2)];
  };
  EXPECT_NE(value(0.0, 20.0), value(0.01, 20.0));
  EXPECT_EQ(value(domain.upper[0], 22.0), value(domain.upper[0] + 0.05, 22.0));
  EXPECT_EQ(value(domain.lower[0], 22.0), value(domain.lower[0] - 0.05, 22.0));
  EXPECT_EQ(value(0.003, domain.sensorUpper[0]), value(0.003, domain.sensorUpper[0] + 30.0));
  EXPECT_TRUE(std::isnan(value(0.003, kNan)));
}

TEST_F(ProfileEffect, saysWhereASpeedOrAReadingIsOutside) {
  const EffectPtr effect = make("{type: profile, direction: z, variable: x_velocity}");
  State at = state();
  at.velocity[0] = 0.012;
  EXPECT_EQ(effect->outside(at, 0.1), "");
  at.velocity[0] = 0.018;  // observed -20 to 15 mm/s
  EXPECT_EQ(effect->outside(at, 0.1), "");
  at.velocity[0] = 0.019;
  EXPECT_EQ(effect->outside(at, 0.1),
            "x_velocity = 19 mm/s is outside -23.5 to 18.5 mm/s, the calibrated range with its margin");
  EXPECT_NE(effect->outside(at, 0.0).find("-20 to 15 mm/s"), std::string::npos);

  const Machine five = Machine::load("five_axis");
  const Domain laser = domainOf(five, true);
  const EffectPtr reading = createEffect(specOf("{type: profile, direction: z, variable: reading}"), laser);
  State seen = randomState(five, laser, random);
  EXPECT_EQ(reading->outside(seen, 0.1), "");
  seen.laserReading = 1e-3;
  EXPECT_NE(reading->outside(seen, 0.1).find("reading = 1 mm is outside -0.6 to 0.6 mm"), std::string::npos);
}

TEST_F(ProfileEffect, specHasTheSizeInTheUnitOfItsDirection) {
  EXPECT_EQ(sizedProfile(profileSpec("x", {"bed"}), 3.14e-6, domain).yaml(),
            "{type: profile, direction: x, variable: bed, size_um: 3.1}");
  EXPECT_EQ(sizedProfile(profileSpec("x", {"bed", "y"}), 0.0, domain).yaml(),
            "{type: profile, direction: x, variables: [bed, y]}");
  const Domain five = domainOf(Machine::load("five_axis"), true);
  // What an estimate says of a curve that is hardly there, or of one beyond all bounds, can be read again.
  for (const double size : {2.9e-153, 1e-13, 1e9})
    EXPECT_NO_THROW(createEffect(sizedProfile(profileSpec("x", {"bed"}), size, domain), domain)) << size;
  const EffectSpec spec = sizedProfile(profileSpec("b", {"bed"}), 2.0 * kArcsecond, five);
  EXPECT_EQ(spec.yaml(), "{type: profile, direction: b, variable: bed, size_arcsec: 2}");
  EXPECT_TRUE(createEffect(spec, five)->spec() == spec);
  for (const EffectType& type : effectRegistry())
    if (type.type == "profile") {
      EXPECT_TRUE(type.candidates(domain).empty());
      EXPECT_FALSE(type.composite);
    }
}

TEST_F(ProfileEffect, curveIsWhatTheEffectSaysWithItsBand) {
  const EffectPtr effect = make("{type: profile, direction: z, variable: y, size_um: 2}");
  const int n = effect->parameterCount();
  Eigen::VectorXd c(n);
  Eigen::MatrixXd root(n, n);
  std::normal_distribution<double> normal;
  for (int i = 0; i < n; ++i) {
    c[i] = effect->parameters()[i].priorStd * normal(random);
    for (int j = 0; j < n; ++j) root(i, j) = 1e-7 * normal(random);
  }
  const Eigen::MatrixXd covariance = root * root.transpose();
  const ProfileCurve curve = profileCurve(effect->spec(), domain, c, covariance, 21);
  ASSERT_EQ(curve.points.size(), 21u);
  ASSERT_EQ(curve.variables.size(), 1u);
  EXPECT_EQ(curve.variables[0].name, "y");
  EXPECT_EQ(curve.variables[0].unit, "mm");
  EXPECT_EQ(curve.unit, "um");
  EXPECT_NEAR(curve.points.front().at[0], domain.lower[1] * 1e3, 1e-12);
  EXPECT_NEAR(curve.points.back().at[0], domain.upper[1] * 1e3, 1e-12);
  const std::vector<double> p(c.data(), c.data() + n);
  State at = state();
  for (const ProfileCurve::Point& point : curve.points) {
    at.position[1] = point.at[0] * 1e-3;
    const Collector sink = evaluate(*effect, domain, at, p);
    const int slot = ErrorLayout(3).axis(2);
    EXPECT_NEAR(sink.values[slot] * 1e6, point.value, 1e-9);
    const Eigen::Map<const Eigen::VectorXd> slope(sink.slopes[slot].data(), n);
    EXPECT_NEAR(std::sqrt(slope.dot(covariance * slope)) * 1e6, point.std, 1e-9);
  }
  const ProfileCurve two =
      profileCurve(specOf("{type: profile, direction: z, variables: [bed, t], functions: 2}"), domain,
                   Eigen::VectorXd::Ones(8), Eigen::MatrixXd::Identity(8, 8), 5);
  ASSERT_EQ(two.points.size(), 25u);
  EXPECT_EQ(two.points[1].at[0], two.points[0].at[0]);
  EXPECT_EQ(two.variables[1].unit, "s");
  EXPECT_THROW(
      profileCurve(effect->spec(), domain, Eigen::VectorXd::Ones(3), Eigen::MatrixXd::Identity(3, 3)),
      InputError);
}

}  // namespace
}  // namespace mm
