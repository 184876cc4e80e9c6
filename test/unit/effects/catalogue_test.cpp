// Properties that every effect of the registry must have, on three machines.
#include <gtest/gtest.h>

#include <set>

#include "base/error.h"
#include "effects/effect_words.h"
#include "effects_support.h"

namespace mm {
namespace {

class Catalogue : public ::testing::TestWithParam<int> {
 protected:
  Catalogue() : rig_(rigOf(GetParam())), random_(3) {
    for (const EffectSpec& spec : everySpec(rig_.domain, GetParam()))
      effects_.push_back(createEffect(spec, rig_.domain, networksOf(rig_.domain)));
  }
  const Machine& machine() const { return rig_.machine; }
  const Domain& domain() const { return rig_.domain; }
  State state() { return randomState(machine(), domain(), random_); }

  /// Parameters of a plausible size about their start.
  std::vector<double> parametersOf(const Effect& effect) {
    std::normal_distribution<double> normal;
    std::vector<double> p;
    for (const Parameter& parameter : effect.parameters())
      p.push_back(parameter.start == 0.0 ? parameter.scale * normal(random_)
                                         : parameter.start + 0.1 * parameter.scale * normal(random_));
    return p;
  }

  MachineRig rig_;
  std::mt19937_64 random_;
  std::vector<EffectPtr> effects_;
};

/// A type that has no candidates is tried only where everySpec names it.
TEST(EverySpec, hasEveryTypeOfTheRegistry) {
  std::set<std::string> tried;
  for (const int which : {0, 1, 2})
    for (const EffectSpec& spec : everySpec(rigOf(which).domain, which)) tried.insert(spec.type);
  for (const EffectType& type : effectRegistry())
    EXPECT_EQ(tried.count(type.type), 1u) << type.type << ": add one to everySpec in effects_support.h";
}

TEST_P(Catalogue, statesItsParametersAndItsWords) {
  for (const EffectPtr& effect : effects_) {
    SCOPED_TRACE(effect->spec().yaml());
    EXPECT_GT(effect->parameterCount(), 0);
    std::set<std::string> names;
    for (const Parameter& p : effect->parameters()) {
      EXPECT_TRUE(names.insert(p.name).second) << p.name;
      EXPECT_FALSE(p.unit.empty());
      EXPECT_GT(p.toUnit, 0.0);
      EXPECT_GT(p.scale, 0.0);
      EXPECT_GE(p.bound, p.scale);
      EXPECT_GE(p.start, p.minimum);
      EXPECT_LE(p.start, p.maximum);
      EXPECT_GT(meaningOf(effect->spec(), p.name).size(), 10U) << p.name << ": say in words.yaml what it is";
    }
    for (const std::string& words : {effect->cause(), effect->remedy(), effect->shownBy()}) {
      EXPECT_GT(words.size(), 20U);
      EXPECT_EQ(words.back(), '.') << words;
      EXPECT_EQ(words.find("  "), std::string::npos) << words;
    }
  }
}

/// A rotary axis has no length: its words tell of angles, and of no standard of length.
TEST_P(Catalogue, speaksOfAnglesOfARotaryAxis) {
  for (const EffectPtr& effect : effects_) {
    const int joint = domain().findJoint(effect->spec().text("axis"));
    if (joint < 0 || domain().joints[static_cast<std::size_t>(joint)].kind != JointKind::kRotary) continue;
    for (const std::string& words : {effect->cause(), effect->remedy(), effect->shownBy()})
      for (const char* linear : {"ength", "interferometer", "step gauge", "screw", "nut", "slide"})
        EXPECT_EQ(words.find(linear), std::string::npos) << effect->spec().yaml() << ": " << words;
  }
}

TEST_P(Catalogue, isZeroAtItsStart) {
  for (const EffectPtr& effect : effects_) {
    SCOPED_TRACE(effect->spec().yaml());
    for (int trial = 0; trial < 5; ++trial)
      for (const double value : evaluate(*effect, domain(), state(), starts(*effect)).values)
        EXPECT_NEAR(value, 0.0, 1e-15);
  }
}

TEST_P(Catalogue, givesFiniteErrorsWhereAllInputsAreKnown) {
  for (const EffectPtr& effect : effects_) {
    SCOPED_TRACE(effect->spec().yaml());
    double largest = 0.0;
    // what begins late in a session is met by few states
    for (int trial = 0; trial < 20 || (largest == 0.0 && trial < 2000); ++trial) {
      const Collector sink = evaluate(*effect, domain(), state(), parametersOf(*effect));
      for (const double value : sink.values) {
        EXPECT_TRUE(std::isfinite(value));
        largest = std::max(largest, std::abs(value));
      }
    }
    EXPECT_GT(largest, 0.0) << "it does nothing at any of the states";
    EXPECT_LT(largest, 1.0);
  }
}

TEST_P(Catalogue, valuesAreTheSameWithoutDerivatives) {
  for (const EffectPtr& effect : effects_) {
    SCOPED_TRACE(effect->spec().yaml());
    const State s = state();
    const auto p = parametersOf(*effect);
    EXPECT_EQ(evaluate(*effect, domain(), s, p).values, evaluate(*effect, domain(), s, p, false).values);
  }
}

TEST_P(Catalogue, derivativesMatchDifferences) {
  for (const EffectPtr& effect : effects_) {
    SCOPED_TRACE(effect->spec().yaml());
    for (int trial = 0; trial < 3; ++trial) {
      const State s = state();
      const auto p = parametersOf(*effect);
      const Collector sink = evaluate(*effect, domain(), s, p);
      for (int i = 0; i < effect->parameterCount(); ++i) {
        const Parameter& parameter = effect->parameters()[i];
        const double h = 1e-4 * std::min(parameter.scale, parameter.start != 0.0 ? std::abs(parameter.start)
                                                                                 : parameter.scale);
        std::vector<double> up = p, down = p;
        up[i] += h;
        down[i] -= h;
        const auto above = evaluate(*effect, domain(), s, up, false).values;
        const auto below = evaluate(*effect, domain(), s, down, false).values;
        for (std::size_t slot = 0; slot < above.size(); ++slot) {
          const double difference = (above[slot] - below[slot]) / (up[i] - down[i]);
          const double rounding = 1e-15 * std::max(std::abs(above[slot]), std::abs(p[i] * difference)) / h;
          EXPECT_NEAR(sink.slopes[slot][i], difference, 1e-5 * std::abs(difference) + rounding + 1e-18 / h)
              << parameter.name << " slot " << slot;
        }
      }
    }
  }
}

TEST_P(Catalogue, linearMeansAdditiveAndHomogeneous) {
  for (const EffectPtr& effect : effects_) {
    SCOPED_TRACE(effect->spec().yaml());
    double worst = 0.0;
    for (int trial = 0; trial < 10; ++trial) {
      const State s = state();
      std::vector<double> a = parametersOf(*effect), b = parametersOf(*effect), sum(a.size());
      const std::vector<double> none(a.size(), 0.0);
      for (std::size_t i = 0; i < a.size(); ++i) {
        if (effect->parameters()[i].name.find("alpha") == 0) a[i] *= 100.0;  // where a sine is seen to be one
        sum[i] = 3.0 * a[i] - b[i];
      }
      const auto fa = evaluate(*effect, domain(), s, a, false).values;
      const auto fb = evaluate(*effect, domain(), s, b, false).values;
      const auto fs = evaluate(*effect, domain(), s, sum, false).values;
      const auto f0 = evaluate(*effect, domain(), s, none, false).values;
      for (std::size_t slot = 0; slot < fa.size(); ++slot) {
        const double size = std::abs(fa[slot]) + std::abs(fb[slot]) + 1e-12;
        worst = std::max(worst, std::abs(fs[slot] - 3.0 * fa[slot] + fb[slot]) / size);
        if (effect->linear()) {
          EXPECT_EQ(f0[slot], 0.0);
        }
      }
    }
    if (effect->linear()) {
      EXPECT_LT(worst, 1e-12);
      EXPECT_TRUE(effect->nature().nonlinear.empty());
      EXPECT_TRUE(effect->nature().searchStarts.empty());
      EXPECT_TRUE(effect->separable());
    } else {
      EXPECT_GT(worst, 1e-9);
    }
  }
}

TEST_P(Catalogue, separableMeansCoefficientTimesTheSlopeAtZero) {
  for (const EffectPtr& effect : effects_) {
    if (!effect->separable()) continue;
    SCOPED_TRACE(effect->spec().yaml());
    const State s = state();
    const auto p = parametersOf(*effect);
    const std::vector<double> none(p.size(), 0.0);
    const Collector atZero = evaluate(*effect, domain(), s, none);
    const auto values = evaluate(*effect, domain(), s, p).values;
    for (std::size_t slot = 0; slot < values.size(); ++slot) {
      double sum = 0.0;
      for (std::size_t i = 0; i < p.size(); ++i)
        sum += effect->coefficient(static_cast<int>(i), p[i]) * atZero.slopes[slot][i];
      EXPECT_NEAR(values[slot], sum, 1e-14 * (1e-6 + std::abs(sum)));
    }
  }
}

TEST_P(Catalogue, searchStartsFitTheNonlinearParameters) {
  for (const EffectPtr& effect : effects_) {
    if (effect->linear()) continue;
    SCOPED_TRACE(effect->spec().yaml());
    const auto nonlinear = effect->nature().nonlinear;
    // a mount starts at the chain, near enough for its derivatives there to tell all
    if (effect->startTells() && nonlinear.empty()) continue;
    EXPECT_FALSE(nonlinear.empty());
    EXPECT_FALSE(effect->nature().searchStarts.empty());
    for (const auto& start : effect->nature().searchStarts) {
      ASSERT_EQ(start.size(), nonlinear.size());
      for (std::size_t i = 0; i < start.size(); ++i) {
        EXPECT_GE(start[i], effect->parameters()[nonlinear[i]].minimum);
        EXPECT_LE(start[i], effect->parameters()[nonlinear[i]].maximum);
      }
    }
  }
}

/// What is not known must not pass for zero: with every optional input missing, an effect either does not use
/// any of them, and gives what it gave before, or gives NaN.
TEST_P(Catalogue, missingInputGivesNan) {
  for (const EffectPtr& effect : effects_) {
    SCOPED_TRACE(effect->spec().yaml());
    State whole = state();
    whole.feature = 0;  // a ball
    whole.featureRadius = 4e-3;
    State bare = whole;
    for (double& v : bare.velocity) v = kNan;
    for (double& v : bare.travel) v = 0.0;
    for (double& v : bare.sinceReversal) v = kNan;
    for (double& v : bare.temperature) v = kNan;
    for (double& v : bare.covariate) v = kNan;
    bare.approach.setZero();
    bare.surfaceNormal.setZero();
    bare.history = nullptr;
    const auto p = parametersOf(*effect);
    const auto before = evaluate(*effect, domain(), whole, p).values;
    const auto after = evaluate(*effect, domain(), bare, p).values;
    bool nan = false, same = true;
    for (std::size_t slot = 0; slot < before.size(); ++slot) {
      nan = nan || std::isnan(after[slot]);
      same = same && after[slot] == before[slot];
    }
    EXPECT_TRUE(nan || same);
    const std::set<std::string> needy{"backlash",         "speed_lag",        "thermal_expansion",
                                      "thermal_growth",   "thermal_bending",  "thermal_transient",
                                      "probe_lobing",     "laser_incidence",  "artifact_expansion",
                                      "covariate_offset", "covariate_scale",  "thermal_network",
                                      "lost_motion",      "angular_reversal", "straightness_reversal"};
    if (needy.count(effect->spec().type) != 0) {
      EXPECT_TRUE(nan);
    }
  }
}

TEST_P(Catalogue, specSurvivesYaml) {
  for (const EffectPtr& effect : effects_) {
    SCOPED_TRACE(effect->spec().yaml());
    const EffectSpec again = specOf(effect->spec().yaml());
    EXPECT_TRUE(again == effect->spec());
    EXPECT_TRUE(createEffect(again, domain())->spec() == effect->spec());
    EXPECT_EQ(effect->spec().yaml().find('\n'), std::string::npos);
  }
}

TEST_P(Catalogue, candidatesAreCanonicalAndDifferent) {
  std::set<std::string> seen;
  for (const EffectType& type : effectRegistry()) {
    for (const EffectSpec& spec : type.candidates(domain())) {
      const EffectPtr effect = createEffect(spec, domain());
      EXPECT_EQ(spec.type, type.type);
      EXPECT_TRUE(effect->spec() == spec) << spec.yaml();
      EXPECT_TRUE(seen.insert(spec.yaml()).second) << spec.yaml();
      EXPECT_FALSE(effect->nature().composite) << spec.yaml();
    }
    if (type.composite) {
      EXPECT_TRUE(type.candidates(domain()).empty()) << type.type;
    }
  }
}

TEST_P(Catalogue, ATipThatWearsMaySlowDown) {
  const EffectSpec slower = EffectSpec("tip_wear").set("slows", "true");
  const auto wears = [](const EffectPtr& e) { return e->spec().type == "tip_wear"; };
  const auto slows = [&](const EffectPtr& e) { return e->spec() == slower; };
  EXPECT_EQ(std::any_of(effects_.begin(), effects_.end(), wears),
            std::any_of(effects_.begin(), effects_.end(), slows));
}

TEST_P(Catalogue, refusesUnknownAndDoubledKeys) {
  for (const EffectPtr& effect : effects_) {
    SCOPED_TRACE(effect->spec().yaml());
    EffectSpec unknown = effect->spec();
    unknown.set("colour", "green");
    try {
      createEffect(unknown, domain());
      ADD_FAILURE() << "accepted";
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find("'colour'"), std::string::npos) << error.what();
    }
    if (effect->spec().keys.empty()) continue;
    EffectSpec doubled = effect->spec();
    doubled.keys.push_back(doubled.keys.front());
    EXPECT_THROW(createEffect(doubled, domain()), InputError);
    EffectSpec missing = effect->spec();
    const std::vector<std::string> shape = effect->nature().shapeKeys;  // may have a default
    if (std::find(shape.begin(), shape.end(), missing.keys.front().first) != shape.end()) continue;
    missing.keys.erase(missing.keys.begin());
    EXPECT_THROW(createEffect(missing, domain()), InputError);
  }
}

std::string machineName(const ::testing::TestParamInfo<int>& info) {
  const char* const names[] = {"three_axis", "five_axis", "pan_tilt"};
  return names[info.param];
}

INSTANTIATE_TEST_SUITE_P(Machines, Catalogue, ::testing::Values(0, 1, 2), machineName);

}  // namespace
}  // namespace mm
