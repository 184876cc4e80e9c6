#pragma once
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "base/error.h"
#include "base/units.h"
#include "interpreters/interpreter.h"

namespace mm {

/// A folder with the files of a controller, gone with the object.
class TableFolder {
 public:
  TableFolder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "mm_tables_XXXXXX").string();
    path_ = mkdtemp(pattern.data());
  }
  ~TableFolder() { std::filesystem::remove_all(path_); }
  TableFolder(const TableFolder&) = delete;
  TableFolder& operator=(const TableFolder&) = delete;

  TableFolder& file(const std::string& name, const std::string& text) {
    std::ofstream(path_ / name) << text;
    return *this;
  }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
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

inline constexpr double kNanometre = 1e-3;  // of um: what sums of numbers of tables leave

}  // namespace mm
