#include "drivers/temperature_trust.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/format.h"

namespace mm {
namespace {

constexpr double kRipple = 1.0;  // K by which a reading may differ from the one before: quantised and noisy
// What a body in a workshop drifts while its sensor is wrong, and how far that is followed.
constexpr double kDrift = 10.0 / 3600.0, kFarthest = 3.0;  // K/s, K
constexpr double kNoticed = 5.0, kSilence = 5.0;           // K, s: a change over a silence that is said
constexpr double kFine = 0.01;  // K: what is read as finely as that changes by its noise alone
// K, from the coarsest: of chips at a mainboard, of DS18B20 with 9 to 12 bits, of decimals.
constexpr std::array<double, 11> kSteps{1.0, 0.5, 0.25, 0.2, 0.125, 0.1, 0.0625, 0.05, 0.025, 0.02, kFine};

bool isMultiple(double value, double step) {
  return std::abs(value - step * std::round(value / step)) < 1e-5;  // float32 has that of 100 degC
}

}  // namespace

TemperatureTrust::TemperatureTrust(std::string name, Settings settings)
    : name_("sensor '" + std::move(name) + "' "), settings_(settings) {}

double TemperatureTrust::step() const {
  for (std::size_t i = 0; i < kSteps.size(); ++i)
    if ((notOf_ >> i & 1U) == 0U) return kSteps[i];
  return 0.0;
}

/// What is read coarsely may stand for long in a steady room, and be right.
double TemperatureTrust::longestStanding() const {
  return settings_.frozenAfter * std::max(1.0, step() / kFine);
}

void TemperatureTrust::hear(double value, double time) {
  if (!number_ || value != value_) changed_ = time;
  before_ = number_ ? value_ : value;
  value_ = value;
  number_ = true;
  for (std::size_t i = 0; i < kSteps.size(); ++i)
    if (!isMultiple(value, kSteps[i])) notOf_ |= 1U << i;
}

bool TemperatureTrust::take(const TemperatureReading& reading, double time) {
  const Doubt before = doubt_;
  if (heard_ && time < *heard_) {
    changed_ = time;
    if (!jumped_) believed_.reset();
  }
  heard_ = time;
  doubt_ = Doubt::kNone;
  why_.clear();
  remark_.clear();
  if (!std::isfinite(reading.value)) {  // a failed reading is no change
    doubt(Doubt::kNoAnswer, "does not answer" + (reading.wrong.empty() ? "" : ": " + reading.wrong));
    return false;
  }
  hear(reading.value, time);
  judge(reading.value, time);
  if (doubt_ != Doubt::kNone) return false;
  if (before != Doubt::kNone && remark_.empty())
    remark_ = name_ + format("is believed again: it reads %.2f degC", reading.value);
  jumped_ = false;
  jump_.clear();
  believed_ = Believed{reading.value, time};
  return true;
}

void TemperatureTrust::doubt(Doubt doubt, std::string why) {
  doubt_ = doubt;
  why_ = name_ + std::move(why);
}

void TemperatureTrust::judge(double value, double time) {
  if (value < kColdest || value > kHottest) {
    doubt(Doubt::kNoTemperature,
          format("reads %.1f degC, which is implausible (%.0f to %.0f)", value, kColdest, kHottest));
    jumped_ = believed_ && settings_.fastest > 0.0;
    return;
  }
  const double away = believed_ ? value - believed_->value : 0.0;
  const double silence = believed_ ? std::max(0.0, time - believed_->time) : 0.0;
  if (jumped_ && comesBack(value, time)) {
    remark_ = name_ + format("is believed again: it reads %.2f degC, %.2f K from what it was %.0f s ago",
                             value, away, silence);
  } else if (jumped_ || (believed_ && settings_.fastest > 0.0 &&
                         std::abs(away) > kRipple + settings_.fastest * silence)) {
    if (jump_.empty())
      jump_ = (jumped_ ? format("reads %.2f degC after implausible values, %.1f K from its value before them",
                                value, away)
                       : format("jumped by %.1f K in %.1f s (~fastest is %g K/s) to %.2f degC", away, silence,
                                settings_.fastest, value)) +
              format(
                  "; it is believed again when it reads %.1f degC to 1 K, or by the service ~accept if it is "
                  "right now",
                  believed_->value);
    jumped_ = true;
    return doubt(Doubt::kJumped, jump_);
  }
  if (settings_.frozenAfter > 0.0 && time - changed_ >= longestStanding()) {
    // Nothing is known since its last change.
    if (believed_) believed_->time = std::min(believed_->time, changed_);
    return doubt(Doubt::kFrozen,
                 format("is frozen: its value has not changed for %.0f s", time - changed_) +
                     (step() > kFine ? format(" (%.0f s in steps of %g K)", longestStanding(), step()) : ""));
  }
  if (settings_.fastest > 0.0 && std::abs(away) > kNoticed && silence > kSilence)
    remark_ = toLookAt_ =
        name_ + format(
                    "reads %.2f degC, %.1f K from what it was before it was not heard for %.0f s; it is "
                    "believed, but see whether it is right, and then call ~accept",
                    value, away, silence);
}

/// A wrong value that stays does not become right by drift: further than a step it must come by a jump of its
/// own.
bool TemperatureTrust::comesBack(double value, double time) const {
  const double away = std::abs(value - believed_->value);
  if (away <= kRipple) return true;
  const double drifted = std::min(kFarthest, kDrift * std::max(0.0, time - believed_->time));
  return std::abs(value - before_) > kRipple && away <= kRipple + drifted;
}

std::string TemperatureTrust::accept() {
  std::string changes;
  if (jumped_ && value_ >= kColdest && value_ <= kHottest) {
    changes = name_ + format("is believed at %.2f degC", value_);
    believed_ = Believed{value_, *heard_};
    jumped_ = false;
    jump_.clear();
  } else if (!toLookAt_.empty()) {
    changes = name_ + format("was looked at, at %.2f degC", value_);
  }
  toLookAt_.clear();
  return changes;
}

}  // namespace mm
