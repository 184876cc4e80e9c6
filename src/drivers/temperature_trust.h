#pragma once
#include <optional>
#include <string>

#include "drivers/temperature_device.h"

namespace mm {

/// Whether what one sensor says can be believed, reading by reading; knows the time by the readings alone.
/// A reading is not believed that is no number, beyond any thermometer, unchanged for too long, or further
/// from the last one that was believed than a body can warm in the time in which nothing was heard.
/// A sensor that jumped is alive and says a wrong value, or is another one: no time makes that right. It is
/// believed again when it comes back to what it said before, or when somebody says that it is right
/// (`accept`).
class TemperatureTrust {
 public:
  struct Settings {
    double frozenAfter = 1800.0;  // s without a change of a sensor that resolves 0.01 K; 0: it may stand
    double fastest = 1.0;         // K/s; 0: it may change as it likes
  };
  enum class Doubt { kNone, kNoAnswer, kNoTemperature, kFrozen, kJumped };

  /// @param name of the sensor, for what is said of it.
  TemperatureTrust(std::string name, Settings settings);

  /// One reading. @param time s, on any clock; where it goes back, nothing is known of the time before.
  /// @return whether the reading is believed.
  bool take(const TemperatureReading& reading, double time);
  /// Why the last reading was not believed.
  Doubt doubt() const { return doubt_; }
  const std::string& why() const { return why_; }  ///< the same for people; empty: it was believed
  /// What must be said of a reading that was believed: that the sensor is believed again, or that it is far
  /// from where it was before a silence. Empty: nothing.
  const std::string& remark() const { return remark_; }
  /// A change over a silence that nobody has looked at yet; empty: none.
  const std::string& toLookAt() const { return toLookAt_; }
  /// Somebody says that the sensor is right as it is. @return what that changes, for people; empty: nothing.
  std::string accept();

  double value() const { return value_; }  ///< degC, the last number; 0: none yet
  /// K: the coarsest step of which all readings so far are multiples; 0: finer than 0.01 K.
  double step() const;

 private:
  /// A reading that was believed, and until when nothing is known to have been wrong.
  struct Believed {
    double value = 0.0, time = 0.0;  // degC, s
  };
  void hear(double value, double time);
  void judge(double value, double time);
  void doubt(Doubt doubt, std::string why);
  bool comesBack(double value, double time) const;
  double longestStanding() const;

  std::string name_;
  Settings settings_;
  std::optional<double> heard_;  // s, when anything was said
  std::optional<Believed> believed_;
  bool jumped_ = false;  // since then, and not back yet
  std::string jump_;     // how, for people
  double value_ = 0.0, before_ = 0.0, changed_ = 0.0;
  bool number_ = false;  // there was one
  unsigned notOf_ = 0;   // a bit for each of the steps that sensors have: a reading was no multiple of it
  Doubt doubt_ = Doubt::kNone;
  std::string why_, remark_, toLookAt_;
};

}  // namespace mm
