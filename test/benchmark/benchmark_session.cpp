#include "benchmark_session.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "base/error.h"

namespace mm {
namespace {

std::string textOf(const YAML::Node& plan) {
  YAML::Emitter out;
  out << plan;
  return out.c_str();
}

void setContacts(YAML::Node touch, int balls, int contacts) {
  const int before = touch["points"].as<int>(75);
  const int points = std::max(1, static_cast<int>(std::lround(static_cast<double>(contacts) / balls)));
  touch["points"] = points;
  // As many pauses as before, so that a short session still sees heat come and go.
  if (YAML::Node pause = touch["pause"])
    pause["every"] =
        std::max(1, static_cast<int>(std::lround(pause["every"].as<double>() * points / before)));
}

void onlyWarmingUp(YAML::Node instrument) {
  YAML::Node thermal = instrument["thermal"];
  if (thermal["heat"]) thermal.remove("heat");
  thermal["ambient"]["ramp_K_per_h"] = 3.0;
  thermal["ambient"]["swing_K"] = 0.0;
}

void stateNoise(YAML::Node probe, const std::string& stated, const std::string& source) {
  if (stated == "none") {
    probe.remove("repeatability_um");
    return;
  }
  char* end = nullptr;
  const double factor = std::strtod(stated.c_str(), &end);
  if (*end != '\0' || !(factor > 0.0))
    throw InputError("--stated-noise: '" + stated + "' must be a factor above 0, such as 0.5, or none");
  if (!probe["repeatability_um"])
    throw InputError(source + ": its artifact states no repeatability_um, which --stated-noise could change");
  probe["repeatability_um"] = factor * probe["repeatability_um"].as<double>();
}

}  // namespace

std::string varied(const std::string& planYaml, const std::string& source, const SessionVariant& variant) {
  try {
    if (variant.none()) return planYaml;
    YAML::Node plan = YAML::Load(planYaml);
    YAML::Node artifact = plan["artifact"], touch = plan["touch"];
    if (!artifact.IsMap() || !artifact["balls"].IsSequence() || !touch.IsMap())
      throw InputError(source +
                       ": a session can only be varied where the plan lists its balls and has one touch");
    YAML::Node instrument = plan["instrument"];
    if (variant.oneSided) {
      touch["cone_deg"] = 80;
      touch.remove("azimuth_deg");
      touch["azimuth_deg"].push_back(10);
      touch["azimuth_deg"].push_back(80);
    }
    if (variant.freeCentres) {
      for (YAML::Node ball : artifact["balls"]) ball["centre"] = "free";
      artifact["pose"] = "known";
    }
    if (variant.outliers) {
      instrument["noise"]["outliers"]["share"] = 0.03;
      instrument["noise"]["outliers"]["size_um"] = 20;
    }
    if (variant.heavyTails) instrument["noise"]["student_dof"] = 3;
    if (variant.timeTemperature) onlyWarmingUp(instrument);
    if (variant.contacts > 0)
      setContacts(touch, static_cast<int>(artifact["balls"].size()), variant.contacts);
    if (!variant.statedNoise.empty()) stateNoise(artifact["probe"], variant.statedNoise, source);
    return textOf(plan);
  } catch (const YAML::Exception& e) {
    throw InputError(source + ": cannot be varied: " + e.msg);
  }
}

std::string withoutNoise(const std::string& planYaml) {
  YAML::Node plan = YAML::Load(planYaml);
  YAML::Node noise = plan["instrument"]["noise"];
  for (const char* key :
       {"repeatability_um", "laser_um", "angular_repeatability_arcsec", "reference_um", "reference_arcsec"})
    noise[key] = 0.0;
  noise.remove("outliers");
  plan["instrument"].remove("rough");
  return textOf(plan);
}

}  // namespace mm
