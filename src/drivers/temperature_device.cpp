#include "drivers/temperature_device.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <set>

#include "base/error.h"
#include "base/format.h"
#include "base/nearest_name.h"
#include "base/text.h"
#include "drivers/modbus_temperature.h"
#include "drivers/sysfs_temperature.h"

namespace mm {

void SensorKeys::refuse(const std::string& why) const {
  throw InputError("sensor '" + setup_.name + "': " + why);
}

std::string SensorKeys::text(const std::string& key, const std::string& standard) {
  asked_.push_back(key);
  const auto found = setup_.keys.find(key);
  return found == setup_.keys.end() ? standard : found->second;
}

double SensorKeys::number(const std::string& key, double standard, double lower, double upper) {
  const std::string given = text(key, "");
  if (!has(key)) return standard;
  char* end = nullptr;
  const double value = std::strtod(given.c_str(), &end);
  if (given.empty() || *end != '\0' || !(value >= lower && value <= upper))
    refuse(
        format("'%s' is '%s', but must be a number from %g to %g", key.c_str(), given.c_str(), lower, upper));
  return value;
}

int SensorKeys::wholeNumber(const std::string& key, int standard, int lower, int upper) {
  const double value = number(key, standard, lower, upper);
  if (value != std::floor(value))
    refuse(format("'%s' is %g, but must be a whole number", key.c_str(), value));
  return static_cast<int>(value);
}

std::string SensorKeys::word(const std::string& key, const std::string& standard,
                             const std::vector<std::string>& words) {
  const std::string given = text(key, standard);
  if (std::find(words.begin(), words.end(), given) != words.end()) return given;
  refuse("'" + key + "' is '" + given + "', but must be one of " + joined(words, ", "));
}

void SensorKeys::finish() const {
  for (const auto& [key, value] : setup_.keys)
    if (std::find(asked_.begin(), asked_.end(), key) == asked_.end())
      refuse("'" + key + "' is unknown" + didYouMean(key, asked_));
}

void TemperatureDevice::addSensor(const std::string& name, SensorKeys& keys, double standardScale) {
  scales_.push_back(keys.number("scale", standardScale, -1e6, 1e6));
  offsets_.push_back(keys.number("offset", 0.0, -1e6, 1e6));
  names_.push_back(name);
}

std::vector<TemperatureReading> TemperatureDevice::read() {
  std::vector<TemperatureReading> readings(names_.size());
  for (std::size_t i = 0; i < readings.size(); ++i) {
    try {
      readings[i].value = scales_[i] * readOne(i) + offsets_[i];
    } catch (const std::exception& e) {
      readings[i].wrong = e.what();
    }
  }
  return readings;
}

std::vector<std::unique_ptr<TemperatureDevice>> makeTemperatureDevices(
    const std::vector<TemperatureSetup>& sensors, const std::string& sysfs) {
  std::set<std::string> names;
  auto files = std::make_unique<SysfsTemperatures>(sysfs);
  std::map<std::string, std::unique_ptr<ModbusTemperatures>> lines;
  for (const TemperatureSetup& setup : sensors) {
    SensorKeys keys(setup);
    if (setup.name.empty()) throw InputError("a sensor has no name");
    if (!names.insert(setup.name).second) keys.refuse("appears twice; give each sensor its own name");
    int ways = 0;
    for (const char* way : {"hwmon", "iio", "file", "modbus"}) ways += keys.has(way) ? 1 : 0;
    if (ways != 1) keys.refuse("give its source: hwmon, iio, file or modbus");
    if (!keys.has("modbus")) {
      files->add(setup.name, keys);
    } else {
      auto line = std::make_unique<ModbusTemperatures>(keys.text("modbus", ""), keys);
      auto& known = lines[line->device()];  // however it is written: two would take each other's answers
      if (known == nullptr) known = std::move(line);
      known->add(setup.name, keys);
    }
    keys.finish();
  }
  std::vector<std::unique_ptr<TemperatureDevice>> devices;
  if (!files->names().empty()) devices.push_back(std::move(files));
  for (auto& entry : lines) devices.push_back(std::move(entry.second));
  return devices;
}

}  // namespace mm
