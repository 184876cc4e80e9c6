#pragma once
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <string>

#include "base/error.h"
#include "base/temporary_folder.h"
#include "base/units.h"
#include "interpreters/interpreter.h"

namespace mm {

/// A folder with the files of a controller, gone with the object.
class TableFolder : public TemporaryFolder {
 public:
  TableFolder() = default;
  explicit TableFolder(const std::map<std::string, std::string>& files) {
    for (const auto& [name, text] : files) write(name, text);
  }
  TableFolder& file(const std::string& name, const std::string& text) {
    write(name, text);
    return *this;
  }
};

/// A state in mm; `direction` of all of its joints.
inline CommandedState atMillimetres(const std::map<std::string, double>& position, int direction = 1) {
  CommandedState command;
  for (const auto& [joint, value] : position) {
    command.position[joint] = value * kMillimetre;
    command.direction[joint] = direction;
  }
  return command;
}

/// What is added to the motor of `joint`, um.
inline double addedMicrometres(const Interpreter& interpreter, const CommandedState& command,
                               const std::string& joint) {
  return (interpreter.motors(command).at(joint) - command.position.at(joint)) / kMicrometre;
}

/// The message with which files are refused; empty: they are not.
inline std::string refusal(const std::string& target, const TableFolder& folder) {
  try {
    interpret(target, folder.path());
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

/// The same of files by their names.
inline std::string refusalOf(const std::string& target, const std::map<std::string, std::string>& files) {
  return refusal(target, TableFolder(files));
}

inline constexpr double kNanometre = 1e-3;  // of um: what sums of numbers of tables leave

}  // namespace mm
