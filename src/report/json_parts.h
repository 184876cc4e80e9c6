#pragma once
#include <string>
#include <vector>

#include "base/json_text.h"
#include "calibration_file/calibration.h"
#include "calibration_file/calibration_store.h"
#include "design/point_set.h"
#include "diagnosis/diagnose.h"
#include "effects/effect_spec.h"
#include "effects/iso230_symbol.h"
#include "estimation/calibrate.h"
#include "session/sense_checks.h"
#include "uncertainty/standard_tests.h"

namespace mm {

// Pieces that the JSON of several commands and of the workbench shares.

// For pictures: no more digits than can be seen.
constexpr double kPlaceStep = 1e-4;      // mm or deg
constexpr double kDeviationStep = 1e-3;  // um or arcsec
constexpr double kFigureStep = 1e-4;     // um or arcsec, of a figure that is printed
/// A number to a whole number of steps, or null where it is NaN or infinite.
Json rounded(double value, double step);
/// A number of each of a range, as rounded(). @param number of one: a function, or a member.
template <class Range, class Number>
Json roundedList(const Range& range, double step, const Number& number) {
  return jsonList(range, [&](const auto& one) { return rounded(std::invoke(number, one), step); });
}
/// Each of a range of numbers.
template <class Range>
Json roundedList(const Range& values, double step) {
  return jsonList(values, [step](double value) { return rounded(value, step); });
}

/// `{"type": …, keys…}`: numbers as numbers, true and false as such, lists as lists.
Json effectJson(const EffectSpec& effect);
/// Entry `iso230`, its symbol; nothing where it has none.
Json symbolJson(const EffectSpec& effect, const ErrorSymbols& symbols);
/// Entries `effect`, `in_words` and `iso230`.
Json effectInWords(const EffectSpec& effect, const ErrorSymbols& symbols);
/// Entries `odds` and `odds_in_words`.
Json oddsJson(double probability);
/// Entries `name`, `value`, `std` and `unit`.
Json parameterJson(const std::string& name, double value, double std, const std::string& unit);

/// Entries `name`, `unit`, `lower` and `upper`.
Json rangeJson(const std::string& name, const std::string& unit, const Json& lower, const Json& upper);
/// Entries `name`, `centre_mm` and `radius_mm`. @param centre, radius mm.
Json ballJson(const std::string& name, const Eigen::Vector3d& centre, double radius);

// Entries that are named by the unit of their figure: `<name>_um`, `<name>_arcsec`.

/// In um, and in arcsec where there are angular figures. @param linear m. @param angular rad.
Json figureJson(const std::string& name, double linear, double angular);
/// A figure that is in m, or in rad where the session is angular; then the one in um is null.
Json figureOf(bool angular, const std::string& name, double value);
/// What is in um, or in arcsec where it is angular; then the one in um is null.
Json underUnit(bool angular, const std::string& name, const Json& value);
/// The same of `[before, after]`, m (rad).
Json beforeAndAfter(bool angular, const std::string& name, double before, double after);
/// RMS of the residuals. @param heldOut with that of the blocks that a fit did not see.
Json figuresJson(const ResidualFigures& figures, bool heldOut);

Json whereJson(const std::vector<WhereItFails>& where);  ///< each variable with its shares
/// @param x values of the unknowns, SI.
Json identifiabilityJson(const Problem& problem, const Identifiability& found, const Eigen::VectorXd& x);
/// Unknowns by name, each with its part in a direction.
Json directionJson(const Problem& problem, const std::vector<std::pair<int, double>>& direction);
Json outliersJson(const CalibrationResult& result);
/// Entries `assumed`, `set_aside` and `questions`: what to know of a session before its figures.
Json sessionNotes(const Session& session, const std::vector<Doubt>& questions);
/// Each effect of a calibration with its values, nominal and found, in the units of people.
Json parametersJson(const Calibration& calibration);
/// One calibration of a store, as `mm history --json` lists it.
Json storedJson(const CalibrationStore::Entry& entry);
/// What `mm diagnose --json` prints, as an object.
Json diagnosisJson(const Diagnosis& diagnosis);
/// What `mm check --json` prints, as an object.
Json pointSetObject(const PointSet& set);
/// What `mm check --json` and `mm diagnose --json` say of the tests that a session is.
Json testsJson(const std::vector<StandardTest>& tests);
Json ledgerJson(const std::vector<LedgerEntry>& ledger, bool angular, const ErrorSymbols& symbols);

}  // namespace mm
