#pragma once
#include <Eigen/Core>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "calibration_file/calibration.h"
#include "export/needed_correction.h"
#include "interpreters/external_offsets.h"

namespace mm {

/// The tables that `mm export` wrote for a controller, as that controller reads them, and the external
/// offsets beside them: what each adds to a command, which may be less than the calibration asks for.
class LoadedExport {
 public:
  /// @param folder that `mm export` wrote. @throw InputError: it is none, of another calibration, or holds
  /// what the controller would refuse.
  LoadedExport(const std::filesystem::path& folder, const Calibration& calibration);

  const std::string& target() const { return target_; }  ///< linuxcnc, klipper …
  /// What the controller adds to each joint at a commanded state: m, rad. NaN where the tables need an input
  /// that was not recorded there.
  Eigen::VectorXd adds(const State& command) const;
  /// Whether the folder holds external offsets, which a program adds beside the tables.
  bool hasOffsets() const { return offsets_.has_value(); }
  /// What that program adds to each joint: m; 0 where the folder has none.
  Eigen::VectorXd offsetsAdd(const State& command) const;

 private:
  struct Description;  // of the folder: representability.json
  static Description describe(const std::filesystem::path& folder);
  LoadedExport(const std::filesystem::path& folder, const Calibration& calibration,
               const Description& described);
  CommandedState commandOf(const State& command) const;

  std::string target_;
  std::map<std::string, std::string> sensors_;  // the controller's name -> the calibration's
  NeededCorrection needed_;
  std::unique_ptr<Interpreter> interpreter_;
  std::optional<ExternalOffsets> offsets_;
};

}  // namespace mm
