#include "interpreters/loaded_compensation.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/nearest_name.h"
#include "base/read_file.h"
#include "base/temporary_folder.h"
#include "interpreters/table_sum.h"

namespace mm {
namespace {

namespace fs = std::filesystem;

using Statement = ControllerCompensation::Stated;

constexpr std::size_t kMostBytes = 16U << 20U;

void merge(const JointPoints& more, JointPoints& points) {
  for (const auto& [joint, at] : more) addPoints(joint, at, points);
}

/// What the export wrote for people, and what a controller does not read.
bool forPeople(const fs::path& name) { return name == "README.md" || name == "representability.txt"; }

/// The files of a folder, ascending by their path in it.
std::vector<ControllerCompensation::File> filesOf(const std::string& option, const fs::path& folder) {
  std::vector<fs::path> paths;
  std::uintmax_t bytes = 0;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file() || forPeople(entry.path().filename())) continue;
    paths.push_back(entry.path());
    bytes += entry.file_size();
    if (bytes > kMostBytes)
      throw InputError(option + " " + folder.string() + ": holds more than 16 MB, up to " +
                       entry.path().string() + "; copy the tables alone into a folder and name that");
  }
  std::sort(paths.begin(), paths.end());
  std::vector<ControllerCompensation::File> files;
  for (const fs::path& path : paths)
    files.push_back(
        {path.lexically_relative(folder).generic_string(), readWholeFile(path, "check " + option)});
  return files;
}

/// The controller that finds tables in a folder, or that alone can read it. @throw InputError.
std::string readerOf(const std::string& option, const fs::path& folder) {
  std::vector<std::string> readers, finders;
  for (const std::string& target : interpretedTargets()) {
    try {
      const bool any = !interpret(target, folder)->points().empty();
      (any ? finders : readers).push_back(target);
    } catch (const InputError&) {
      continue;
    }
  }
  if (!finders.empty()) readers = finders;
  if (readers.size() == 1) return readers.front();
  throw InputError(option + " " + folder.string() + ": " +
                   (readers.empty() ? "no controller's interpreter reads what is there"
                                    : "could be for " + listOf(readers)) +
                   "; say whose it is, as in " + option + " linuxcnc:" + folder.string() +
                   " (files and their names: docs/interpreters.md)");
}

}  // namespace

ExportDescription describeExport(const fs::path& folder) {
  const fs::path file = folder / ExportDescription::kFile;
  ExportDescription found;
  std::error_code error;
  if (!fs::is_regular_file(file, error)) return found;
  try {
    const auto json = nlohmann::json::parse(readWholeFile(file, "check the folder"));
    found.target = json.at("target").get<std::string>();
    found.calibration = json.value("calibration", "");
    found.letters = json.value("axes", found.letters);
    found.sensors = json.value("sensors", found.sensors);
    for (const auto& path : json.value("files", nlohmann::json::array()))
      found.files.insert(fs::path(path.at("path").get<std::string>()).begin()->string());
    if (json.contains("touched")) found.touched = json.at("touched").get<std::set<std::string>>();
  } catch (const nlohmann::json::exception& e) {
    throw InputError(file.string() + ": is not what mm export writes (" + e.what() +
                     "); export the calibration again");
  }
  return found;
}

LoadedCompensation::LoadedCompensation(const std::string& target, const fs::path& folder)
    : description_(describeExport(folder)) {
  if (!description_.target.empty() && description_.target != target)
    throw InputError(folder.string() + ": is for " + description_.target + ", not for " + target +
                     "; name the folder that is for " + target);
  if (!description_.touched || !description_.touched->empty()) own_ = interpret(target, folder);
  std::error_code error;
  if (const fs::path file = folder / ExternalOffsets::kFile; fs::is_regular_file(file, error))
    ownOffsets_.emplace(file);
  if (const fs::path kept = folder / ExportDescription::kKept;
      description_.touched && fs::is_directory(kept, error))
    kept_ = std::make_unique<const LoadedCompensation>(target, kept);
}

bool LoadedCompensation::ownIs(const std::string& joint) const {
  return own_ != nullptr && (!description_.touched || description_.touched->count(joint) > 0);
}

const ExternalOffsets* LoadedCompensation::offsets() const {
  return ownOffsets_ ? &*ownOffsets_ : kept_ ? kept_->offsets() : nullptr;
}

CommandedState LoadedCompensation::named(const CommandedState& command) const {
  CommandedState here = command;
  for (const auto& [there, name] : description_.sensors)
    if (const auto found = command.temperature.find(name); found != command.temperature.end())
      here.temperature[there] = found->second;
  return here;
}

std::map<std::string, double> LoadedCompensation::tablesAdd(const CommandedState& command) const {
  std::map<std::string, double> added;
  if (kept_) added = kept_->tablesAdd(command);
  const CommandedState here = named(command);
  const std::map<std::string, double> motors = own_ ? own_->motors(here) : command.position;
  for (const auto& [joint, position] : command.position)
    if (!kept_ || ownIs(joint)) added[joint] = motors.at(joint) - position;
  return added;
}

std::map<std::string, double> LoadedCompensation::offsetsAdd(const CommandedState& command) const {
  if (!ownOffsets_ && kept_) return kept_->offsetsAdd(command);
  return ownOffsets_ ? ownOffsets_->at(named(command)) : std::map<std::string, double>{};
}

std::map<std::string, double> LoadedCompensation::adds(const CommandedState& command) const {
  std::map<std::string, double> added = tablesAdd(command);
  for (const auto& [joint, offset] : offsetsAdd(command))
    if (const auto found = added.find(joint); found != added.end()) found->second += offset;
  return added;
}

JointPoints LoadedCompensation::tablePoints() const {
  JointPoints points = own_ ? own_->points() : JointPoints{};
  if (kept_) merge(kept_->tablePoints(), points);
  return points;
}

JointPoints LoadedCompensation::points() const {
  JointPoints points = tablePoints();
  if (const ExternalOffsets* found = offsets()) merge(found->points(), points);
  return points;
}

std::map<std::string, std::set<int>> LoadedCompensation::numbers() const {
  std::map<std::string, std::set<int>> numbers = own_ ? own_->numbers() : decltype(own_->numbers()){};
  if (kept_)
    for (const auto& [joint, taken] : kept_->numbers())
      if (!ownIs(joint)) numbers[joint] = taken;
  return numbers;
}

std::shared_ptr<const LoadedCompensation> loadedCompensation(const ControllerCompensation& stated) {
  if (stated.stated != Statement::kFiles) return nullptr;
  const TemporaryFolder folder;
  try {
    for (const ControllerCompensation::File& file : stated.files) folder.write(file.path, file.text);
    return std::make_shared<const LoadedCompensation>(stated.target, folder.path());
  } catch (const InputError& e) {
    std::string what = e.what();
    const std::string there = folder.path().string();
    for (std::size_t at = what.find(there); at != std::string::npos; at = what.find(there))
      what.replace(at, there.size(), "compensation that was active");
    throw InputError(what);
  }
}

ControllerCompensation statedCompensation(const std::string& option, const std::string& told) {
  ControllerCompensation stated;
  if (told.empty()) return stated;
  stated.stated = Statement::kNone;
  if (told == "none") return stated;
  stated.stated = Statement::kFiles;
  fs::path folder = told;
  const std::vector<std::string> targets = interpretedTargets();
  const std::string first = told.substr(0, told.find(':'));
  if (first.size() < told.size() && std::find(targets.begin(), targets.end(), first) != targets.end()) {
    stated.target = first;
    folder = told.substr(first.size() + 1);
  }
  std::error_code error;
  if (!fs::is_directory(folder, error))
    throw InputError(option + " " + told +
                     ": is neither 'none' nor a folder; name the folder with the files "
                     "that the controller has loaded");
  if (stated.target.empty()) stated.target = describeExport(folder).target;
  if (stated.target.empty()) stated.target = readerOf(option, folder);
  const LoadedCompensation reads(stated.target, folder);
  stated.files = filesOf(option, folder);
  try {
    compensationJson(stated);
  } catch (const nlohmann::json::exception&) {
    throw InputError(option + " " + told +
                     ": a file there is not text in UTF-8; copy the tables alone into a "
                     "folder and name that");
  }
  return stated;
}

}  // namespace mm
