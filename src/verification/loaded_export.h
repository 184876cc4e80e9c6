#pragma once
#include <Eigen/Core>
#include <filesystem>
#include <map>
#include <string>

#include "calibration_file/calibration.h"
#include "export/needed_correction.h"
#include "interpreters/loaded_compensation.h"

namespace mm {

/// The tables that `mm export` wrote for a controller, as that controller reads them, and the external
/// offsets beside them: what each adds to a command beyond what was active when the calibration was measured.
/// It may be less than the calibration asks for.
class LoadedExport {
 public:
  /// @param folder that `mm export` wrote. @throw InputError: it is none, of another calibration, or holds
  /// what the controller would refuse.
  LoadedExport(const std::filesystem::path& folder, const Calibration& calibration);

  const std::string& target() const { return loaded_.description().target; }  ///< linuxcnc, klipper …
  /// The statement of a session that was measured with it.
  const ControllerCompensation& statement() const { return statement_; }
  /// What the controller adds to each joint at a commanded state: m, rad. NaN where the tables need an input
  /// that was not recorded there.
  Eigen::VectorXd adds(const State& command) const;
  /// Whether the folder holds external offsets, which a program adds beside the tables.
  bool hasOffsets() const { return hasOffsets_; }
  /// What that program adds to each joint: m; 0 where the folder has none.
  Eigen::VectorXd offsetsAdd(const State& command) const;

 private:
  using Adds = std::map<std::string, double> (LoadedCompensation::*)(const CommandedState&) const;
  Eigen::VectorXd more(const State& command, Adds adds) const;

  LoadedCompensation loaded_;
  NeededCorrection needed_;
  ControllerCompensation statement_;
  bool hasOffsets_ = false;
};

}  // namespace mm
