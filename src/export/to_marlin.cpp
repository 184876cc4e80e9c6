#include "export/to_marlin.h"

#include <cmath>

#include "base/units.h"
#include "export/fitted_tables.h"

namespace mm {
namespace {

constexpr double kMostSkew = 1.0;  // SKEW_FACTOR_MIN, SKEW_FACTOR_MAX

double squareOf(const NeededCorrection& needed, const StraightPart& part, const char* output,
                const char* input) {
  const ExportAxis *o = needed.findAxis(output), *i = needed.findAxis(input);
  return o == nullptr || i == nullptr ? 0.0 : part.square(o->joint, i->joint);
}

}  // namespace

Exported toMarlin(const NeededCorrection& needed, const ExportOptions&) {
  Exported out;
  const StraightPart part = straightPart(needed);
  // Marlin subtracts: x - I y - (J - I K) z, y - K z.
  const double i = -squareOf(needed, part, "x", "y"), k = -squareOf(needed, part, "y", "z");
  const double j = -squareOf(needed, part, "x", "z") + i * k;
  std::string text = "G21\n", backlash;
  std::string negative;
  for (const char* letter : {"x", "y", "z"}) {
    const ExportAxis* axis = needed.findAxis(letter);
    if (axis == nullptr || axis->kind != JointKind::kLinear) continue;
    const double gap = 2.0 * part.byTravel(axis->joint, axis->joint);
    if (gap < -1e-8) negative += " " + capital(letter);
    backlash += " " + capital(letter) + fixed((gap > 0.0 ? gap : 0.0) / kMillimetre, 6);
  }
  text += "M425 F1" + backlash + "\n";
  text += "M852 I" + fixed(i, 9) + " J" + fixed(j, 9) + " K" + fixed(k, 9) + "\nM500\n";
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
  if (std::abs(i) > kMostSkew || std::abs(j) > kMostSkew || std::abs(k) > kMostSkew)
    out.notes.push_back("A factor is beyond -1 to 1, which Marlin refuses: square the machine first.");
  if (!negative.empty())
    out.notes.push_back(
        "The reversal of" + negative +
        " is negative (the slide leads its drive), which Marlin cannot hold; it is left out.");
  out.notes.push_back(
      "Squareness is an angle: it is corrected by moving the first axis of each pair. What that turns "
      "the workpiece's frame is taken up when the workpiece is aligned.");
  return out;
}

}  // namespace mm
