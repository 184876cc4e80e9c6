#pragma once
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace mm {

/// One sensor as the user describes it: `name`, where it is (`hwmon`, `iio`, `file` or `modbus`, with the
/// keys that belong to it), and `scale` and `offset` of a converter behind it: degC = scale * reading +
/// offset.
struct TemperatureSetup {
  std::string name;                         // becomes the topic
  std::map<std::string, std::string> keys;  // without `name`
};

/// What one sensor says now.
struct TemperatureReading {
  double value = std::numeric_limits<double>::quiet_NaN();  // degC; NaN: it does not answer
  std::string wrong;                                        // why not, for people
};

class SensorKeys;

/// Sensors behind one way to them: files of the kernel, or one serial line. Used by one thread.
class TemperatureDevice {
 public:
  virtual ~TemperatureDevice() = default;
  /// Of its sensors, in the order in which `read` gives them.
  const std::vector<std::string>& names() const { return names_; }
  /// Asks every sensor once; waits for a line no longer than its timeout for each. A sensor that does not
  /// answer does not keep the others from being read, and is asked again the next time. Throws nothing.
  std::vector<TemperatureReading> read();

 protected:
  /// Puts a sensor behind the others, with the keys `scale` and `offset`. @throw InputError.
  void addSensor(const std::string& name, SensorKeys& keys, double standardScale);
  /// What the sensor at that place in `names` reads, before scale and offset. @throw std::exception, for
  /// people, where it has none.
  virtual double readOne(std::size_t sensor) = 0;

 private:
  std::vector<std::string> names_;
  std::vector<double> scales_, offsets_;
};

/// The devices of these sensors: one for all files of the kernel, one for each serial line.
/// @param sysfs where the kernel shows its devices: "/sys". @throw InputError naming sensor, key, value and
/// bound: an unknown, missing or doubled key or name, a number that is none.
std::vector<std::unique_ptr<TemperatureDevice>> makeTemperatureDevices(
    const std::vector<TemperatureSetup>& sensors, const std::string& sysfs);

/// Keys of one sensor, read one after the other; what was not asked for is unknown.
class SensorKeys {
 public:
  explicit SensorKeys(const TemperatureSetup& setup) : setup_(setup) {}
  bool has(const std::string& key) const { return setup_.keys.count(key) > 0; }  ///< whether it is given
  std::string text(const std::string& key, const std::string& standard);         ///< standard where it is not
  /// @throw InputError where it is no number, or outside the bounds.
  double number(const std::string& key, double standard, double lower, double upper);
  /// @throw InputError where it is no whole number, or outside the bounds.
  int wholeNumber(const std::string& key, int standard, int lower, int upper);
  /// One of these words. @throw InputError.
  std::string word(const std::string& key, const std::string& standard,
                   const std::vector<std::string>& words);
  void finish() const;  ///< @throw InputError naming a key that was not asked for
  [[noreturn]] void refuse(const std::string& why) const;  ///< @throw InputError naming the sensor

 private:
  const TemperatureSetup& setup_;
  std::vector<std::string> asked_;
};

/// No thermometer of a machine reads beyond these: what does is none, or its line is damaged. degC.
inline constexpr double kColdest = -100.0, kHottest = 500.0;

}  // namespace mm
