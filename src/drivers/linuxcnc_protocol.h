#pragma once
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace mm {

/// One line of linuxcncrsh: `ABS_ACT_POS 1.0 2.0 …` as its first word and the rest.
struct LinuxCncLine {
  std::string word, rest;
};
/// @return nothing for an empty line or one with bytes that are no text.
std::optional<LinuxCncLine> parseLinuxCncLine(const std::string& line);
/// Numbers between blanks. @return empty where one of them is not a finite number.
std::vector<double> parseLinuxCncNumbers(const std::string& text);

/// The answers to one round of questions.
struct LinuxCncRound {
  double asked = 0.0, came = 0.0;  // s, steady clock; asked 0: none is under way
  bool emergency = false, on = false, probe = false, idle = true, runs = false, mdi = false;
  std::vector<bool> homed;  // LinuxCNC's joints
  std::vector<int> limits;  // -1, 0, 1: at its lower, no, at its upper limit; LinuxCNC's joints
  std::vector<double> absolute, commanded;  // machine coordinates, in the machine's units: X Y Z A B C
  std::string linearUnits, angularUnits;    // of the machine: MM, INCH, CM; DEG, RAD, GRAD
  double feedOverride = 1.0;
  std::set<std::string> answered;  // first words of the answers so far
  bool doubled = false;            // one came twice: of which round it is nobody knows

  /// What is written to begin a round, one question a line.
  static const char* questions();
  /// @return whether the line is an answer of a round.
  bool take(const LinuxCncLine& line);
  /// The last answer of a round, after which nothing comes of it.
  static bool isLast(const LinuxCncLine& line) { return line.word == "PROGRAM_STATUS"; }
  /// Every answer came, once, and the positions are of the same axes. linuxcncrsh can lose one (see
  /// LinuxCncTalk).
  bool complete() const;
};

}  // namespace mm
