#pragma once
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "measuring_machine/axis_controller.h"

namespace mm {

inline constexpr char kGrblSoftReset =
    '\x18';  // a real-time byte: ends everything, keeps the position at rest

// What grbl 1.1 and grblHAL say, as documented in their interface descriptions ("Grbl v1.1 Interface",
// "grblHAL: extended protocol"). Lengths are mm, angles deg, as on the wire.

// Codes that more is made of than words: alarms, and errors.
inline constexpr int kGrblHardLimit = 1, kGrblSoftLimit = 2, kGrblHomingReset = 6, kGrblHomingNoSwitch = 9,
                     kGrblHomingRequired = 11;
inline constexpr int kGrblTargetBeyond = 15, kGrblCriticalEvent = 79;

/// What a report says of what is under way; kHeld, kHeldByDoor: at rest, and what is left of a motion waits,
/// for ~resume, or for the door to be closed.
enum class GrblShows { kRest, kHeld, kHeldByDoor, kLocked, kNotHomed, kOther };

/// `<Idle|MPos:0.000,0.000,0.000|FS:0,0|WCO:0.000,0.000,0.000|Ov:100,100,100|Pn:P>`
struct GrblReport {
  std::string state;                  // Idle, Run, Hold, Jog, Alarm, Door, Check, Home, Sleep, Tool
  int substate = -1;                  // of Hold and Door; of Alarm in grblHAL: its code
  std::vector<double> machine, work;  // MPos, WPos; empty: not in the report
  std::vector<double> offset;         // WCO; empty: not in this report
  int feedOverride = 0;               // %; 0: not in this report
  std::string pins;                   // letters of Pn: X Y Z A B C: limit switches; P: probe

  GrblShows shows() const;
  bool moves() const;       ///< its axes, for whomever; in a hold on the way to rest, too
  bool doorIsOpen() const;  ///< the safety door
};
inline constexpr int kGrblDoorRestores = 3;
inline constexpr int kGrblDoorClosed = 0,
                     kGrblDoorOpen = 1;  // substates at rest; 2, 3: on the way there or back
/// @return nothing when it is no status report, or a damaged one.
std::optional<GrblReport> parseGrblReport(const std::string& line);

/// `[PRB:0.000,0.000,1.492:1]`: machine position at the trip, and whether there was one.
struct GrblProbe {
  std::vector<double> machine;
  bool tripped = false;
};
std::optional<GrblProbe> parseGrblProbe(const std::string& line);  ///< `[PRB:…]`; nothing: another line

/// `$110=500.000`: number and value. @return nothing for other lines.
std::optional<std::pair<int, double>> parseGrblSetting(const std::string& line);
/// `ok` is 0, `error:9` is 9. @return nothing for other lines.
std::optional<int> parseGrblAnswer(const std::string& line);
/// `ALARM:1` is 1. @return nothing for other lines.
std::optional<int> parseGrblAlarm(const std::string& line);
/// The line with which a controller begins: `Grbl 1.1h ['$' for help]`, `GrblHAL 1.1f [...]`.
bool isGrblWelcome(const std::string& line);

Alarm grblAlarm(int code);  ///< what ALARM:code means, and what to do
Alarm grblError(int code);  ///< what error:code means, and what to do
/// Whether the position is still known after an alarm.
bool grblAlarmKeepsPosition(int code);
/// Of a switch or of the travel: until it is reset, grbl 1.1 answers nothing more.
bool grblAlarmIsLimit(int code);

/// Real-time bytes that bring the feed override from whatever it is to a share. @throw InputError below 0.1.
std::string grblOverride(double share);

}  // namespace mm
