#pragma once
#include <filesystem>
#include <optional>

#include "drivers/temperature_device.h"

namespace mm {

/// A number as the kernel writes it into a file of sysfs: one decimal number and a line break.
/// @return nothing for anything else.
std::optional<double> parseSysfsNumber(const std::string& text);

/// Sensors for which the kernel has a driver. Linux's own documentation says what the files hold
/// ("Naming and data format standards for sysfs files", hwmon; ABI/testing/sysfs-bus-iio):
///   hwmon: <name of the chip>, channel: temp1    class/hwmon/*/temp1_input, in m degC; temp1_fault is 1:
///   broken iio: <name of the device>, channel: temp     bus/iio/devices/*/in_temp_input, in m degC, or
///                                                (in_temp_raw + in_temp_offset) * in_temp_scale, in m degC
///   file: <path>                                 one number in m degC (w1: …/28-…/temperature)
/// Of several chips of a name, `number` (from 0) chooses, in the order of their paths. A chip is looked for
/// again when it is gone: its number changes when it is plugged in anew.
class SysfsTemperatures final : public TemperatureDevice {
 public:
  explicit SysfsTemperatures(std::string sysfs) : sysfs_(std::move(sysfs)) {}  ///< "/sys"
  /// @throw InputError naming the sensor. That a chip is not there is no error: it may come.
  void add(const std::string& name, SensorKeys& keys);

 private:
  enum class Kind { kHwmon, kIio, kFile };
  struct Sensor {
    Kind kind;
    std::string chip, channel;  // of a file: its path
    std::size_t number = 0;
  };
  std::filesystem::path folderOf(const Sensor& sensor) const;
  double readOne(std::size_t sensor) override;

  std::string sysfs_;
  std::vector<Sensor> sensors_;
};

}  // namespace mm
