#include "ros_bridge/plugin_effect.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "base/error.h"
#include "effects/inputs.h"

namespace mm {
namespace {

/// A wave and a slope along the first joint: size * sin(2 pi q / period) and slope * q; the tilt of a second.
class Wave : public plugin::Effect {
 public:
  std::vector<plugin::Parameter> parameters() const override {
    plugin::Parameter size, period, slope;
    size.name = "size";
    size.scale = 1e-6;
    period.name = "period";
    period.scale = period.start = 1e-3;
    period.minimum = 1e-5;
    period.search = {0.5e-3, 1e-3, 2e-3};
    slope.name = "slope";
    slope.scale = 1e-4;
    return {size, period, slope};
  }
  void evaluate(const plugin::State& s, const double* p, plugin::Error& e) const override {
    e.reading[1] += p[0] * std::sin(2.0 * 3.14159265358979323846 * s.position[0] / p[1]);
    e.tilt(s, 2, p[2] * s.temperature[0]);
    e.atJoint[6 + 4] += p[2];  // second joint, rotation about its y
    e.distance -= p[0];
  }
  std::string cause() const override { return "cause"; }
  std::string remedy() const override { return "remedy"; }
  std::string shownBy() const override { return "contacts"; }
  std::vector<int> mustMove() const override { return {0}; }
  int positionsNeeded() const override { return 6; }
};

class WaveType : public plugin::EffectType {
 public:
  std::string name() const override { return "wave"; }
  std::vector<plugin::Key> keys() const override { return {{"axis", ""}, {"order", "1", true}}; }
  std::unique_ptr<plugin::Effect> create(const plugin::Keys& keys, const plugin::Session& s) const override {
    s.joint(keys.at("axis"));
    return std::make_unique<Wave>();
  }
  std::vector<plugin::Keys> candidates(const plugin::Session& s) const override {
    std::vector<plugin::Keys> all;
    for (const auto& joint : s.joints) all.push_back({{"axis", joint.name}, {"order", "2"}});
    return all;
  }
};

class Sums : public ErrorSink {
 public:
  explicit Sums(int slots) : values(slots, 0.0), slopes(slots, std::vector<double>(3, 0.0)) {}
  void add(int slot, int parameter, double value, double basis) override {
    values[slot] += value * basis;
    slopes[slot][parameter] += basis;
  }
  void value(int slot, double v) override { values[slot] += v; }
  void derivative(int slot, int parameter, double d) override { slopes[slot][parameter] += d; }
  bool wantsDerivatives() const override { return true; }
  std::vector<double> values;
  std::vector<std::vector<double>> slopes;
};

class PluginEffectTest : public ::testing::Test {
 protected:
  PluginEffectTest() {
    Joint x, y;
    x.name = "x";
    y.name = "y";
    domain.joints = {x, y};
    domain.lower = {-0.02, -0.02};
    domain.upper = {0.02, 0.02};
    domain.sensors = {"bed"};
    domain.sensorLower = {20.0};
    domain.sensorUpper = {25.0};
    state.position = {0.0123, -0.004};
    state.velocity = {1e-3, 0.0};
    state.travel = {1.0, 0.0};
    state.temperature = {22.0};
    state.tip = Eigen::Vector3d(0.01, 0.02, 0.03);
  }
  EffectPtr make(EffectSpec spec) {
    return pluginEffectType(std::make_shared<WaveType>(), "plugin 'wave'", {}).create(spec, domain);
  }
  std::string refusal(EffectSpec spec) {
    try {
      make(std::move(spec));
    } catch (const InputError& e) {
      return e.what();
    }
    return "";
  }
  Domain domain;
  State state;
};

TEST_F(PluginEffectTest, valuesGoWhereTheLayoutSays) {
  const EffectPtr effect = make(EffectSpec("wave").set("axis", "x"));
  const double p[] = {2e-6, 0.9e-3, 1e-5};
  const ErrorLayout layout(2);
  Sums sums(layout.size());
  effect->evaluate(state, p, sums);
  const double angle = 2.0 * M_PI * 0.0123 / 0.9e-3;
  EXPECT_NEAR(sums.values[layout.axis(1)], 2e-6 * std::sin(angle), 1e-18);
  EXPECT_NEAR(sums.values[layout.volume(0)], -1e-5 * 22.0 * 0.02, 1e-18);
  EXPECT_NEAR(sums.values[layout.volume(1)], 1e-5 * 22.0 * 0.01, 1e-18);
  EXPECT_NEAR(sums.values[layout.orientation(2)], 1e-5 * 22.0, 1e-18);
  EXPECT_NEAR(sums.values[layout.jointRotation(1, 1)], 1e-5, 1e-18);
  EXPECT_NEAR(sums.values[layout.distance()], -2e-6, 1e-18);
  EXPECT_EQ(sums.values[layout.axis(0)], 0.0);
}

TEST_F(PluginEffectTest, derivativesAreThoseOfTheFormula) {
  const EffectPtr effect = make(EffectSpec("wave").set("axis", "x"));
  EXPECT_FALSE(effect->linear());
  EXPECT_EQ(effect->nature().nonlinear, std::vector<int>{1});
  EXPECT_EQ(effect->nature().searchStarts.size(), 3u);
  const double p[] = {2e-6, 0.9e-3, 1e-5};
  const ErrorLayout layout(2);
  Sums sums(layout.size());
  effect->evaluate(state, p, sums);
  const double angle = 2.0 * M_PI * 0.0123 / 0.9e-3;
  EXPECT_NEAR(sums.slopes[layout.axis(1)][0], std::sin(angle), 1e-12);
  const double byPeriod = -2e-6 * std::cos(angle) * angle / 0.9e-3;
  EXPECT_NEAR(sums.slopes[layout.axis(1)][1], byPeriod, 1e-7 * std::abs(byPeriod));
  EXPECT_NEAR(sums.slopes[layout.volume(1)][2], 22.0 * 0.01, 1e-12);
}

TEST_F(PluginEffectTest, keysHaveOneCanonicalForm) {
  EXPECT_EQ(make(EffectSpec("wave").set("order", "2.0").set("axis", "x"))->spec().yaml(),
            "{type: wave, axis: x, order: 2}");
  EXPECT_EQ(make(EffectSpec("wave").set("axis", "y").set("order", "1.0"))->spec().yaml(),
            "{type: wave, axis: y}");
  const std::vector<EffectSpec> all =
      pluginEffectType(std::make_shared<WaveType>(), "plugin 'wave'", {}).candidates(domain);
  ASSERT_EQ(all.size(), 2u);
  EXPECT_EQ(all[1].yaml(), "{type: wave, axis: y, order: 2}");
}

TEST_F(PluginEffectTest, refusalsNameThePluginAndTheKey) {
  EXPECT_NE(refusal(EffectSpec("wave")).find("plugin 'wave'"), std::string::npos);
  EXPECT_NE(refusal(EffectSpec("wave")).find("'axis' is missing"), std::string::npos);
  EXPECT_NE(refusal(EffectSpec("wave").set("axis", "w")).find("'w' is not among x, y"), std::string::npos);
  EXPECT_NE(refusal(EffectSpec("wave").set("axis", "x").set("oder", "2")).find("did you mean 'order'"),
            std::string::npos);
}

/// Says that it is linear, and is not.
class Square : public Wave {
 public:
  std::vector<plugin::Parameter> parameters() const override { return {Wave::parameters().front()}; }
  void evaluate(const plugin::State&, const double* p, plugin::Error& e) const override {
    e.reading[0] += p[0] * p[0];
  }
};
class SquareType : public WaveType {
  std::unique_ptr<plugin::Effect> create(const plugin::Keys&, const plugin::Session&) const override {
    return std::make_unique<Square>();
  }
};

TEST_F(PluginEffectTest, anEffectThatIsNotLinearAsItSaysIsRefused) {
  const EffectType type = pluginEffectType(std::make_shared<SquareType>(), "plugin 'square'", {});
  EXPECT_THROW(type.create(EffectSpec("wave").set("axis", "x"), domain), InputError);
}

/// A play with its own second shape.
class Play : public Wave {
 public:
  explicit Play(std::vector<plugin::ShapeFreedom> shapes) : shapes_(std::move(shapes)) {}
  std::vector<plugin::Parameter> parameters() const override { return {Wave::parameters().front()}; }
  void evaluate(const plugin::State& s, const double* p, plugin::Error& e) const override {
    e.reading[0] += p[0] * s.travel[0];
  }
  std::vector<plugin::ShapeFreedom> freedom() const override { return shapes_; }
  std::vector<int> variesAlong() const override { return {1}; }

 private:
  std::vector<plugin::ShapeFreedom> shapes_;
};
class PlayType : public WaveType {
 public:
  std::unique_ptr<plugin::Effect> create(const plugin::Keys& keys, const plugin::Session&) const override {
    const std::string axis = keys.at("axis");
    return std::make_unique<Play>(std::vector<plugin::ShapeFreedom>{
        {{{"axis", axis}, {"order", "2"}}, 0.2},
        {{{"axis", axis}, {"order", keys.at("order") == "3" ? "3" : "1"}}, 0.1}});
  }
};

TEST_F(PluginEffectTest, aPluginHasTheSameTraits) {
  const EffectPtr wave = make(EffectSpec("wave").set("axis", "x"));
  EXPECT_EQ(wave->nature().shapeKeys, std::vector<std::string>{"order"});
  EXPECT_EQ(wave->nature().mustMove, std::vector<int>{0});
  EXPECT_EQ(wave->nature().positionsNeeded, 6);
  EXPECT_TRUE(wave->freedom(domain).empty());
  const Inputs ofWave = inputsOf(*wave, domain);
  EXPECT_EQ(ofWave.positions, (std::vector<int>{0, 1}));  // the lever of its tilt moves with both
  EXPECT_EQ(ofWave.temperatures, std::vector<int>{0});
  EXPECT_FALSE(ofWave.needsMotion());
  EXPECT_FALSE(ofWave.time);

  std::vector<std::string> lines;
  const EffectType type = pluginEffectType(std::make_shared<PlayType>(), "plugin 'play'",
                                           [&](const std::string& line) { lines.push_back(line); });
  EXPECT_EQ(type.keys, (std::vector<std::string>{"axis", "order"}));
  const EffectPtr play = type.create(EffectSpec("wave").set("axis", "x").set("order", "5"), domain);
  EXPECT_EQ(play->nature().variesAlong, std::vector<int>{1});
  EXPECT_EQ(inputsOf(*play, domain).travels, std::vector<int>{0});
  const std::vector<ShapeFreedom> shapes = play->freedom(domain);
  ASSERT_EQ(shapes.size(), 2u);
  EXPECT_EQ(shapes[0].spec.yaml(), "{type: wave, axis: x, order: 2}");
  EXPECT_EQ(shapes[0].share, 0.2);
  EXPECT_EQ(shapes[1].spec.yaml(), "{type: wave, axis: x}");
  EXPECT_TRUE(lines.empty());

  // a shape that is the effect itself is none
  const EffectPtr own = type.create(EffectSpec("wave").set("axis", "x").set("order", "3"), domain);
  EXPECT_EQ(own->freedom(domain).size(), 1u);
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_NE(lines[0].find("order: 3"), std::string::npos) << lines[0];
}

/// Names a joint that is not there.
class Lost : public Play {
 public:
  Lost() : Play({}) {}
  std::vector<int> mustMove() const override { return {2}; }
};
class LostType : public WaveType {
  std::unique_ptr<plugin::Effect> create(const plugin::Keys&, const plugin::Session&) const override {
    return std::make_unique<Lost>();
  }
};

TEST_F(PluginEffectTest, aTraitThatNamesNoJointIsRefused) {
  const EffectType type = pluginEffectType(std::make_shared<LostType>(), "plugin 'lost'", {});
  try {
    type.create(EffectSpec("wave").set("axis", "x"), domain);
    ADD_FAILURE() << "accepted";
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find("mustMove() names joint 2"), std::string::npos) << e.what();
  }
}

/// Throws at its work.
class Broken : public Square {
  void evaluate(const plugin::State&, const double*, plugin::Error&) const override {
    throw std::runtime_error("empty table");
  }
};
class BrokenType : public WaveType {
  std::unique_ptr<plugin::Effect> create(const plugin::Keys&, const plugin::Session&) const override {
    return std::make_unique<Broken>();
  }
};

TEST_F(PluginEffectTest, oneThatThrowsAtWorkIsUnknownNotZeroAndSaidOnce) {
  std::vector<std::string> lines;
  const EffectType type = pluginEffectType(std::make_shared<BrokenType>(), "plugin 'broken'",
                                           [&](const std::string& line) { lines.push_back(line); });
  const EffectPtr effect = type.create(EffectSpec("wave").set("axis", "x"), domain);
  const double p[] = {1e-6};
  Sums sums(ErrorLayout(2).size());
  effect->evaluate(state, p, sums);
  effect->evaluate(state, p, sums);
  EXPECT_TRUE(std::isnan(sums.values[ErrorLayout(2).volume(0)]));
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_NE(lines[0].find("empty table"), std::string::npos);
}

}  // namespace
}  // namespace mm
