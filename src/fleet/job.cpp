#include "fleet/job.h"

#include <algorithm>
#include <boost/uuid/name_generator_sha1.hpp>
#include <boost/uuid/nil_generator.hpp>
#include <boost/uuid/uuid_io.hpp>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/number_text.h"
#include "base/yaml_mapping.h"
#include "calibration_file/atomic_file.h"

namespace mm {
namespace {

namespace fs = std::filesystem;

/// One text with its length before it, so that no two lists of texts give the same bytes.
void addPart(std::string& bytes, const std::string& part) {
  bytes += std::to_string(part.size()) + ':' + part;
}

/// The URDF that a model names by a path; empty: it names none, or one of the package.
std::string machineFileOf(const std::string& model, const fs::path& file) {
  const YAML::Node root = YamlMapping::load(model, file.string());
  if (!root.IsMap() || !root["machine"] || !root["machine"].IsScalar()) return {};
  const fs::path named = file.parent_path() / root["machine"].as<std::string>();
  std::error_code ignored;
  return fs::is_regular_file(named, ignored) ? readFile(named) : std::string();
}

}  // namespace

const std::vector<std::string>& batchSteps() {
  static const std::vector<std::string> steps{"check",   "calibrate", "diagnose",
                                              "add_all", "verify",    "report"};
  return steps;
}

bool BatchJob::does(const std::string& step) const {
  return std::find(steps.begin(), steps.end(), step) != steps.end();
}

std::string keyOf(const BatchJob& job) {
  std::string bytes = "mm job 1\n";
  addPart(bytes, MM_VERSION);
  addPart(bytes, readFile(job.bag));
  const std::string model = job.model.empty() ? std::string() : readFile(job.model);
  addPart(bytes, model);
  addPart(bytes, job.model.empty() ? std::string() : machineFileOf(model, job.model));
  addPart(bytes, job.calibration.empty() ? std::string() : readFile(job.calibration));
  addPart(bytes, job.space);
  for (const std::string& step : job.steps) addPart(bytes, step);
  addPart(bytes, job.method);
  addPart(bytes, std::to_string(job.seed));
  addPart(bytes, numberText(job.repeatability));
  addPart(bytes, job.does("report") ? job.serial : std::string());
  boost::uuids::name_generator_sha1 generator(boost::uuids::nil_uuid());
  std::string digits = boost::uuids::to_string(generator(bytes.data(), bytes.size()));
  digits.erase(std::remove(digits.begin(), digits.end(), '-'), digits.end());
  return digits;
}

nlohmann::json jobJson(const BatchJob& job) {
  return {{"key", job.key},
          {"bag", job.bag.string()},
          {"model", job.model.string()},
          {"calibration", job.calibration.string()},
          {"namespace", job.space},
          {"steps", job.steps},
          {"method", job.method},
          {"seed", job.seed},
          {"repeatability_um", job.repeatability},
          {"serial", job.serial},
          {"machine", job.machine},
          {"date", job.date},
          {"source", job.source}};
}

BatchJob jobOf(const nlohmann::json& json) {
  BatchJob job;
  job.key = json.at("key").get<std::string>();
  job.bag = json.at("bag").get<std::string>();
  job.model = json.at("model").get<std::string>();
  job.calibration = json.at("calibration").get<std::string>();
  job.space = json.at("namespace").get<std::string>();
  job.steps = json.at("steps").get<std::vector<std::string>>();
  job.method = json.at("method").get<std::string>();
  job.seed = json.at("seed").get<std::uint64_t>();
  job.repeatability = json.at("repeatability_um").get<double>();
  job.serial = json.at("serial").get<std::string>();
  job.machine = json.at("machine").get<std::string>();
  job.date = json.at("date").get<std::string>();
  job.source = json.at("source").get<std::string>();
  return job;
}

}  // namespace mm
