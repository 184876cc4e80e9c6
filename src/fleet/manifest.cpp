#include "fleet/manifest.h"

#include <glob.h>

#include <algorithm>
#include <map>
#include <memory>
#include <string_view>

#include "base/error.h"
#include "base/nearest_name.h"
#include "base/parallel.h"
#include "base/pattern.h"
#include "base/text.h"
#include "base/yaml_mapping.h"
#include "calibration_file/atomic_file.h"
#include "fleet/readable.h"
#include "session/text_file.h"
#include "session/time_stamp.h"

namespace mm {
namespace {

namespace fs = std::filesystem;

const std::vector<std::string> kOptions{
    "steps", "model", "models", "calibration", "method", "seed", "repeatability_um", "namespace", "loaded"};

/// What is said once for all sessions, or for one entry.
struct Choices {
  std::vector<fs::path> models;
  BatchJob job;  // steps, calibration, method, seed, repeatability, namespace, loaded
};

/// Names go into JSON and into the tables, which hold UTF-8 and nothing else.
const std::string& utf8(const YamlMapping& entry, const std::string& key, const std::string& name,
                        const char* remedy = "save the manifest as UTF-8") {
  if (!isUtf8(name)) entry.fail(key, readable(name) + " is not UTF-8; " + remedy);
  return name;
}

/// A file that an entry names, relative to the manifest.
fs::path fileOf(const YamlMapping& entry, const std::string& key, const std::string& name,
                const fs::path& folder) {
  const fs::path file = fs::absolute(folder / name).lexically_normal();
  std::error_code ignored;
  if (!fs::is_regular_file(file, ignored))
    entry.fail(key, "'" + name + "' is not a file (looked for " + file.string() +
                        "); paths are relative to the manifest");
  utf8(entry, key, file.string(), "rename the file or its folder");
  return file;
}

void readSteps(const YamlMapping& entry, BatchJob& job) {
  const std::vector<std::string> given = entry.texts("steps");
  for (const std::string& step : given)
    if (std::find(batchSteps().begin(), batchSteps().end(), step) == batchSteps().end())
      entry.fail("steps", "'" + step + "' is not a step" + didYouMean(step, batchSteps()) + " (steps are " +
                              listOf(batchSteps()) + ")");
  job.steps.clear();
  for (const std::string& step : batchSteps())  // in the order in which they are done
    if (std::find(given.begin(), given.end(), step) != given.end()) job.steps.push_back(step);
  if (job.steps.empty()) entry.fail("steps", "no step is given; give some of " + listOf(batchSteps()));
}

void readChoices(const YamlMapping& entry, const fs::path& folder, Choices& c) {
  if (entry.has("steps")) readSteps(entry, c.job);
  if (entry.has("model") && entry.has("models"))
    entry.fail("models", "model is given, too; name all of them in models");
  for (const char* key : {"model", "models"}) {
    if (!entry.has(key)) continue;
    c.models.clear();
    for (const std::string& name : entry.texts(key)) c.models.push_back(fileOf(entry, key, name, folder));
  }
  if (entry.has("calibration"))
    c.job.calibration = fileOf(entry, "calibration", entry.text("calibration"), folder);
  if (entry.has("method")) {
    static const std::vector<std::string> kMethods{"staged_mutation", "niching", "least_squares"};
    c.job.method = entry.text("method");
    if (std::find(kMethods.begin(), kMethods.end(), c.job.method) == kMethods.end())
      entry.fail("method", "'" + c.job.method + "' is not known" + didYouMean(c.job.method, kMethods) +
                               " (methods are " + listOf(kMethods) + ")");
  }
  if (entry.has("seed")) c.job.seed = entry.count("seed", 0);
  if (entry.has("repeatability_um")) c.job.repeatability = entry.number("repeatability_um", 1.0, 1e-6, 1e6);
  if (entry.has("namespace")) c.job.space = utf8(entry, "namespace", entry.text("namespace"));
  if (entry.has("loaded")) c.job.loaded = entry.flag("loaded");
}

/// A path of which glob takes every character as it is.
std::string literally(const fs::path& path) {
  std::string pattern;
  for (const char c : path.string()) {
    if (std::string_view("*?[]{}\\~").find(c) != std::string_view::npos) pattern += '\\';
    pattern += c;
  }
  return pattern;
}

/// The files of a pattern, sorted by name.
std::vector<fs::path> bagsOf(const YamlMapping& entry, const fs::path& folder) {
  std::vector<fs::path> files;
  for (const std::string& pattern : entry.texts("bags")) {
    glob_t found{};
    const std::unique_ptr<glob_t, decltype(&::globfree)> freed(&found, ::globfree);
    const bool complete = startsWith(pattern, "/") || startsWith(pattern, "~");
    const std::string whole = complete ? pattern : literally(folder) + "/" + pattern;
    if (::glob(whole.c_str(), GLOB_BRACE | GLOB_TILDE, nullptr, &found) == 0)
      for (std::size_t i = 0; i < found.gl_pathc; ++i) {
        const fs::path file = fs::absolute(found.gl_pathv[i]).lexically_normal();
        if (!fs::is_regular_file(file)) continue;
        utf8(entry, "bags", file.string(), "rename the file or its folder");
        files.push_back(file);
      }
    if (files.empty())
      entry.fail("bags",
                 "'" + pattern + "' fits no file (looked for " +
                     (complete ? fs::path(pattern) : folder / pattern).string() +
                     "); paths and patterns (*, ?, [a-z], {a,b}) are relative to the manifest; ~ is the "
                     "home folder");
  }
  return files;
}

/// "2026-01-05" or "2026-01-05T08:30:00Z", in full; a time that the calendar and the clock have.
std::string dateOf(const YamlMapping& entry) {
  const std::string text = entry.text("date"), whole = text.size() == 10 ? text + "T00:00:00Z" : text;
  static const Pattern stamp(R"(\d{4}-\d\d-\d\dT\d\d:\d\d:[0-5]\dZ)");  // no leap second
  if (!stamp.matches(whole) || !parseCalendar(whole))
    entry.fail("date", "'" + text + "' is not a date; write it as 2026-01-05 or 2026-01-05T08:30:00Z (UTC)");
  return whole;
}

/// What the steps of an entry need and do not have.
void checkNeeds(const YamlMapping& entry, const Choices& c) {
  const BatchJob& job = c.job;
  if (job.does("calibrate") && c.models.empty())
    entry.fail("", "step calibrate needs a model; give model, here or for all sessions");
  if (job.does("verify") && job.calibration.empty())
    entry.fail("", "step verify needs the calibration to verify; give calibration");
  for (const char* step : {"diagnose", "add_all", "report"})
    if (job.does(step) && !job.does("calibrate") && job.calibration.empty())
      entry.fail(
          "", std::string("step ") + step + " needs a calibration; add step calibrate, or give calibration");
}

void addJobs(const YamlMapping& entry, const fs::path& folder, Choices c, std::vector<BatchJob>& jobs) {
  readChoices(entry, folder, c);
  checkNeeds(entry, c);
  BatchJob job = c.job;
  if (job.does("calibrate") && !job.does("verify")) job.calibration.clear();  // its own is used
  job.source = entry.source() + ":" + std::to_string(entry.line());
  if (entry.has("serial")) job.serial = utf8(entry, "serial", entry.text("serial"));
  if (entry.has("date")) job.date = dateOf(entry);
  for (const fs::path& bag : bagsOf(entry, folder)) {
    job.bag = bag;
    job.machine = entry.has("machine")  ? utf8(entry, "machine", entry.text("machine"))
                  : !job.serial.empty() ? job.serial
                                        : bag.parent_path().filename().string();
    for (const fs::path& model : job.does("calibrate") ? c.models : std::vector<fs::path>{{}}) {
      job.model = model;
      jobs.push_back(job);
    }
  }
}

/// Jobs of equal content are one; of two machines they are a mistake.
void takeOnce(std::vector<BatchJob>& all, Manifest& manifest) {
  std::map<std::string, std::size_t> seen;
  for (BatchJob& job : all) {
    const auto [at, isNew] = seen.emplace(job.key, manifest.jobs.size());
    if (isNew) {
      manifest.jobs.push_back(std::move(job));
      continue;
    }
    const BatchJob& first = manifest.jobs[at->second];
    if (first.machine != job.machine)
      throw InputError(job.source + ": bags: " + job.bag.string() + " of machine '" + job.machine +
                       "' has the same content as " + first.bag.string() + " of machine '" + first.machine +
                       "' (" + first.source + "); one session is of one machine: correct one of the entries");
    manifest.remarks.push_back(job.source + ": " + job.bag.string() + " has the same session and model as " +
                               first.bag.string() + " (" + first.source + "); it is run once");
  }
}

}  // namespace

Manifest loadManifest(const fs::path& file) {
  const std::string source = file.string();
  if (!isUtf8(source)) throw InputError(readable(source) + ": the name is not UTF-8; rename the manifest");
  std::vector<std::string> known = kOptions;
  known.insert(known.end(), {"name", "sessions"});
  const YamlMapping root(YamlMapping::load(readFile(file), source), source, "the manifest", known);
  const fs::path folder = fs::absolute(file).parent_path();
  Choices common;
  common.job.steps = {"check", "calibrate", "diagnose"};
  readChoices(root, folder, common);
  known = kOptions;
  known.insert(known.end(), {"bags", "machine", "serial", "date"});
  std::vector<BatchJob> jobs;
  for (const YAML::Node& node : root.list("sessions"))
    addJobs(YamlMapping(node, source, "the entry of sessions", known), folder, common, jobs);
  if (jobs.empty()) root.fail("sessions", "names no session; give a list of {bags: …, machine: …}");
  parallelFor(jobs.size(), [&](std::size_t i) { jobs[i].key = keyOf(jobs[i]); });
  Manifest manifest;
  takeOnce(jobs, manifest);
  return manifest;
}

}  // namespace mm
