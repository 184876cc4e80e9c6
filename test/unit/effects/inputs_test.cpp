// On what each effect of the catalogue depends, found by trial, against a table that physics wrote.
#include "effects/inputs.h"

#include <gtest/gtest.h>

#include <set>

#include "effects_support.h"

namespace mm {
namespace {

/// "x travel:x bed t approach": in the order of the Domain.
std::string wordsOf(const Inputs& in, const Domain& d) {
  std::string text;
  const auto say = [&](const std::string& word) { text += (text.empty() ? "" : " ") + word; };
  for (const int j : in.positions) say(d.joints[j].name);
  for (const int j : in.velocities) say("velocity:" + d.joints[j].name);
  for (const int j : in.travels) say("travel:" + d.joints[j].name);
  for (const int j : in.reversals) say("since:" + d.joints[j].name);
  for (const int s : in.temperatures) say(d.sensors[s]);
  for (const int c : in.covariates) say(d.covariates[c]);
  if (in.time) say("t");
  if (in.approach) say("approach");
  if (in.reading) say("reading");
  if (in.feature) say("feature");
  return text;
}

struct RowOfTable {
  std::string yaml, inputs;
};

const std::vector<RowOfTable> kThreeAxis{
    {"{type: mmt_deviation, axis: x, lead_mm: 1}", "x y z"},
    {"{type: scale, axis: x}", "x"},
    {"{type: squareness, axis: x, of: y}", "y"},
    {"{type: lead_screw_periodic, axis: x, period_mm: unknown}", "x"},
    {"{type: lead_screw_periodic, axis: y, period_mm: 2.5}", "y"},
    {"{type: positioning_polynomial, axis: x, degree: 3}", "x"},
    {"{type: straightness, axis: x, direction: z, degree: 2}", "x"},
    {"{type: straightness_table, axis: x, direction: z}", "x"},
    {"{type: position_table, axis: x}", "x"},
    {"{type: angular_motion, axis: x, about: x}", "x y z"},
    {"{type: angular_motion, axis: x, about: y}", "x z"},
    {"{type: angular_motion, axis: z, about: z, degree: 3}", "x y z"},
    {"{type: angular_reversal, axis: x, about: y}", "x z travel:x"},
    {"{type: straightness_reversal, axis: x, direction: z}", "travel:x"},
    {"{type: backlash, axis: y}", "travel:y"},
    {"{type: lost_motion, axis: y}", "travel:y since:y"},
    {"{type: speed_lag}", "velocity:x velocity:y velocity:z"},
    {"{type: thermal_expansion, axis: x, sensor: bed}", "x bed"},
    {"{type: thermal_expansion, axis: x, sensor: bed, lag: true}", "x bed"},
    {"{type: thermal_growth, direction: z, sensor: bed}", "bed"},
    {"{type: thermal_growth, direction: z, sensor: spindle, lag: true}", "spindle"},
    {"{type: thermal_bending, axis: z, about: x, sensors: [bed, frame]}", "y z bed frame"},
    {"{type: thermal_transient, direction: x, sensor: bed}", "bed"},
    {"{type: time_drift, direction: x}", "t"},
    {"{type: jump, direction: z, at_s: 100}", "t"},
    {"{type: warm_up, direction: z}", "t"},
    {"{type: scale_warm_up, axis: x}", "x t"},
    {"{type: time_cycle, direction: x}", "t"},
    {"{type: gravity_sag, direction: z, with: x, power: 2}", "x"},
    {"{type: probe_lobing, order: 0}", "approach"},
    {"{type: probe_lobing, order: 3}", "approach"},
    {"{type: probe_radius}", ""},
    {"{type: tip_wear}", "t"},
    {"{type: tip_wear, slows: true}", "t"},
    {"{type: ball_radius, ball: b0}", "feature"},
    {"{type: artifact_position, feature: b1}", "feature"},
    {"{type: artifact_expansion, sensor: frame}", "frame feature"},
    {"{type: covariate_offset, direction: x, covariate: humidity}", "humidity"},
    {"{type: covariate_scale, axis: x, covariate: load}", "x load"},
    {"{type: formula, direction: approach, formula: k1*humidity*x}", "x humidity approach"},
    {"{type: formula, direction: y, formula: k1*x_velocity*t}", "velocity:x t"},
    {"{type: formula, direction: z, formula: k1*exp(-t/k2), start: [0, 600]}", "t"},
    {"{type: formula, direction: z, formula: k1*exp(-t/k2)}", "t"},
    {"{type: formula, direction: z, formula: 'k1*(bed > 27 ? 1 : 0) + 0*t'}",
     "bed t"},  // without t it has no value
    {"{type: profile, direction: x, variable: bed}", "bed"},
    {"{type: profile, direction: x, variable: t}", "t"},
    {"{type: profile, direction: approach, variables: [x, y_velocity]}", "x velocity:y approach"},
    {"{type: thermal_network, axis: x}", "x bed spindle"},
};

const std::vector<RowOfTable> kFiveAxis{
    {"{type: tip_offset}", ""},
    {"{type: laser_mount}", ""},
    {"{type: laser_scale}", "reading"},
    {"{type: laser_incidence}", "b a approach"},
    {"{type: rotary_zero, joint: b}", ""},
    {"{type: rotary_axis_offset, joint: b, direction: x}", ""},
    {"{type: rotary_axis_tilt, joint: b, about: x}", ""},
    {"{type: rotary_eccentricity, joint: b, harmonic: 1}", "b"},
    {"{type: rotary_wobble, joint: a, harmonic: 2}", "a"},
    {"{type: angular_motion, axis: z, about: z}", "y x z b a"},
    {"{type: backlash, axis: b}", "travel:b"},
    {"{type: formula, direction: z, formula: k1*reading^2}", "reading"},
    {"{type: profile, direction: b, variable: reading}", "reading"},
};

void check(const std::vector<RowOfTable>& rows, const Domain& domain) {
  for (const RowOfTable& row : rows) {
    SCOPED_TRACE(row.yaml);
    const EffectPtr effect = createEffect(specOf(row.yaml), domain, networksOf(domain));
    EXPECT_EQ(wordsOf(inputsOf(*effect, domain), domain), row.inputs);
  }
}

TEST(Inputs, areThoseOfThePhysics) {
  check(kThreeAxis, rigOf(0).domain);
  check(kFiveAxis, rigOf(1).domain);
}

TEST(Inputs, theTableHasTheWholeCatalogue) {
  std::set<std::string> listed;
  for (const auto* rows : {&kThreeAxis, &kFiveAxis})
    for (const RowOfTable& row : *rows) listed.insert(specOf(row.yaml).type);
  for (const EffectType& type : effectRegistry())
    if (type.type.rfind("test_", 0) != 0) {
      EXPECT_EQ(listed.count(type.type), 1U) << type.type;
    }
}

TEST(Inputs, sayWhatFollows) {
  const Domain domain = rigOf(0).domain;
  const auto of = [&](const std::string& yaml) {
    return inputsOf(*createEffect(specOf(yaml), domain), domain);
  };
  EXPECT_TRUE(of("{type: backlash, axis: x}").needsMotion());
  EXPECT_TRUE(of("{type: speed_lag}").needsMotion());
  EXPECT_FALSE(of("{type: scale, axis: x}").needsMotion());
  EXPECT_TRUE(of("{type: time_drift, direction: x}").dependsOnTime());
  EXPECT_TRUE(of("{type: thermal_growth, direction: x, sensor: bed, lag: true}").dependsOnTime());
  EXPECT_TRUE(of("{type: covariate_offset, direction: x, covariate: load}").dependsOnTime());
  EXPECT_FALSE(of("{type: backlash, axis: x}").dependsOnTime());
}

/// A joint that stood still, one feature, sensors without a range: what it depends on is a matter of the
/// effect.
TEST(Inputs, doNotNeedAFullSession) {
  Domain domain = rigOf(0).domain;
  domain.upper = domain.lower;
  domain.sensorLower = domain.sensorUpper = {kNan, kNan, kNan};
  domain.covariateLower = domain.covariateUpper;
  domain.features = {"b0"};
  domain.featureRadius = {};
  domain.duration = domain.maxSpeed = 0.0;
  check({{"{type: scale, axis: x}", "x"},
         {"{type: thermal_expansion, axis: x, sensor: bed}", "x bed"},
         {"{type: speed_lag}", "velocity:x velocity:y velocity:z"},
         {"{type: time_drift, direction: x}", "t"},
         {"{type: ball_radius, ball: b0}", "feature"},
         {"{type: probe_lobing, order: 2}", "approach"}},
        domain);
  Domain bare;
  bare.setMachine(rigOf(0).machine);
  check({{"{type: squareness, axis: x, of: y}", "y"}, {"{type: backlash, axis: z}", "travel:z"}}, bare);
}

}  // namespace
}  // namespace mm
