#include "interpreters/external_offsets.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/format.h"
#include "base/grid_values.h"
#include "base/read_file.h"
#include "base/units.h"
#include "interpreters/table_sum.h"

namespace mm {
namespace {

constexpr const char* kOffsetFormat = "measuring_machine external offsets";
constexpr double kMostOffset = 1.0;        // mm, and mm/K
constexpr double kFarthestPosition = 1e5;  // mm
constexpr double kColdest = -50.0, kHottest = 150.0;

[[noreturn]] void refuseOffsets(const std::filesystem::path& file, const std::string& what) {
  throw InputError(file.string() + ": " + what + "; export the calibration again");
}

}  // namespace

ExternalOffsets::ExternalOffsets(const std::filesystem::path& file) {
  std::size_t points = 1;
  /// Numbers of each axis in an object, mm. @param count 0: as many as there are.
  const auto byAxis = [&](const nlohmann::json& object, const char* key, std::size_t count, double most) {
    std::vector<std::vector<double>> found;
    for (const std::string& axis : letters_) {
      const auto values = object.at(axis).get<std::vector<double>>();
      if (count > 0 && values.size() != count)
        refuseOffsets(file, format("'%s' of %s has %zu values, the grid %zu points", key, axis.c_str(),
                                   values.size(), count));
      for (const double value : values)
        if (!(std::abs(value) <= most))
          refuseOffsets(file,
                        format("'%s' of %s: %g is not from %g to %g", key, axis.c_str(), value, -most, most));
      found.push_back(inUnit(values, kMillimetre));
    }
    return found;
  };
  try {
    const auto json = nlohmann::json::parse(readWholeFile(file, "export the calibration again"));
    if (json.at("format") != kOffsetFormat || json.at("version") != 1)
      refuseOffsets(file, "is not a file of external offsets of version 1, the supported version");
    letters_ = json.at("axes").get<std::vector<std::string>>();
    positions_ = byAxis(json.at("positions_mm"), "positions_mm", 0, kFarthestPosition);
    for (const std::vector<double>& at : positions_) {
      if (at.size() < 2 || std::adjacent_find(at.begin(), at.end(), std::greater_equal<>()) != at.end())
        refuseOffsets(file, "'positions_mm' is not two or more ascending positions of each axis");
      points *= at.size();
    }
    base_ = byAxis(json.at("offset_mm"), "offset_mm", points, kMostOffset);
    for (const auto& name : json.at("sensors").get<std::vector<std::string>>()) {
      const double reference = json.at("reference_degC").at(name).get<double>();
      if (!(reference >= kColdest && reference <= kHottest))
        refuseOffsets(file, format("'reference_degC' of %s: %g is not from %g to %g", name.c_str(), reference,
                                   kColdest, kHottest));
      sensors_.push_back(
          {name, reference,
           byAxis(json.at("offset_mm_per_K").at(name), "offset_mm_per_K", points, kMostOffset)});
    }
  } catch (const nlohmann::json::exception& e) {
    refuseOffsets(file, std::string("is not a file of external offsets (") + e.what() + ")");
  }
  if (letters_.empty()) refuseOffsets(file, "'axes' is empty");
}

JointPoints ExternalOffsets::points() const {
  JointPoints points;
  for (std::size_t a = 0; a < letters_.size(); ++a) points[letters_[a]] = positions_[a];
  return points;
}

std::map<std::string, double> ExternalOffsets::at(const CommandedState& command) const {
  std::vector<double> place;
  for (const std::string& axis : letters_) place.push_back(commanded(command, axis));
  const std::vector<GridCorner> corners = gridCorners(positions_, place);
  std::map<std::string, double> added;
  for (std::size_t a = 0; a < letters_.size(); ++a) {
    double sum = gridValue(corners, base_[a]);
    for (const Sensor& sensor : sensors_) {
      const auto found = command.temperature.find(sensor.name);
      if (found == command.temperature.end() || !std::isfinite(found->second)) continue;
      sum += (found->second - sensor.reference) * gridValue(corners, sensor.perKelvin[a]);
    }
    added[letters_[a]] = sum;
  }
  return added;
}

}  // namespace mm
