#include "export/to_reprapfirmware.h"

#include "base/units.h"
#include "export/fitted_tables.h"

namespace mm {
namespace {

constexpr double kLength = 100.0;  // mm, S of M556

double tangent(const NeededCorrection& needed, const StraightPart& part, const char* output,
               const char* input) {
  const ExportAxis *o = needed.findAxis(output), *i = needed.findAxis(input);
  return o == nullptr || i == nullptr ? 0.0 : part.square(o->joint, i->joint);
}

}  // namespace

Exported toReprapfirmware(const NeededCorrection& needed, const ExportOptions&) {
  Exported out;
  const StraightPart part = straightPart(needed);
  // RepRapFirmware adds: x + tanXY y + tanXZ z, y + tanYZ z; letters X: XY, Y: YZ, Z: XZ.
  std::string text = "G21\nM556 S" + fixed(kLength, 0) + " X" +
                     fixed(tangent(needed, part, "x", "y") * kLength, 7) + " Y" +
                     fixed(tangent(needed, part, "y", "z") * kLength, 7) + " Z" +
                     fixed(tangent(needed, part, "x", "z") * kLength, 7) + "\nM425";
  std::string negative;
  for (const char* letter : {"x", "y", "z"}) {
    const ExportAxis* axis = needed.findAxis(letter);
    if (axis == nullptr || axis->kind != JointKind::kLinear) continue;
    const double gap = 2.0 * part.byTravel(axis->joint, axis->joint);
    if (gap < -1e-8) negative += " " + capital(letter);
    text += " " + capital(letter) + fixed((gap > 0.0 ? gap : 0.0) / kMillimetre, 6);
  }
  text += "\n";
  out.files.push_back(
      {"config.g", "lines for config.g: angles between the axes (M556), backlash in mm (M425)", text});
  out.holds = "one reversal an axis; the angles between the axes";
  out.load = {"Append the lines to /sys/config.g, behind M584 and M92.",
              "M425 needs RepRapFirmware 3.5 or newer.", "Start the board anew and home."};
  out.reference = "Angles count from machine position 0 of X, Y and Z.";
  out.unverified = {
      "The distance over which a reversal is spread (S of M425, ten times the backlash by default) is "
      "not in the figure: positions are those after it was run in.",
      "The dictionary calls an obtuse angle positive; the sign here is that of the sources "
      "(Move::AxisTransform adds the tangent times the other coordinate)."};
  if (!negative.empty())
    out.notes.push_back("The reversal of" + negative +
                        " is negative (the slide leads its drive), which "
                        "RepRapFirmware cannot hold; it is left out.");
  out.notes.push_back(
      "Squareness is an angle: it is corrected by moving the first axis of each pair. What that turns "
      "the workpiece's frame is taken up when the workpiece is aligned.");
  return out;
}

}  // namespace mm
