#pragma once
#include <string>
#include <utility>
#include <vector>

#include "base/format.h"
#include "calibration_file/calibration.h"
#include "diagnosis/diagnose.h"
#include "effects/effect_spec.h"
#include "estimation/calibrate.h"

namespace mm {

// Pieces that the texts and the JSON of several commands share.

/// "3.42 um", or "12.1 arcsec" where `angular`; "-" for what does not exist.
std::string length(double value, bool angular);
/// Value and expanded uncertainty (k = 2, twice `std`), this with two digits: "25.41 ± 0.11 um".
std::string withUncertainty(double value, double std, const std::string& unit);
/// Pads to a width counted in characters, not bytes.
std::string padded(const std::string& text, int width);
/// Lines of at most 100 characters: the first begins with `head`, the others are indented as far.
std::string wrapped(const std::string& head, const std::string& text);
/// An error that no effect of the catalogue explains: its curve, drawn with its band.
std::string profileText(const Diagnosis& diagnosis, const ProfileResult& profile);
std::string whereText(const std::vector<WhereItFails>& where);
/// A probability of chance for people: "0.003", or "< 1e-6" where its digits say nothing more.
std::string probabilityText(double p);
/// Joints that the measurements never moved; whether an effect is one of them or along them.
std::vector<std::string> idleJoints(const Domain& domain);
bool isOf(const EffectSpec& effect, const std::vector<std::string>& joints);
/// "  y, z never moved: 46 effects of them or along them (--json lists them)".
std::string idleText(const std::vector<std::string>& idle, std::size_t effects);
/// The `mm add` line to type next: what is missing first, then what no effect explains; empty when there is
/// nothing to add.
std::string addCommand(const Diagnosis& diagnosis, const std::string& session,
                       const std::string& calibration);
/// The line that asks what a calibration lacks.
std::string diagnoseCommand(const std::string& session, const std::string& calibration);
/// The line that writes the proposed moves as a plan.
std::string movesCommand(const std::string& session, const std::string& calibration);
/// RMS of what a model leaves over the repeatability, where that was declared or found by repeats; else 0.
double timesRepeatability(const std::string& repeatabilityFrom, double chi2PerDof);
inline constexpr double kLeavesMore = 1.5;  // times: the model does not describe everything
/// A number for people: at most six digits, no trailing zeros.
std::string sixDigits(double value);

/// How large the residuals are, outliers set aside.
struct SizeOfResiduals {
  int count = 0;
  double max = kNotMeasured;                      // m or rad
  std::vector<std::pair<int, double>> quantiles;  // percent, of the absolute value (m or rad): 50, 90, 95, 99
};
/// @param angular the residuals in rad instead of those in m.
SizeOfResiduals sizeOfResiduals(const CalibrationResult& result, bool angular);
/// Whether a joint turns; a direction of the workpiece does not.
bool isRotary(const Domain& domain, const std::string& joint);
bool angularOnly(const CalibrationResult& result);
bool angularOnly(const Calibration& calibration);

}  // namespace mm
