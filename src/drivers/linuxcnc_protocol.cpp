#include "drivers/linuxcnc_protocol.h"

#include <cmath>
#include <sstream>

namespace mm {
namespace {

constexpr std::size_t kAnswers = 12;  // of a round that are needed; messages are asked for beside them

std::vector<std::string> wordsOf(const std::string& text) {
  std::vector<std::string> words;
  std::istringstream in(text);
  for (std::string word; in >> word;) words.push_back(word);
  return words;
}

}  // namespace

std::optional<LinuxCncLine> parseLinuxCncLine(const std::string& line) {
  for (const char c : line)
    if (static_cast<unsigned char>(c) < ' ' && c != '\t') return std::nullopt;
  const std::size_t first = line.find_first_not_of(' ');
  if (first == std::string::npos) return std::nullopt;
  const std::size_t blank = line.find(' ', first);
  LinuxCncLine parsed;
  parsed.word = line.substr(first, blank == std::string::npos ? std::string::npos : blank - first);
  const std::size_t rest = blank == std::string::npos ? blank : line.find_first_not_of(' ', blank);
  if (rest != std::string::npos) parsed.rest = line.substr(rest);
  return parsed;
}

std::vector<double> parseLinuxCncNumbers(const std::string& text) {
  std::vector<double> values;
  for (const std::string& word : wordsOf(text)) {
    std::istringstream number(word);
    double value = 0.0;
    if (!(number >> value) || number.peek() != EOF || !std::isfinite(value)) return {};
    values.push_back(value);
  }
  return values;
}

const char* LinuxCncRound::questions() {
  return "get estop\r\nget machine\r\nget joint_homed\r\nget joint_limit\r\nget abs_act_pos\r\n"
         "get abs_cmd_pos\r\nget probe_value\r\nget mode\r\nget feed_override\r\nget user_linear_units\r\n"
         "get user_angular_units\r\nget error\r\nget operator_display\r\nget program_status\r\n";
}

bool LinuxCncRound::take(const LinuxCncLine& line) {
  const std::string &word = line.word, &rest = line.rest;
  if (word == "ESTOP") {
    emergency = rest == "ON";
  } else if (word == "MACHINE") {
    on = rest == "ON";
  } else if (word == "JOINT_HOMED") {
    homed.clear();
    for (const std::string& one : wordsOf(rest)) homed.push_back(one == "YES");
  } else if (word == "JOINT_LIMIT") {
    limits.clear();  // OK, MINSOFT, MINHARD, MAXSOFT, MAXHARD
    for (const std::string& one : wordsOf(rest))
      limits.push_back(one.rfind("MIN", 0) == 0 ? -1 : one.rfind("MAX", 0) == 0 ? 1 : 0);
  } else if (word == "ABS_ACT_POS") {
    absolute = parseLinuxCncNumbers(rest);
    if (absolute.empty()) return true;
  } else if (word == "ABS_CMD_POS") {
    commanded = parseLinuxCncNumbers(rest);
    if (commanded.empty()) return true;
  } else if (word == "USER_LINEAR_UNITS") {
    linearUnits = rest;
  } else if (word == "USER_ANGULAR_UNITS") {
    angularUnits = rest;
  } else if (word == "MODE") {
    mdi = rest == "MDI";
  } else if (word == "PROBE_VALUE") {
    probe = rest != "0";
  } else if (word == "FEED_OVERRIDE") {
    const std::vector<double> percent = parseLinuxCncNumbers(rest);
    if (percent.size() != 1) return true;
    feedOverride = 0.01 * percent[0];
  } else if (word == "PROGRAM_STATUS") {
    idle = rest == "IDLE";
    runs = rest == "RUNNING";
  } else {
    return false;
  }
  doubled = !answered.insert(word).second || doubled;
  return true;
}

bool LinuxCncRound::complete() const {
  return answered.size() == kAnswers && !doubled && asked > 0.0 && commanded.size() == absolute.size();
}

}  // namespace mm
