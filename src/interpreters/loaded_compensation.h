#pragma once
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>

#include "interpreters/external_offsets.h"
#include "interpreters/interpreter.h"
#include "machine/controller_compensation.h"

namespace mm {

/// What representability.json says of a folder that `mm export` wrote.
struct ExportDescription {
  static constexpr const char* kFile = "representability.json";
  static constexpr const char* kKept = "kept";  ///< folder with what was active and goes on

  std::string target, calibration;               // empty target: the folder has no such file
  std::map<std::string, std::string> letters;    // joint -> the controller's axis
  std::map<std::string, std::string> sensors;    // the controller's name -> the calibration's
  std::set<std::string> files;                   // files and folders that it put there
  std::optional<std::set<std::string>> touched;  // axes whose tables are new; null: all that there are
};
/// @throw InputError: the file is there and is not what `mm export` writes.
ExportDescription describeExport(const std::filesystem::path& folder);

/// All that a controller compensates, as its interpreter reads it: the tables of a folder; of an export also
/// what it left as it was (its folder `kept`), and the external offsets beside them.
class LoadedCompensation {
 public:
  /// @throw InputError: what the controller would refuse, by file and line.
  LoadedCompensation(const std::string& target, const std::filesystem::path& folder);

  const ExportDescription& description() const { return description_; }  ///< of the folder
  /// What the tables add to each joint of the command, m or rad. @throw InputError as Interpreter::motors.
  std::map<std::string, double> tablesAdd(const CommandedState& command) const;
  bool hasOffsets() const { return offsets() != nullptr; }  ///< a program adds more, beside the tables
  /// What that program adds to the axes that it moves, m.
  std::map<std::string, double> offsetsAdd(const CommandedState& command) const;
  /// Both together, of each joint of the command.
  std::map<std::string, double> adds(const CommandedState& command) const;

  JointPoints points() const;                            ///< as Interpreter, the offsets' with them
  JointPoints tablePoints() const;                       ///< without the offsets'
  std::map<std::string, std::set<int>> numbers() const;  ///< as Interpreter

 private:
  const ExternalOffsets* offsets() const;
  CommandedState named(const CommandedState& command) const;
  bool ownIs(const std::string& joint) const;

  ExportDescription description_;
  std::unique_ptr<Interpreter> own_;  // null: the folder changes no axis
  std::optional<ExternalOffsets> ownOffsets_;
  std::unique_ptr<const LoadedCompensation> kept_;  // null: nothing
};

/// Of what was stated. @return null unless files were. @throw InputError as the constructor.
std::shared_ptr<const LoadedCompensation> loadedCompensation(const ControllerCompensation& stated);

/// Of the option with such a statement.
inline constexpr const char* kCompensationHelp =
    "what the controller compensated while measuring: none, or the folder with its tables, as mm export "
    "wrote it or as an interpreter reads it [not stated]";

/// Reads a statement as it is typed: `none`, a folder that `mm export` wrote, or one with the files that an
/// interpreter reads (docs/interpreters.md), its controller before it where several could
/// (`linuxcnc:folder`).
/// @param option of which it is the value, for messages. @throw InputError: one line with the folder or the
/// file, why, and the remedy.
ControllerCompensation statedCompensation(const std::string& option, const std::string& told);

}  // namespace mm
