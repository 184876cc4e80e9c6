#include "machine/controller_compensation.h"

#include <nlohmann/json.hpp>

#include "base/checksum.h"
#include "base/error.h"

namespace mm {
namespace {

using Statement = ControllerCompensation::Stated;

std::string wordOf(Statement stated) {
  return stated == Statement::kNone ? "none" : stated == Statement::kFiles ? "files" : "not_stated";
}

}  // namespace

std::string ControllerCompensation::checksum() const {
  if (stated != Statement::kFiles) return {};
  std::string all = target;
  for (const File& file : files) all += '\0' + file.path + '\0' + file.text;
  return "crc64-" + checksumOf(all);
}

std::string ControllerCompensation::inWords() const {
  if (stated == Statement::kNot) return "not stated";
  if (stated == Statement::kNone) return "none";
  return "tables of " + target + " (" + std::to_string(files.size()) +
         (files.size() == 1 ? " file, " : " files, ") + checksum() + ")";
}

bool operator==(const ControllerCompensation& a, const ControllerCompensation& b) {
  return a.stated == b.stated && a.checksum() == b.checksum();
}

std::string compensationJson(const ControllerCompensation& compensation) {
  nlohmann::ordered_json json{{"stated", wordOf(compensation.stated)}};
  if (compensation.stated == Statement::kFiles) {
    json["target"] = compensation.target;
    json["checksum"] = compensation.checksum();
    json["files"] = nlohmann::ordered_json::array();
    for (const auto& file : compensation.files)
      json["files"].push_back({{"path", file.path}, {"text", file.text}});
  }
  return json.dump();
}

ControllerCompensation parseCompensation(const std::string& text, const std::string& source) {
  ControllerCompensation found;
  try {
    const auto json = nlohmann::json::parse(text);
    const auto word = json.at("stated").get<std::string>();
    for (const Statement stated : {Statement::kNot, Statement::kNone, Statement::kFiles})
      if (word == wordOf(stated)) found.stated = stated;
    if (word != wordOf(found.stated))
      throw InputError(source + ": 'stated' is '" + word + "'; take none or files");
    if (found.stated != Statement::kFiles) return found;
    found.target = json.at("target").get<std::string>();
    for (const auto& file : json.at("files"))
      found.files.push_back({file.at("path").get<std::string>(), file.at("text").get<std::string>()});
    if (const auto told = json.at("checksum").get<std::string>(); told != found.checksum())
      throw InputError(source + ": the files of the compensation have checksum " + found.checksum() +
                       ", not " + told + ": they were changed; state them again");
  } catch (const nlohmann::json::exception& e) {
    throw InputError(source + ": is not a statement of a compensation (" + e.what() + ")");
  }
  return found;
}

}  // namespace mm
