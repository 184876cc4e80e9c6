#include "fleet/job_result.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "calibration_file/atomic_file.h"
#include "calibration_file/calibration_yaml.h"

namespace mm {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

Json finiteOrNull(double value) { return std::isfinite(value) ? Json(value) : Json(); }

double numberOrNone(const nlohmann::json& json, const char* key) {
  const auto at = json.find(key);
  return at != json.end() && at->is_number() ? at->get<double>() : JobResult::kNone;
}

nlohmann::json jsonFile(const fs::path& file) {
  try {
    return nlohmann::json::parse(readFile(file));
  } catch (const nlohmann::json::exception& e) {
    throw InputError(file.string() + ": is no JSON (" + e.what() + ")");
  }
}

/// `{"type": "backlash", "axis": "x"}` of a diagnosis as the spec that people write.
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

void readCalibration(const fs::path& file, JobResult& result) {
  const Calibration c = loadCalibration(file);
  result.observations = static_cast<long>(c.observations);
  const bool angular = !std::isfinite(c.rms);
  constexpr double kMicro = 1e6;
  result.rms = (angular ? c.rmsAngular : c.rms) * kMicro;
  result.heldOutRms = (angular ? c.heldOutRmsAngular : c.heldOutRms) * kMicro;
  result.chi2PerDof = c.chi2PerDof;
  result.repeatability = c.repeatability * kMicro;
  result.parameters = parametersOf(c);
  for (const LedgerEntry& step : c.ledger)
    if (step.action == "add") result.found.push_back(step.effect.yaml());
}

}  // namespace

std::vector<FleetParameter> parametersOf(const Calibration& c) {
  std::vector<FleetParameter> all;
  for (const Calibration::Value& v : c.values)
    all.push_back({c.effects[static_cast<std::size_t>(v.effect)].yaml(), v.name, v.unit, v.value * v.toUnit,
                   v.std * v.toUnit, v.fixed});
  return all;
}

std::string resultText(const JobResult& r) {
  Json json = {{"key", r.key},
               {"status", r.status},
               {"failed", r.failed},
               {"why", r.why},
               {"again", r.again},
               {"software", r.software},
               {"session_hash", r.sessionHash},
               {"serial", r.serial},
               {"machine_name", r.machineName},
               {"epoch_s", finiteOrNull(r.epoch)},
               {"observations", r.observations},
               {"verdict", r.verdict},
               {"sentence", r.sentence},
               {"asked", r.asked},
               {"converged", r.converged},
               {"rms_um", finiteOrNull(r.rms)},
               {"held_out_rms_um", finiteOrNull(r.heldOutRms)},
               {"chi2_per_dof", finiteOrNull(r.chi2PerDof)},
               {"repeatability_um", finiteOrNull(r.repeatability)},
               {"found", r.found},
               {"verified", r.verified},
               {"verified_um", {finiteOrNull(r.verifiedBefore), finiteOrNull(r.verifiedAfter)}}};
  json["parameters"] = Json::array();
  for (const FleetParameter& p : r.parameters)
    json["parameters"].push_back({{"effect", p.effect},
                                  {"name", p.name},
                                  {"unit", p.unit},
                                  {"value", finiteOrNull(p.value)},
                                  {"std", finiteOrNull(p.std)},
                                  {"fixed", p.fixed}});
  json["sensors"] = Json::array();
  for (const SensorHealth& s : r.sensors)
    json["sensors"].push_back({{"sensor", s.sensor},
                               {"values", s.values},
                               {"set_aside", s.setAside},
                               {"mean_degC", finiteOrNull(s.mean)},
                               {"noise_K", finiteOrNull(s.noise)},
                               {"span_K", finiteOrNull(s.span)},
                               {"offset_K", finiteOrNull(s.offset)}});
  return json.dump(1) + "\n";
}

namespace {

void readLists(const nlohmann::json& json, JobResult& r) {
  r.found = json.at("found").get<std::vector<std::string>>();
  for (const auto& p : json.at("parameters"))
    r.parameters.push_back({p.at("effect").get<std::string>(), p.at("name").get<std::string>(),
                            p.at("unit").get<std::string>(), numberOrNone(p, "value"), numberOrNone(p, "std"),
                            p.at("fixed").get<bool>()});
  for (const auto& s : json.at("sensors")) {
    SensorHealth h;
    h.sensor = s.at("sensor").get<std::string>();
    h.values = s.at("values").get<int>();
    h.setAside = s.at("set_aside").get<int>();
    h.mean = numberOrNone(s, "mean_degC");
    h.noise = numberOrNone(s, "noise_K");
    h.span = numberOrNone(s, "span_K");
    h.offset = numberOrNone(s, "offset_K");
    r.sensors.push_back(h);
  }
}

}  // namespace

JobResult parseResult(const std::string& text, const std::string& source) {
  try {
    const nlohmann::json json = nlohmann::json::parse(text);
    JobResult r;
    r.key = json.at("key").get<std::string>();
    r.status = json.at("status").get<std::string>();
    r.failed = json.at("failed").get<std::string>();
    r.why = json.at("why").get<std::string>();
    r.again = json.at("again").get<bool>();
    r.software = json.at("software").get<std::string>();
    r.sessionHash = json.at("session_hash").get<std::string>();
    r.serial = json.at("serial").get<std::string>();
    r.machineName = json.at("machine_name").get<std::string>();
    r.epoch = numberOrNone(json, "epoch_s");
    r.observations = json.at("observations").get<long>();
    r.verdict = json.at("verdict").get<std::string>();
    r.sentence = json.at("sentence").get<std::string>();
    r.asked = json.at("asked").get<bool>();
    r.converged = json.at("converged").get<bool>();
    r.rms = numberOrNone(json, "rms_um");
    r.heldOutRms = numberOrNone(json, "held_out_rms_um");
    r.chi2PerDof = numberOrNone(json, "chi2_per_dof");
    r.repeatability = numberOrNone(json, "repeatability_um");
    r.verified = json.at("verified").get<std::string>();
    const auto& figures = json.at("verified_um");
    if (figures.at(0).is_number()) r.verifiedBefore = figures.at(0).get<double>();
    if (figures.at(1).is_number()) r.verifiedAfter = figures.at(1).get<double>();
    readLists(json, r);
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
        readCalibration(folder / name, result);
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

void writeJobFile(const std::filesystem::path& file, const std::string& text) {
  writeFileAtomically(file, text);
}

}  // namespace mm
