#include <cmath>

#include "base/error.h"
#include "base/units.h"
#include "export/printer_terms.h"
#include "export/targets.h"

namespace mm {
namespace {

constexpr double kMostSkew = 1.0;      // SKEW_FACTOR_MIN, SKEW_FACTOR_MAX
constexpr double kMarlinLeast = 1e-9;  // m: the last digit of M425

/// @throw InputError where Marlin would refuse the factor.
std::string skewFactor(char letter, double factor, const char* axes) {
  if (!(std::abs(factor) <= kMostSkew))
    throw InputError("--to marlin: M852 " + std::string(1, letter) + ", the skew of " + axes + ", is " +
                     fixed(factor, 6) +
                     ", outside -1 to 1 (SKEW_FACTOR_MIN, SKEW_FACTOR_MAX): square these axes first, and "
                     "measure again");
  return " " + std::string(1, letter) + fixed(factor, 9);
}

}  // namespace

Exported toMarlin(const NeededCorrection& needed, const ExportOptions&) {
  Exported out;
  const PrinterTerms terms = printerTerms(needed, {"Marlin", "xyz", kMarlinLeast, true, true}, out);
  // Marlin subtracts: x - I y - (J - I K) z, y - K z.
  const double i = -terms.xy.value_or(0.0), k = -terms.yz.value_or(0.0);
  const double j = -terms.xz.value_or(0.0) + i * k;
  std::string text = "G21\n", reversals, skew;
  for (const auto& [axis, gap] : terms.reversals)
    reversals += " " + capital(axis->letter) + fixed(gap / kMillimetre, 6);
  if (terms.xy) skew += skewFactor('I', i, "x and y");
  if (terms.xz || i * k != 0.0) skew += skewFactor('J', j, "x and z");
  if (terms.yz) skew += skewFactor('K', k, "y and z");
  if (!reversals.empty()) text += "M425 F1" + reversals + "\n";
  if (!skew.empty()) text += "M852" + skew + "\n";
  text += "M500\n";
  out.files.push_back(
      {"compensation.gcode", "backlash in mm (M425), skew factors (M852), kept by M500", text});
  out.holds = "one reversal an axis; the angles between the axes";
  out.load = {
      "Use a build with BACKLASH_COMPENSATION, BACKLASH_GCODE, SKEW_CORRECTION, SKEW_CORRECTION_FOR_Z and "
      "SKEW_CORRECTION_GCODE in Configuration_adv.h and Configuration.h.",
      "Set BACKLASH_SMOOTHING_MM to 0 for measuring: otherwise the reversal is spread over a distance.",
      "Send compensation.gcode, then home (G28)."};
  out.reference =
      "Skew counts from machine position 0 of X, Y and Z; it ends outside X_MIN_POS to X_MAX_POS and "
      "Y_MIN_POS to Y_MAX_POS.";
  out.unverified = {
      "Marlin keeps the factors as 32 bit numbers and moves in whole steps; that is not in the figure."};
  out.notes.push_back(kSquarenessNote);
  return out;
}

}  // namespace mm
