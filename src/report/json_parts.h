#pragma once
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "base/json_number.h"
#include "calibration_file/calibration.h"
#include "diagnosis/diagnose.h"
#include "effects/effect_spec.h"
#include "estimation/calibrate.h"
#include "session/sense_checks.h"

namespace mm {

// Pieces that the JSON of several commands and of the workbench shares.

// For pictures: no more digits than can be seen.
constexpr double kPlaceStep = 1e-4;      // mm or deg
constexpr double kDeviationStep = 1e-3;  // um or arcsec
constexpr double kFigureStep = 1e-4;     // um or arcsec, of a figure that is printed
/// A number to a whole number of steps, or null where it is NaN or infinite.
nlohmann::ordered_json rounded(double value, double step);
/// Each of a range of numbers, as rounded().
template <typename Range>
nlohmann::ordered_json roundedList(const Range& values, double step) {
  nlohmann::ordered_json out = nlohmann::ordered_json::array();
  for (const double v : values) out.push_back(rounded(v, step));
  return out;
}

/// `{"type": …, keys…}`: numbers as numbers, true and false as such, lists as lists.
nlohmann::ordered_json effectJson(const EffectSpec& effect);
/// Sets `<name>_um`, and `<name>_arcsec` where there are angular figures. @param linear m. @param angular
/// rad.
void setRms(nlohmann::ordered_json& object, const std::string& name, double linear, double angular);
/// A figure that is in m, or in rad where the session is angular.
void setEither(nlohmann::ordered_json& object, const std::string& name, double value, bool angular);
/// `[before, after]` under the key of its unit.
void setPair(nlohmann::ordered_json& object, const std::string& name, double before, double after,
             bool angular);
void setFigures(nlohmann::ordered_json& object, const ResidualFigures& figures, bool heldOut);
nlohmann::ordered_json whereJson(const std::vector<WhereItFails>& where);
/// @param x values of the unknowns, SI.
nlohmann::ordered_json identifiabilityJson(const Problem& problem, const Identifiability& found,
                                           const Eigen::VectorXd& x);
nlohmann::ordered_json outliersJson(const CalibrationResult& result);
/// Adds `assumed`, `set_aside` and `questions`: what to know of a session before its figures.
void setSessionNotes(nlohmann::ordered_json& object, const Session& session,
                     const std::vector<Doubt>& questions);
/// Each effect of a calibration with its values, nominal and found, in the units of people.
nlohmann::ordered_json parametersJson(const Calibration& calibration);
nlohmann::ordered_json ledgerJson(const std::vector<LedgerEntry>& ledger, bool angular);
/// The object on several lines, without a line break at its end.
std::string dump(const nlohmann::ordered_json& object);

}  // namespace mm
