// Errors of the structure: heat, time, weight, and what was logged beside them.
#include <algorithm>
#include <cmath>

#include "base/units.h"
#include "simulation/catalogue_parts.h"

namespace mm::source_kinds {
namespace {

int covariateOf(const Making& m) {
  const std::vector<TrueCovariate>& all = m.workshop.settings.covariates;
  const auto found = std::find_if(all.begin(), all.end(), [&](const TrueCovariate& covariate) {
    return covariate.name == m.source.key("covariate");
  });
  return static_cast<int>(found - all.begin());
}

/// Change of a logged quantity from its mean.
std::function<double(const Condition&)> changeOfCovariate(const Making& m) {
  const int covariate = covariateOf(m);
  return [covariate, mean = m.workshop.settings.covariates[covariate].mean](const Condition& c) {
    return c.covariates[covariate] - mean;
  };
}

Kinds heat() {
  return {
      // a screw or scale expands from its fixed end, which is at the axis' zero
      {"thermal_expansion",
       {{"axis", Key::kLinear}, {"sensor", Key::kBody}},
       {{"alpha", "1/K", 15e-6, 80e-6}},
       [](const Making& m) {
         m.add([body = m.body("sensor"), j = m.joint(), alpha = m.number("alpha")](const Condition& c,
                                                                                   Distortion& d) {
           d.travel[j] += alpha * c.drive[j] * (c.bodies[body] - kReferenceTemperature);
         });
       }},
      {"thermal_growth",
       {{"direction", Key::kDirection}, {"sensor", Key::kBody}},
       {{"g", "m/K", 0.5e-6, 3e-6, true}, {"lag", "s", 0.0, 0.0}},
       [](const Making& m) {
         int body = m.body("sensor");
         if (m.number("lag") > 0.0) {  // a body that no sensor tells, behind the one that has it
           std::vector<Follower>& followers = m.workshop.physics.followers;
           followers.push_back({body, m.number("lag")});
           body = m.workshop.thermal.bodyCount() + static_cast<int>(followers.size()) - 1;
         }
         m.add(
             [body, direction = m.direction(), perKelvin = m.number("g")](const Condition& c, Distortion& d) {
               direction.add(d, perKelvin * (c.bodies[body] - kReferenceTemperature));
             });
       }},
      // a column warmer on one side than on the other bends and tips what it carries
      {"thermal_bending",
       {{"axis", Key::kLinear},
        {"about", Key::kAbout},
        {"warm", Key::kBody},
        {"cold", Key::kColdBody},
        {"lever", Key::kWord, "workpiece"}},
       {{"k", "rad/K", 4.0 * kArcsecond, 25.0 * kArcsecond, true}},
       [](const Making& m) {
         m.add([warm = m.body("warm"), cold = m.body("cold"), tilt = m.tilt(), perKelvin = m.number("k")](
                   const Condition& c, Distortion& d) {
           tilt.add(d, perKelvin * (c.bodies[warm] - c.bodies[cold]));
         });
       }},
  };
}

Kinds time() {
  return {
      {"time_drift",
       {{"direction", Key::kDirection}},
       {{"d", "m/s", 2e-6 / 3600.0, 8e-6 / 3600.0, true}},
       [](const Making& m) {
         m.add([direction = m.direction(), rate = m.number("d")](const Condition& c, Distortion& d) {
           direction.add(d, rate * c.time);
         });
       }},
      // a clamp that slips, and gives way a little after it
      {"jump",
       {{"direction", Key::kDirection}},
       {{"d", "m", 2e-6, 8e-6, true}, {"at", "s", 300.0, 900.0}},
       [](const Making& m) {
         m.add([direction = m.direction(), size = m.number("d"), at = m.number("at")](const Condition& c,
                                                                                      Distortion& d) {
           constexpr double kAfter = 0.05, kSettles = 120.0;  // of the size; s
           const double since = c.time - at;
           if (since >= 0.0) direction.add(d, size * (1.0 - kAfter * std::expm1(-since / kSettles)));
         });
       }},
      // after switching on a fast and a slow part of the structure come to their temperatures
      {"warm_up",
       {{"direction", Key::kDirection}},
       {{"d", "m", 3e-6, 12e-6, true}, {"tau", "s", 480.0, 1200.0}},
       [](const Making& m) {
         m.add([direction = m.direction(), size = m.number("d"), tau = m.number("tau")](const Condition& c,
                                                                                        Distortion& d) {
           constexpr double kFast = 0.1, kFaster = 5.0;  // share of the fast part
           const double t = c.time / tau;
           direction.add(d, size * ((1.0 - kFast) * -std::expm1(-t) + kFast * -std::expm1(-kFaster * t)));
         });
       }},
      // a screw that heats itself by running grows from its fixed bearing
      {"scale_warm_up",
       {{"axis", Key::kLinear}},
       {{"strain", "1", 40e-6, 120e-6}, {"tau", "s", 480.0, 1200.0}},
       [](const Making& m) {
         const int j = m.joint();
         m.add([j, fixed = m.workshop.lower[j], strain = m.number("strain"), tau = m.number("tau")](
                   const Condition& c, Distortion& d) {
           d.travel[j] += strain * -std::expm1(-c.time / tau) * (c.drive[j] - fixed);
         });
       }},
  };
}

Kinds loads() {
  return {
      // a ram that sags as it extends: a cantilever under a load at its end and its own weight
      {"gravity_sag",
       {{"direction", Key::kDirection, "z"}, {"with", Key::kLinear}},
       {{"drop", "m", 3e-6, 12e-6}},
       [](const Making& m) {
         const int j = m.joint("with");
         const double retracted = m.workshop.lower[j];
         m.add([j, retracted, length = m.workshop.upper[j] - retracted, vertical = m.direction(),
                drop = m.number("drop")](const Condition& c, Distortion& d) {
           // end load P e^3 / (3 E I), own weight w e^4 / (8 E I): here nine parts to one at full extension
           constexpr double kOwnWeight = 0.1;
           const double e = std::max(0.0, (c.slide[j] - retracted) / length);
           vertical.add(d, -drop * e * e * e * ((1.0 - kOwnWeight) + kOwnWeight * e));
         });
       }},
      {"covariate_offset",
       {{"direction", Key::kDirection}, {"covariate", Key::kCovariate}},
       {{"k", "m", 0.2e-6, 0.8e-6, true}},
       [](const Making& m) {
         m.add([change = changeOfCovariate(m), direction = m.direction(), k = m.number("k")](
                   const Condition& c, Distortion& d) { direction.add(d, k * change(c)); });
       }},
      {"covariate_scale",
       {{"axis", Key::kLinear}, {"covariate", Key::kCovariate}},
       {{"k", "1", 15e-6, 60e-6, true}},
       [](const Making& m) {
         m.add([change = changeOfCovariate(m), j = m.joint(), k = m.number("k")](
                   const Condition& c, Distortion& d) { d.travel[j] += k * change(c) * c.drive[j]; });
       }},
  };
}

}  // namespace

Kinds structure() {
  Kinds all = heat();
  for (const Kinds& group : {time(), loads()}) all.insert(all.end(), group.begin(), group.end());
  return all;
}

}  // namespace mm::source_kinds
