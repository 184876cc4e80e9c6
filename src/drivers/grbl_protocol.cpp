#include "drivers/grbl_protocol.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <sstream>

#include "base/error.h"
#include "base/number_text.h"

namespace mm {
namespace {

constexpr double kMostCode = 255.0, kMostOverride = 1000.0;  // beyond these a line is damaged

struct CodeRow {
  int code;
  const char *text, *remedy;
  bool keepsPosition = false;  // of an alarm
};

constexpr CodeRow kAlarms[] = {
    {kGrblHardLimit, "a limit switch closed",
     "call ~clear_alarm, then home; where homing cannot leave the switch, ~move_off_limit first"},
    {kGrblSoftLimit, "the target is beyond the controller's soft limits",
     "call ~clear_alarm, choose another target", true},
    {3, "it was reset during motion, its position is lost", "call ~clear_alarm, then home again"},
    {4, "the probe was closed before the probing motion", "call ~clear_alarm, retract the probe", true},
    {5, "the probe did not trip on the way", "call ~clear_alarm; look at the probe and the artifact", true},
    {kGrblHomingReset, "homing was ended by a reset", "home again"},
    {7, "homing was ended by the safety door", "close it, then home again"},
    {8, "homing could not leave the switch", "look at the switch, and at the setting $27"},
    {kGrblHomingNoSwitch, "homing did not find the switch",
     "look at the switch, and at the travel $130 to $135"},
    {10, "its emergency stop input is active", "release it, then home again"},
    {kGrblHomingRequired, "homing is required", "home again", true},
};

constexpr CodeRow kErrors[] = {
    {5, "homing is not enabled", "set $22=1 at the controller; of single axes, with grblHAL, $22=3"},
    {8, "it is not idle", "wait until it rests"},
    {9, "it is locked by an alarm", "call ~clear_alarm or home"},
    {13, "the safety door is open", "close it"},
    {kGrblTargetBeyond, "the target is beyond the controller's soft limits", "choose another target"},
    {18, "its reset input is active", "release it"},
    {20, "unknown command", "this needs grbl 1.1 or grblHAL"},
    {22, "the feed rate is missing", ""},
    {45, "a limit switch is closed", "home, or move the axis off it by hand"},
    {46, "homing is required", "call ~home"},
    {50, "its emergency stop input is active", "release it"},
    {kGrblCriticalEvent, "it waits for a reset", "call ~clear_alarm once more"},
};

template <typename Rows>
Alarm meaningOf(const Rows& rows, int code, const std::string& word, const char* otherwise) {
  for (const CodeRow& row : rows)
    if (row.code == code) return {code, row.text, row.remedy};
  return {code, word + " " + std::to_string(code), otherwise};
}

std::vector<std::string> split(const std::string& text, char at) {
  std::vector<std::string> parts;
  std::istringstream in(text);
  for (std::string part; std::getline(in, part, at);) parts.push_back(part);
  return parts;
}

bool number(const std::string& text, double& value) {
  return parseNumber(text, value) && std::isfinite(value);
}

bool numbers(const std::string& text, std::vector<double>& values) {
  values.clear();
  for (const std::string& part : split(text, ',')) {
    double value = 0.0;
    if (!number(part, value)) return false;
    values.push_back(value);
  }
  return !values.empty();
}

std::optional<int> codeAfter(const std::string& line, const std::string& head) {
  double value = 0.0;
  if (line.rfind(head, 0) != 0 || !number(line.substr(head.size()), value)) return std::nullopt;
  if (value < 0.0 || value > kMostCode) return std::nullopt;
  return static_cast<int>(value);
}

}  // namespace

std::optional<GrblReport> parseGrblReport(const std::string& line) {
  if (line.size() < 3 || line.front() != '<' || line.back() != '>') return std::nullopt;
  const std::vector<std::string> fields = split(line.substr(1, line.size() - 2), '|');
  if (fields.empty()) return std::nullopt;
  GrblReport report;
  const std::size_t colon = fields[0].find(':');
  report.state = fields[0].substr(0, colon);
  if (report.state.empty()) return std::nullopt;
  if (colon != std::string::npos) {
    const std::optional<int> substate = codeAfter(fields[0], report.state + ":");
    if (!substate) return std::nullopt;
    report.substate = *substate;
  }
  for (std::size_t f = 1; f < fields.size(); ++f) {
    const std::size_t at = fields[f].find(':');
    if (at == std::string::npos) continue;
    const std::string key = fields[f].substr(0, at), rest = fields[f].substr(at + 1);
    std::vector<double> values;
    if (key == "Pn") {
      report.pins = rest;
      continue;
    }
    if (key != "MPos" && key != "WPos" && key != "WCO" && key != "FS" && key != "F" && key != "Ov") continue;
    if (!numbers(rest, values)) return std::nullopt;
    if (key == "MPos") report.machine = values;
    if (key == "WPos") report.work = values;
    if (key == "WCO") report.offset = values;
    if (key != "Ov") continue;
    if (values[0] < 0.0 || values[0] > kMostOverride) return std::nullopt;
    report.feedOverride = static_cast<int>(values[0]);
  }
  if (report.machine.empty() && report.work.empty()) return std::nullopt;
  return report;
}

bool GrblReport::moves() const {
  return state == "Run" || state == "Jog" || state == "Home" || (state == "Hold" && substate > 0) ||
         (state == "Door" && substate > kGrblDoorOpen);
}

bool GrblReport::doorIsOpen() const {
  return state == "Door" && substate != kGrblDoorClosed && substate != kGrblDoorRestores;
}

GrblShows GrblReport::shows() const {
  if (state == "Idle") return GrblShows::kRest;
  if (state == "Alarm") return substate == kGrblHomingRequired ? GrblShows::kNotHomed : GrblShows::kLocked;
  if ((state == "Hold" || state == "Door") && substate <= 0) return GrblShows::kHeld;
  return state == "Door" && substate == kGrblDoorOpen ? GrblShows::kHeldByDoor : GrblShows::kOther;
}

std::optional<GrblProbe> parseGrblProbe(const std::string& line) {
  if (line.rfind("[PRB:", 0) != 0 || line.back() != ']') return std::nullopt;
  const std::vector<std::string> parts = split(line.substr(5, line.size() - 6), ':');
  GrblProbe probe;
  if (parts.size() != 2 || !numbers(parts[0], probe.machine) || (parts[1] != "0" && parts[1] != "1"))
    return std::nullopt;
  probe.tripped = parts[1] == "1";
  return probe;
}

std::optional<std::pair<int, double>> parseGrblSetting(const std::string& line) {
  const std::size_t equals = line.find('=');
  double id = 0.0, value = 0.0;
  if (line.size() < 4 || line[0] != '$' || equals == std::string::npos) return std::nullopt;
  if (!number(line.substr(1, equals - 1), id) || !number(line.substr(equals + 1), value)) return std::nullopt;
  if (id < 0.0 || id > 10000.0) return std::nullopt;
  return std::make_pair(static_cast<int>(id), value);
}

std::optional<int> parseGrblAnswer(const std::string& line) {
  if (line == "ok") return 0;
  return codeAfter(line, "error:");
}

std::optional<int> parseGrblAlarm(const std::string& line) { return codeAfter(line, "ALARM:"); }

bool isGrblWelcome(const std::string& line) {
  return line.rfind("Grbl ", 0) == 0 || line.rfind("GrblHAL ", 0) == 0 || line.rfind("grblHAL ", 0) == 0;
}

Alarm grblAlarm(int code) {
  return meaningOf(kAlarms, code, "alarm", "see the controller's manual; then ~clear_alarm");
}

Alarm grblError(int code) { return meaningOf(kErrors, code, "error", "see the controller's manual"); }

bool grblAlarmKeepsPosition(int code) {
  return std::any_of(std::begin(kAlarms), std::end(kAlarms),
                     [&](const CodeRow& row) { return row.code == code && row.keepsPosition; });
}

bool grblAlarmIsLimit(int code) { return code == kGrblHardLimit || code == kGrblSoftLimit; }

std::string grblOverride(double share) {
  const int percent = static_cast<int>(std::lround(100.0 * share));
  if (percent < 10) throw InputError("the override of grbl goes down to 0.1");
  std::string bytes(1, '\x90');  // 100 %
  for (int left = 100 - percent; left > 0;) {
    const bool ten = left >= 10;
    bytes += ten ? '\x92' : '\x94';
    left -= ten ? 10 : 1;
  }
  return bytes;
}

}  // namespace mm
