#pragma once
#include <functional>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "calibration_file/calibration.h"
#include "export/export_target.h"

namespace mm {

/// What a target's tables leave, over the calibrated volume, temperatures, directions of travel and duration.
/// Root mean square of a coordinate, m: of those along which a linear axis moved in the session or the model
/// errs. Where the machine is driven by the target's rules (src/interpreters) against where the full model
/// says that it was commanded. What an alignment of the workpiece sets anew, one displacement and one small
/// rotation of all states, is taken out; `unaligned` takes out the displacement alone.
struct ExportFigures {
  double uncorrected = 0.0, exported = 0.0;
  double unalignedUncorrected = 0.0, unalignedExported = 0.0;
  double withOffsets =
      std::numeric_limits<double>::quiet_NaN();  // and what Exported::offsets tells of adds; NaN: nothing
};

/// What is left of the model somewhere, and how sure the model is there. Over the same states, alignment
/// taken out.
struct LeftOfModel {
  double rms = std::numeric_limits<double>::quiet_NaN();  // m; NaN: there is no such correction
  double byParameters = 0.0;  // m: RMS of the standard uncertainty of the model's error, by its parameters
  double squareStd = 0.0;     // m^2: standard uncertainty, by the parameters, of the mean square error
};

/// The figures of ExportFigures along one direction of the workpiece's frame.
struct LeftAlong {
  std::string direction;  // x, y or z; empty: a coordinate, the mean square of all of them
  LeftOfModel uncorrected, exported, withOffsets, full;
};

/// A root mean square error and its standard uncertainty, m.
struct ExpectedError {
  double rms = 0.0, std = 0.0;
  std::string inWords() const;  ///< "0.8 ± 0.2 um"
};

/// One effect of the model, exported alone.
struct CarriedEffect {
  EffectSpec effect;
  std::string iso230;   // its symbol (ErrorSymbols); empty: it has none
  std::string carried;  // exact, approximate or none
  std::string why;
  ExportFigures figures;
};

struct Representability {
  std::string target, calibration;             // the controller; id of what was exported
  std::map<std::string, std::string> letters;  // joint -> the controller's axis
  std::map<std::string, std::string> sensors;  // the controller's name of a sensor -> the calibration's
  ExportFigures figures;
  std::vector<LeftAlong> along;       // a coordinate, and, where there are several, each direction
  std::vector<std::string> notMoved;  // directions left out: an axis moves there, but not in the session
  double degreesOfFreedom = 0.0;      // of the session's residuals; 0: not told
  double heldOut = 0.0;        // m: RMS that the full model left of the session, held out where that is known
  double repeatability = 0.0;  // m, of a contact of the session
  std::vector<CarriedEffect> effects;
  std::vector<std::string> notFollowed;  // Exported::notFollowed
  std::set<std::string> touched;         // Exported::axes
  ControllerCompensation compensation;   // that was active while measuring
  std::string activeWords;               // activeWords()
  std::vector<ExportedFile> files;

  /// What the full model does not explain of the session beyond the scatter of a contact:
  /// sqrt(max(0, held out^2 - repeatability^2)), m; NaN: the session has no lengths.
  double unexplained() const;
  /// The error of the corrected position: what is left of the model, the uncertainty of its parameters, and
  /// what it does not explain. Held-out residuals contain the parameters' uncertainty at the session's
  /// points, so that of the latter two the larger counts. Its uncertainty is that of the parameters and of a
  /// standard deviation by so many degrees of freedom (GUM E.4.3).
  ExpectedError expected(const LeftOfModel& left) const;
  /// The same as a single measurement of the session's repeatability shows it.
  ExpectedError measured(const LeftOfModel& left) const;
  bool carriesNothing() const;  ///< the export is no better than no correction
};

/// @param progress told the effect that is next, and the share of the work. @throw InputError,
/// NumericalError.
using ExportProgress = std::function<void(const std::string&, double)>;

/// Exports, and judges the export by the target's interpreter.
Representability representability(const Calibration& calibration, const ExportTarget& target,
                                  const ExportOptions& options, const NeededCorrection& needed,
                                  const Exported& exported, const ExportProgress& progress = {});

/// `{"target": …, "rms_um": {"uncorrected": …, "exported": …, "full": 0}, "expected_rms_um": {the same},
/// "measured_rms_um": {the same}, "along": [{"direction": "x", …}], "unexplained_um": …, "effects": […],
/// "files": […]}`: rms_um is of what the model says, of which the full model leaves nothing.
nlohmann::ordered_json representabilityJson(const Representability& judged);
/// The same for people.
std::string representabilityText(const Representability& judged);

}  // namespace mm
