#include "base/units.h"
#include "export/printer_terms.h"
#include "export/targets.h"

namespace mm {
namespace {

constexpr double kLength = 100.0;      // mm, S of M556
constexpr double kRepRapLeast = 1e-9;  // m: the last digit of M425

}  // namespace

Exported toReprapfirmware(const NeededCorrection& needed, const ExportOptions&) {
  Exported out;
  const PrinterTerms terms = printerTerms(needed, {"RepRapFirmware", "xyz", kRepRapLeast}, out);
  // RepRapFirmware adds: x + tanXY y + tanXZ z, y + tanYZ z; letters X: XY, Y: YZ, Z: XZ.
  std::string text = "G21\n", angles, reversals;
  const auto angle = [&](const char* letter, const std::optional<double>& tangent) {
    if (tangent) angles += std::string(" ") + letter + fixed(*tangent * kLength, 7);
  };
  angle("X", terms.xy);
  angle("Y", terms.yz);
  angle("Z", terms.xz);
  for (const auto& [axis, gap] : terms.reversals)
    reversals += " " + capital(axis->letter) + fixed(gap / kMillimetre, 6);
  if (!angles.empty()) text += "M556 S" + fixed(kLength, 0) + angles + "\n";
  if (!reversals.empty()) text += "M425" + reversals + "\n";
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
  out.notes.push_back(kSquarenessNote);
  return out;
}

}  // namespace mm
