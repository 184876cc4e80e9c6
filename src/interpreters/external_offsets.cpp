#include "interpreters/external_offsets.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/format.h"
#include "base/units.h"

namespace mm {
namespace {

constexpr const char* kOffsetFormat = "measuring_machine external offsets";
constexpr double kMostOffset = 1.0;        // mm, and mm/K
constexpr double kFarthestPosition = 1e5;  // mm
constexpr double kColdest = -50.0, kHottest = 150.0;

/// Reads one file of offsets; every refusal names it.
class OffsetFile {
 public:
  explicit OffsetFile(const std::filesystem::path& file) : file_(file) {
    std::ifstream in(file);
    if (!in) refuse("cannot be read");
    try {
      json_ = nlohmann::json::parse(in);
    } catch (const nlohmann::json::exception& e) {
      refuse(std::string("is no JSON (") + e.what() + ")");
    }
    if (!json_.is_object() || json_.value("format", nlohmann::json()) != kOffsetFormat)
      refuse("is no file of external offsets ('format')");
    if (json_.value("version", nlohmann::json()) != 1)
      refuse("'version' is not 1, the one that is read here");
  }

  [[noreturn]] void refuse(const std::string& what) const {
    throw InputError(file_.string() + ": " + what + "; export the calibration again");
  }
  std::vector<std::string> names(const std::string& key) const {
    std::vector<std::string> found;
    for (const nlohmann::json& name : list(json_, key)) {
      if (!name.is_string() || name.get<std::string>().empty()) refuse("'" + key + "' holds what is no name");
      found.push_back(name.get<std::string>());
      if (std::count(found.begin(), found.end(), found.back()) > 1)
        refuse("'" + key + "' names " + found.back() + " twice");
    }
    return found;
  }
  /// Numbers of `axis` in an object, mm. @param count 0: as many as there are.
  std::vector<double> millimetres(const nlohmann::json& object, const std::string& key,
                                  const std::string& axis, std::size_t count, double most) const {
    const nlohmann::json& values = list(object, axis, " of " + key);
    if (count > 0 && values.size() != count)
      refuse(format("'%s' of %s has %zu values, the grid %zu points", key.c_str(), axis.c_str(),
                    values.size(), count));
    std::vector<double> found;
    for (const nlohmann::json& value : values)
      found.push_back(number(value, "'" + key + "' of " + axis, -most, most) * kMillimetre);
    return found;
  }
  const nlohmann::json& object(const nlohmann::json& in, const std::string& key) const {
    if (!in.contains(key) || !in.at(key).is_object()) refuse("'" + key + "' is missing, or no object");
    return in.at(key);
  }
  double number(const nlohmann::json& value, const std::string& where, double lower, double upper) const {
    if (!value.is_number() || !(value.get<double>() >= lower && value.get<double>() <= upper))
      refuse(where + ": " + value.dump() + format(" is not a number from %g to %g", lower, upper));
    return value.get<double>();
  }
  const nlohmann::json& json() const { return json_; }

 private:
  const nlohmann::json& list(const nlohmann::json& in, const std::string& key,
                             const std::string& of = {}) const {
    if (!in.contains(key) || !in.at(key).is_array()) refuse("'" + key + "'" + of + " is missing, or no list");
    return in.at(key);
  }

  std::filesystem::path file_;
  nlohmann::json json_;
};

}  // namespace

ExternalOffsets::ExternalOffsets(const std::filesystem::path& path) {
  const OffsetFile file(path);
  letters_ = file.names("axes");
  if (letters_.empty()) file.refuse("'axes' is empty");
  const nlohmann::json& positions = file.object(file.json(), "positions_mm");
  std::size_t points = 1;
  for (const std::string& axis : letters_) {
    positions_.push_back(file.millimetres(positions, "positions_mm", axis, 0, kFarthestPosition));
    const std::vector<double>& at = positions_.back();
    if (at.size() < 2 || std::adjacent_find(at.begin(), at.end(), std::greater_equal<>()) != at.end())
      file.refuse("'positions_mm' of " + axis + " is not two or more ascending positions");
    points *= at.size();
  }
  const auto grid = [&](const nlohmann::json& of, const std::string& key) {
    std::vector<std::vector<double>> values;
    for (const std::string& axis : letters_)
      values.push_back(file.millimetres(of, key, axis, points, kMostOffset));
    return values;
  };
  base_ = grid(file.object(file.json(), "offset_mm"), "offset_mm");
  for (const std::string& name : file.names("sensors")) {
    const nlohmann::json& references = file.object(file.json(), "reference_degC");
    Sensor sensor;
    sensor.name = name;
    if (!references.contains(name)) file.refuse("'" + name + "' is missing in 'reference_degC'");
    sensor.reference = file.number(references.at(name), "'reference_degC' of " + name, kColdest, kHottest);
    sensor.perKelvin =
        grid(file.object(file.object(file.json(), "offset_mm_per_K"), name), "offset_mm_per_K");
    sensors_.push_back(std::move(sensor));
  }
}

std::vector<ExternalOffsets::Corner> ExternalOffsets::cornersAround(const CommandedState& command) const {
  std::vector<Corner> around = {{0, 1.0}};
  for (std::size_t a = 0; a < letters_.size(); ++a) {
    const std::vector<double>& at = positions_[a];
    const auto found = command.position.find(letters_[a]);
    if (found == command.position.end())
      throw InputError("external offsets need the position of axis " + letters_[a] + ", which is not known");
    const auto above = std::upper_bound(at.begin() + 1, at.end() - 1, found->second);
    const auto lower = static_cast<std::size_t>(above - at.begin()) - 1;
    const double share = std::clamp((found->second - at[lower]) / (at[lower + 1] - at[lower]), 0.0, 1.0);
    std::vector<Corner> next;
    for (const Corner& c : around)
      for (const std::size_t up : {std::size_t{0}, std::size_t{1}})
        next.push_back({c.point * at.size() + lower + up, c.weight * (up != 0 ? share : 1.0 - share)});
    around = std::move(next);
  }
  return around;
}

JointPoints ExternalOffsets::points() const {
  JointPoints points;
  for (std::size_t a = 0; a < letters_.size(); ++a) points[letters_[a]] = positions_[a];
  return points;
}

std::map<std::string, double> ExternalOffsets::at(const CommandedState& command) const {
  const std::vector<Corner> around = cornersAround(command);
  const auto mean = [&](const std::vector<double>& values) {
    double sum = 0.0;
    for (const Corner& c : around) sum += c.weight * values[c.point];
    return sum;
  };
  std::map<std::string, double> added;
  for (std::size_t a = 0; a < letters_.size(); ++a) {
    double sum = mean(base_[a]);
    for (const Sensor& sensor : sensors_) {
      const auto found = command.temperature.find(sensor.name);
      if (found == command.temperature.end() || !std::isfinite(found->second)) continue;
      sum += (found->second - sensor.reference) * mean(sensor.perKelvin[a]);
    }
    added[letters_[a]] = sum;
  }
  return added;
}

}  // namespace mm
