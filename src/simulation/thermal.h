#pragma once
#include <string>
#include <vector>

#include "base/random.h"

namespace mm {

/// One body of the structural loop: a lump of one temperature.
struct Body {
  std::string name;
  double capacity = 0.0;     // J/K
  double toAir = 0.0;        // W/K
  double motionPower = 0.0;  // W when every axis moves at its highest speed or a probe cycle keeps it busy
  double idlePower = 0.0;    // W
};

/// Heat flow between two bodies.
struct Contact {
  int first = 0, second = 0;
  double conductance = 0.0;  // W/K
};

/// Heat that is switched on and off, e.g. of a heated bed.
struct HeatSchedule {
  int body = 0;
  double power = 0.0;            // W
  double from = 0.0, to = 0.0;   // s
  double every = 0.0;            // s between repetitions; 0: once
  double at(double time) const;  ///< W; time in s
};

/// A body inside the structure that follows another with a first-order lag and gives nothing back.
struct Follower {
  int body = 0;
  double lag = 0.0;  // s
};

/// Temperature of the room: start, ramp and a swing.
struct Ambient {
  double start = 20.0;           // degC
  double ramp = 0.0;             // K/s
  double swing = 0.0;            // K
  double period = 3600.0;        // s
  double at(double time) const;  ///< degC; time in s
};

/// Heat balances of the machine's bodies: C dT/dt = power - sum of conductance * temperature difference.
/// The last body is always the air, whose temperature is given.
class ThermalModel {
 public:
  /// All bodies start at the room's temperature.
  ThermalModel(std::vector<Body> bodies, std::vector<Contact> contacts, std::vector<HeatSchedule> heat,
               Ambient ambient);
  /// motor, frame, bed, air of a machine as large as a shoe box.
  static std::vector<Body> usualBodies();
  static std::vector<Contact> usualContacts();

  /// Adds followers, settled; their indices begin at bodyCount().
  void addFollowers(const std::vector<Follower>& followers);
  /// Bodies and air, without followers.
  int bodyCount() const { return static_cast<int>(bodies_.size()) + 1; }
  /// @return index of a body, air included, or -1.
  int findBody(const std::string& name) const;
  /// degC, of bodies, air and followers.
  const std::vector<double>& temperatures() const { return temperatures_; }
  /// Lets `seconds` pass. @param activity share of the highest speed at which the axes move, 0 to 1.
  void advance(double seconds, double activity);
  /// Temperatures at an earlier time (s), between the recorded ones; the last ones beyond the end.
  std::vector<double> recorded(double time) const;

 private:
  void rates(double time, double activity, const std::vector<double>& temperatures,
             std::vector<double>& out) const;
  void step(double seconds, double activity);
  void record();

  std::vector<Body> bodies_;
  std::vector<Contact> contacts_;
  std::vector<HeatSchedule> heat_;
  Ambient ambient_;
  std::vector<Follower> followers_;
  double time_ = 0.0;
  std::vector<double> temperatures_;
  std::vector<double> recordTimes_;
  std::vector<std::vector<double>> records_;
};

/// A temperature sensor: it lags behind its body, has noise and an offset, and reads in steps.
class TemperatureSensor {
 public:
  TemperatureSensor(int body, double lag, double noise, double offset = 0.0, double step = 0.0)
      : body_(body), lag_(lag), noise_(noise), offset_(offset), step_(step) {}
  void settle(double temperature) { value_ = temperature; }  ///< degC, without lag
  void advance(double seconds, double bodyTemperature);      ///< s, degC
  double value() const { return value_ + offset_; }          ///< degC, without noise and steps
  double read(Random& random) const;                         ///< degC
  int body() const { return body_; }                         ///< index in the thermal model

 private:
  int body_;
  double lag_, noise_, offset_, step_;  // s, K; step 0: none
  double value_ = 20.0;
};

}  // namespace mm
