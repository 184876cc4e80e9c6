#include "drivers/sysfs_temperature.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/format.h"
#include "base/nearest_name.h"
#include "base/number_text.h"
#include "base/read_file.h"
#include "base/text.h"

namespace mm {
namespace {

namespace fs = std::filesystem;

constexpr double kMilli = 1e-3;
constexpr std::size_t kLongestNumber = 64;  // characters

/// A file of the kernel with one number. @throw InputError naming it.
double numberIn(const fs::path& file) {
  const std::string text = readWholeFile(file, "check the sensor and its driver");
  if (const std::optional<double> value = parseSysfsNumber(text)) return *value;
  std::string shown;
  for (const char c : text.substr(0, 20)) shown += c >= ' ' && c <= '~' ? c : '?';
  throw InputError(file.string() + ": holds '" + shown + "', not a number");
}

std::optional<double> numberIfThere(const fs::path& file) {
  std::error_code error;
  if (!fs::exists(file, error)) return std::nullopt;
  return numberIn(file);
}

std::string firstLine(const fs::path& file) {
  try {
    const std::string text = readWholeFile(file, "");
    return text.substr(0, text.find('\n'));
  } catch (const InputError&) {
    return {};
  }
}

}  // namespace

std::optional<double> parseSysfsNumber(const std::string& text) {
  const std::string number = text.substr(0, text.size() - (endsWith(text, "\n") ? 1 : 0));
  double value = 0.0;
  if (number.size() > kLongestNumber || !parseNumber(number, value) || !std::isfinite(value))
    return std::nullopt;
  return value;
}

void SysfsTemperatures::add(const std::string& name, SensorKeys& keys) {
  Sensor sensor;
  sensor.kind = keys.has("hwmon") ? Kind::kHwmon : keys.has("iio") ? Kind::kIio : Kind::kFile;
  if (sensor.kind == Kind::kFile) {
    sensor.channel = keys.text("file", "");
    if (sensor.channel.empty() || sensor.channel[0] != '/')
      keys.refuse("'file' must be a path that begins with /");
  } else {
    sensor.chip = keys.text(sensor.kind == Kind::kHwmon ? "hwmon" : "iio", "");
    sensor.channel = keys.text("channel", sensor.kind == Kind::kHwmon ? "temp1" : "temp");
    if (sensor.chip.empty() || sensor.channel.empty()) keys.refuse("the chip and its channel need names");
    if (sensor.channel.find('/') != std::string::npos)
      keys.refuse("'channel' is a name as temp1, not a path");
    sensor.number = static_cast<std::size_t>(keys.wholeNumber("number", 0, 0, 99));
  }
  addSensor(name, keys, 1.0);
  sensors_.push_back(std::move(sensor));
}

fs::path SysfsTemperatures::folderOf(const Sensor& sensor) const {
  const fs::path all = fs::path(sysfs_) / (sensor.kind == Kind::kHwmon ? "class/hwmon" : "bus/iio/devices");
  std::vector<fs::path> found;
  std::vector<std::string> there;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(all, error)) {
    const std::string name = firstLine(entry.path() / "name");
    if (name == sensor.chip) found.push_back(entry.path());
    if (!name.empty()) there.push_back(name);
  }
  if (found.size() > sensor.number) {
    std::sort(found.begin(), found.end());
    return found[sensor.number];
  }
  throw InputError(all.string() + ": there is no '" + sensor.chip + "'" +
                   (sensor.number > 0 ? format(" number %zu", sensor.number) : "") +
                   "; there are: " + listOf(there));
}

double SysfsTemperatures::readOne(std::size_t i) {
  const Sensor& sensor = sensors_[i];
  if (sensor.kind == Kind::kFile) return kMilli * numberIn(sensor.channel);
  const fs::path folder = folderOf(sensor);
  if (sensor.kind == Kind::kHwmon) {
    const std::optional<double> fault = numberIfThere(folder / (sensor.channel + "_fault"));
    if (fault && *fault != 0.0) throw InputError("its driver reports a fault (" + sensor.channel + "_fault)");
    return kMilli * numberIn(folder / (sensor.channel + "_input"));
  }
  const std::string channel = "in_" + sensor.channel;
  if (const std::optional<double> processed = numberIfThere(folder / (channel + "_input")))
    return kMilli * *processed;
  const double raw = numberIn(folder / (channel + "_raw"));
  const double offset = numberIfThere(folder / (channel + "_offset")).value_or(0.0);
  return kMilli * (raw + offset) * numberIn(folder / (channel + "_scale"));
}

}  // namespace mm
