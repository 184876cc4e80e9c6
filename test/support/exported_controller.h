#pragma once
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "base/format.h"
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

  /// The table of a simulated controller that adds the sum of these.
  std::string table(const std::function<Added(const CommandedState&)>& adds) const {
    std::string text =
        "x_mm,y_mm,z_mm,x_travel,y_travel,z_travel,correction_x_um,correction_y_um,correction_z_um\n";
    constexpr double kMm = 1e-3;
    for (double x = -20.0; x <= 20.0; x += 10.0)
      for (double y = -15.0; y <= 35.0; y += 12.5)
        for (double z = -20.0; z <= 20.0; z += 10.0)
          for (int way = 0; way < 8; ++way) {
            CommandedState state;
            state.position = {{"x", x * kMm}, {"y", y * kMm}, {"z", z * kMm}};
            state.direction = {{"x", (way & 1) != 0 ? 1 : -1},
                               {"y", (way & 2) != 0 ? 1 : -1},
                               {"z", (way & 4) != 0 ? 1 : -1}};
            Added added = adds(state);
            text += format("%g,%g,%g,%d,%d,%d,%.5f,%.5f,%.5f\n", x, y, z, state.direction["x"],
                           state.direction["y"], state.direction["z"], added["x"] * 1e6, added["y"] * 1e6,
                           added["z"] * 1e6);
          }
    return text;
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
