#pragma once
#include <filesystem>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

namespace mm {

/// One steady state of a machine, as its controller knows it.
struct CommandedState {
  std::map<std::string, double> position;     // commanded position of each joint, uncompensated: m, rad
  std::map<std::string, int> direction;       // of the joint's last motion: +1, -1; 0 or absent: not known
  std::map<std::string, double> temperature;  // sensor of the controller -> degC
};

/// Positions by joint, ascending, m or rad.
using JointPoints = std::map<std::string, std::vector<double>>;

/// The rules of one controller, applied to the compensation that it has been given. Joints are called as the
/// axes of the controller in small letters (`x`, `y`, `z`, `a`, `b`, `c`). Never the rules of the exporter:
/// each is written from the controller's public documents (docs/interpreters.md), so that the two can be
/// compared.
class Interpreter {
 public:
  virtual ~Interpreter() = default;

  /// Where the motors are driven when `command` is asked for: the command and what the tables add to it, m,
  /// rad, of every joint of `command.position`; joints without a table come back as they are. Of a joint
  /// whose direction is not known the mean of both directions, which no controller drives but which is
  /// between the two.
  /// @throw InputError where the tables need a joint or a temperature that `command` does not have.
  virtual std::map<std::string, double> motors(const CommandedState& command) const = 0;
  /// The joints that the files move or look at, and where the tables over each have points; none where only
  /// reversals and angles are told of it.
  virtual JointPoints points() const = 0;
  /// By the joint that is moved: numbers that its tables take in a memory which all axes share.
  virtual std::map<std::string, std::set<int>> numbers() const { return {}; }
};

/// Reads the files in `folder` as the controller `target` would: names and grammar in docs/interpreters.md.
/// @throw InputError with file, line, field, value and bound for what the controller would refuse, and for a
/// folder without any file of that target; a target that is not one of `interpretedTargets`.
std::unique_ptr<Interpreter> interpret(const std::string& target, const std::filesystem::path& folder);

/// linuxcnc, klipper, marlin, reprapfirmware, grblhal, siemens, heidenhain, fanuc, beckhoff, isg, csv.
std::vector<std::string> interpretedTargets();

}  // namespace mm
