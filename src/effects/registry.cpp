#include "effects/registry.h"

#include <algorithm>

#include "base/error.h"
#include "base/nearest_name.h"
#include "effects/angular_motion.h"
#include "effects/artifact_expansion.h"
#include "effects/artifact_position.h"
#include "effects/backlash.h"
#include "effects/ball_radius.h"
#include "effects/covariate_offset.h"
#include "effects/covariate_scale.h"
#include "effects/formula.h"
#include "effects/gravity_sag.h"
#include "effects/jump.h"
#include "effects/laser_incidence.h"
#include "effects/laser_mount.h"
#include "effects/laser_scale.h"
#include "effects/lead_screw_periodic.h"
#include "effects/lost_motion.h"
#include "effects/mmt_deviation.h"
#include "effects/owned.h"
#include "effects/position_table.h"
#include "effects/positioning_polynomial.h"
#include "effects/probe_lobing.h"
#include "effects/probe_radius.h"
#include "effects/profile.h"
#include "effects/rotary_axis_offset.h"
#include "effects/rotary_axis_tilt.h"
#include "effects/rotary_eccentricity.h"
#include "effects/rotary_wobble.h"
#include "effects/rotary_zero.h"
#include "effects/scale.h"
#include "effects/speed_lag.h"
#include "effects/squareness.h"
#include "effects/straightness.h"
#include "effects/straightness_table.h"
#include "effects/thermal_bending.h"
#include "effects/thermal_expansion.h"
#include "effects/thermal_growth.h"
#include "effects/thermal_network.h"
#include "effects/thermal_transient.h"
#include "effects/time_cycle.h"
#include "effects/time_drift.h"
#include "effects/tip_wear.h"
#include "effects/warm_up.h"

namespace mm {
namespace {

std::vector<EffectType>& registry() {
  static std::vector<EffectType> types{
      mmtDeviationType(),           //
      scaleType(),                  //
      squarenessType(),             //
      leadScrewPeriodicType(),      //
      positioningPolynomialType(),  //
      straightnessType(),           //
      straightnessTableType(),      //
      positionTableType(),          //
      angularMotionType(),          //
      backlashType(),               //
      lostMotionType(),             //
      speedLagType(),               //
      thermalExpansionType(),       //
      thermalGrowthType(),          //
      thermalBendingType(),         //
      thermalTransientType(),       //
      timeDriftType(),              //
      jumpType(),                   //
      warmUpType(),                 //
      timeCycleType(),              //
      gravitySagType(),             //
      probeLobingType(),            //
      probeRadiusType(),            //
      tipWearType(),                //
      ballRadiusType(),             //
      artifactPositionType(),       //
      artifactExpansionType(),      //
      laserMountType(),             //
      laserScaleType(),             //
      laserIncidenceType(),         //
      rotaryZeroType(),             //
      rotaryAxisOffsetType(),       //
      rotaryAxisTiltType(),         //
      rotaryEccentricityType(),     //
      rotaryWobbleType(),           //
      covariateOffsetType(),        //
      covariateScaleType(),         //
      formulaType(),                //
      profileType(),                //
      thermalNetworkType(),         //
  };
  return types;
}

}  // namespace

const std::vector<EffectType>& effectRegistry() { return registry(); }

std::string presentType(const std::string& type) { return type == "cross_talk" ? "squareness" : type; }

void registerEffectType(EffectType type) {
  auto& types = registry();
  if (type.type.empty() || !type.create)
    throw InputError("an effect type needs a name and a way to create it");
  if (std::any_of(types.begin(), types.end(),
                  [&](const EffectType& t) { return t.type == presentType(type.type); }))
    throw InputError("effect type '" + type.type + "' is already in the catalogue; choose another name");
  if (!type.candidates) type.candidates = [](const Domain&) { return std::vector<EffectSpec>(); };
  types.push_back(std::move(type));
}

EffectPtr createEffect(const EffectSpec& given, const Domain& domain) {
  EffectSpec spec = given;
  spec.type = presentType(given.type);
  const Owner owner = takeOwner(spec);
  std::vector<std::string> names;
  for (const EffectType& type : registry()) {
    if (type.type == spec.type) {
      EffectPtr law = type.create(spec, domain);
      return owner.isMachine() ? law : ownedEffect(std::move(law), owner, domain);
    }
    names.push_back(type.type);
  }
  throw InputError("effect " + spec.yaml() + ": unknown type '" + spec.type + "'" +
                   didYouMean(spec.type, names) + "; known: " + listOf(names) +
                   "; an effect of your own needs its package on ROS_PACKAGE_PATH (source its setup.bash)");
}

EffectPtr createEffect(const EffectSpec& spec, const Domain& domain,
                       const std::vector<LearnedNetwork>& networks) {
  EffectPtr effect = createEffect(spec, domain);
  if (!effect->learned()) return effect;
  const std::string own = effect->spec().yaml();
  for (const LearnedNetwork& network : networks)
    if (network.effect == own) return effect->taught(network, domain);
  return effect;
}

}  // namespace mm
