#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace mm {

/// One state of LinuxCNC, as `linuxcnc_helper watch` tells it.
struct LinuxCncState {
  double time = 0.0, within = 0.0;        // s, steady clock; how well it is known
  std::int64_t echo = 0;                  // serial number of the last command that LinuxCNC took
  std::int64_t lapses = 0;                // how often the helper aborted a motion for want of a beat
  bool busy = false;                      // something is under way, a motion or a command
  bool emergency = false, on = false;     // of the machine
  bool probe = false, tripped = false;    // its switch; the last probing motion met something
  std::vector<bool> homed;                // LinuxCNC's joints
  std::vector<std::int64_t> limits;       // -1, 0, 1: at its lower, no, at its upper limit; LinuxCNC's joints
  std::vector<double> actual, commanded;  // X Y Z A B C in machine coordinates, mm or deg
  std::vector<double> probed;          // the same where the probe tripped last: feedback, latched by motion
  std::int64_t axes = 0;               // bits of X Y Z A B C that the machine has
  double linear = 0.0, angular = 0.0;  // units of the machine per mm and deg
  double override = 1.0;               // of the feed
  std::vector<std::string> said;       // errors since the state before
};

/// What a line of the helper is: a state, or that LinuxCNC was given a command, or why the helper ends.
struct LinuxCncLine {
  enum class Kind { kState, kTaken, kTrouble } kind = Kind::kTrouble;
  LinuxCncState state;
  std::int64_t taken = 0, serial = 0;  // number of the driver's command, and LinuxCNC's
  std::string trouble;
};

/// @throw Error saying what is wrong with it.
LinuxCncLine parseLinuxCncLine(const std::string& line);

}  // namespace mm
