#pragma once
#include <string>

#include "calibration_file/calibration.h"
#include "workflow/recalibration.h"

namespace CLI {
class App;
}

namespace mm {

/// What `add` and `remove` share: one effect more or less, everything refitted, the ledger told.
using ModelChange = Recalibration (*)(const Session&, const Calibration&, const EffectSpec&,
                                      const CalibrateOptions&);
/// @param command the subcommand, without options yet. @param all whether --all goes the whole way: diagnose
/// and add until nothing is missing.
void declareChange(CLI::App& command, ModelChange change, bool all, const std::string& example,
                   int& exitStatus);

}  // namespace mm
