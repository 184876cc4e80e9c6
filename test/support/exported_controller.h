#pragma once
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "export/export_folder.h"
#include "export/export_page.h"
#include "export/representability.h"
#include "loaded_controller.h"
#include "session_files.h"

namespace mm::test {

/// A machine that was calibrated, and the folder that `mm export` writes of it for one target.
class ExportedController {
 public:
  using Added = std::map<std::string, double>;  // m, an axis

  ExportedController(const LoadedController& controller, const std::string& target, bool tablesAlone = false)
      : controller_(controller), target_(target), folder_(files_.path(target)) {
    const ExportTarget& to = exportTarget(target);
    const NeededCorrection needed(controller.calibration, {});
    ExportOptions options;
    options.tablesAlone = tablesAlone;
    const Exported exported = exportedFor(to, needed, options);
    Representability told;  // what each effect leaves is not asked here
    told.target = to.name;
    told.calibration = controller.calibration.id;
    for (const ExportAxis& axis : needed.axes()) told.letters[axis.name] = axis.letter;
    told.sensors = exported.sensors;
    writeExportFolder(folder_, exportFolderOf(controller.calibration, to, needed, exported, told));
    interpreter_ = interpret(target, folder_);
    loaded_ = std::make_unique<const LoadedCompensation>(target, folder_);
  }

  const std::filesystem::path& folder() const { return folder_; }

  /// What the tables add where they are loaded as README.md says.
  Added tables(const CommandedState& command) const {
    Added added = interpreter_->motors(command);
    for (auto& [axis, motor] : added) motor -= command.position.at(axis);
    return added;
  }
  /// What the external offsets add by their file.
  Added offsets(const CommandedState& command) const { return loaded_->offsetsAdd(command); }

  /// A simulated controller that adds these.
  static ControllerAdds loading(const std::function<Added(const CommandedState&)>& adds) {
    return [adds](const auto& command, const auto& travel, const auto&) {
      CommandedState state;
      const std::string axes[] = {"x", "y", "z"};
      for (std::size_t j = 0; j < 3; ++j) {
        state.position[axes[j]] = command[j];
        state.direction[axes[j]] = static_cast<int>(travel[j]);
      }
      Added added = adds(state);
      return std::vector<double>{added["x"], added["y"], added["z"]};
    };
  }

  Verification judge(const Session& session, bool named = true) const {
    VerifyOptions options;
    options.loaded = true;
    options.calibrate.threads = 1;
    if (named) options.exported = std::make_shared<const LoadedExport>(folder_, controller_.calibration);
    return verify(session, controller_.calibration, options);
  }

 private:
  const LoadedController& controller_;
  std::string target_;
  Folder files_;
  std::filesystem::path folder_;
  std::unique_ptr<Interpreter> interpreter_;
  std::unique_ptr<const LoadedCompensation> loaded_;
};

/// Times `factor` on every axis, or on one.
inline ExportedController::Added times(double factor, ExportedController::Added added,
                                       const std::string& axis = {}) {
  for (auto& [name, value] : added)
    if (axis.empty() || name == axis) value *= factor;
  return added;
}

inline ExportedController::Added sum(ExportedController::Added a, const ExportedController::Added& b) {
  for (const auto& [axis, value] : b) a[axis] += value;
  return a;
}

}  // namespace mm::test
