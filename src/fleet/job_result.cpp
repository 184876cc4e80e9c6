#include "fleet/job_result.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/json_text.h"
#include "calibration_file/atomic_file.h"
#include "calibration_file/calibration_yaml.h"
#include "fleet/fields.h"

namespace mm {
namespace {

namespace fs = std::filesystem;

nlohmann::json jsonFile(const fs::path& file) {
  try {
    return nlohmann::json::parse(readFile(file));
  } catch (const nlohmann::json::exception& e) {
    throw InputError(file.string() + ": is not JSON (" + e.what() + ")");
  }
}

/// An effect in the JSON of a diagnosis as the spec that people write.
std::string specOf(const nlohmann::json& effect) {
  EffectSpec spec(effect.at("type").get<std::string>());
  for (const auto& [key, value] : effect.items()) {
    if (key == "type") continue;
    if (value.is_array()) {
      std::vector<std::string> items;
      for (const auto& item : value)
        items.push_back(item.is_string() ? item.get<std::string>() : item.dump());
      spec.setList(key, items);
    } else {
      spec.set(key, value.is_string() ? value.get<std::string>() : value.dump());
    }
  }
  return spec.yaml();
}

void readDiagnosis(const fs::path& file, JobResult& result) {
  const nlohmann::json json = jsonFile(file);
  result.verdict = json.at("verdict").get<std::string>();
  result.sentence = json.value("sentence", "");
  result.asked = true;
  for (const auto& missing : json.at("missing")) result.found.push_back(specOf(missing.at("effect")));
}

}  // namespace

void takeFigures(const Calibration& c, JobResult& result) {
  constexpr double kMicro = 1e6;
  result.observations = c.observations;
  result.angular = !std::isfinite(c.rms) && std::isfinite(c.rmsAngular);
  result.rms = (result.angular ? c.rmsAngular : c.rms) * kMicro;
  result.heldOutRms = (result.angular ? c.heldOutRmsAngular : c.heldOutRms) * kMicro;
  result.chi2PerDof = c.chi2PerDof;
  result.repeatability = c.repeatability * kMicro;
  for (const Calibration::Value& v : c.values)
    result.parameters.push_back(
        {c.effects[v.effect].yaml(), v.name, v.unit, v.value * v.toUnit, v.std * v.toUnit, v.fixed});
  for (const LedgerEntry& step : c.ledger)
    if (step.action == "add") result.found.push_back(step.effect.yaml());
}

std::string resultText(const JobResult& r) {
  Json json = fieldsJson<Json>(r);
  json["found"] = r.found;
  json["parameters"] = jsonList(r.parameters, fieldsJson<Json, FleetParameter>);
  json["sensors"] = jsonList(r.sensors, fieldsJson<Json, SensorHealth>);
  return jsonText(json, 1) + "\n";
}

JobResult parseResult(const std::string& text, const std::string& source) {
  try {
    const nlohmann::json json = nlohmann::json::parse(text);
    JobResult r;
    readFields(json, r);
    r.found = json.at("found").get<std::vector<std::string>>();
    for (const auto& parameter : json.at("parameters")) readFields(parameter, r.parameters.emplace_back());
    for (const auto& sensor : json.at("sensors")) readFields(sensor, r.sensors.emplace_back());
    return r;
  } catch (const nlohmann::json::exception& e) {
    throw InputError(source + ": is damaged (" + e.what() + "); remove the folder it is in and run again");
  }
}

void readStepFiles(const fs::path& folder, const BatchJob& job, JobResult& result) {
  std::error_code ignored;
  try {
    for (const char* name : {"added.yaml", "calibration.yaml"})
      if (fs::is_regular_file(folder / name, ignored)) {
        takeFigures(loadCalibration(folder / name), result);
        break;
      }
    if (fs::is_regular_file(folder / "calibrate.json", ignored))
      result.converged = jsonFile(folder / "calibrate.json").value("converged", true);
    if (fs::is_regular_file(folder / "diagnose.json", ignored))
      readDiagnosis(folder / "diagnose.json", result);
    std::sort(result.found.begin(), result.found.end());
    result.found.erase(std::unique(result.found.begin(), result.found.end()), result.found.end());
    if (job.does("add_all") && fs::is_regular_file(folder / "added.yaml", ignored)) result.asked = true;
    if (fs::is_regular_file(folder / "verify.json", ignored)) {
      const nlohmann::json json = jsonFile(folder / "verify.json");
      result.verified = json.at("verdict").get<std::string>();
      const auto rms = json.find("rms_um");
      if (rms != json.end() && rms->is_array() && rms->size() == 2) {
        if ((*rms)[0].is_number()) result.verifiedBefore = (*rms)[0].get<double>();
        if ((*rms)[1].is_number()) result.verifiedAfter = (*rms)[1].get<double>();
      }
    }
  } catch (const nlohmann::json::exception& e) {
    throw InputError(folder.string() + ": what a step printed lacks a key (" + e.what() + ")");
  }
}

}  // namespace mm
