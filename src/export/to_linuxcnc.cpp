#include "export/to_linuxcnc.h"

#include <algorithm>

#include "base/format.h"
#include "base/units.h"
#include "export/fitted_tables.h"

namespace mm {
namespace {

constexpr int kMostPoints = 256;  // of a COMP_FILE

/// Axes in the order in which LinuxCNC numbers its joints with trivial kinematics.
std::vector<const ExportAxis*> inOrder(const NeededCorrection& needed) {
  std::vector<const ExportAxis*> ordered;
  for (const char letter : std::string("xyzabcuvw"))
    if (const ExportAxis* axis = needed.findAxis(std::string(1, letter))) ordered.push_back(axis);
  return ordered;
}

std::string triplets(const LineTable& table, int joint) {
  std::string text;
  const auto j = static_cast<std::size_t>(joint);
  for (std::size_t i = 0; i < table.at.size(); ++i)
    text += fixed(table.at[i] / kMillimetre, 4) + " " + fixed(table.positive[j][i] / kMillimetre, 7) + " " +
            fixed(table.negative[j][i] / kMillimetre, 7) + "\n";
  return text;
}

}  // namespace

Exported toLinuxcnc(const NeededCorrection& needed, const ExportOptions&) {
  Exported out;
  const std::vector<const ExportAxis*> axes = inOrder(needed);
  std::string coordinates, joints;
  for (const ExportAxis* axis : axes) coordinates += (coordinates.empty() ? "" : " ") + capital(axis->letter);
  for (std::size_t n = 0; n < axes.size(); ++n) {
    const ExportAxis& axis = *axes[n];
    const bool linear = axis.kind == JointKind::kLinear;
    joints += format("\n[JOINT_%zu]\nTYPE = %s\n", n, linear ? "LINEAR" : "ANGULAR");
    if (!linear || !needed.moved(axis.joint)) continue;
    const std::string file = format("joint%zu.comp", n);
    const LineTable table = lineTable(needed, axis.joint, kMostPoints);
    joints += "COMP_FILE = " + file + "\nCOMP_FILE_TYPE = 1\n";
    out.files.push_back({file,
                         format("joint %zu (%s): position in mm, what is added to the motor upwards and "
                                "downwards in mm; %zu points",
                                n, capital(axis.letter).c_str(), table.at.size()),
                         triplets(table, axis.joint)});
  }
  out.files.push_back(
      {"machine.ini", "the lines for the INI file; not a whole one",
       "[TRAJ]\nCOORDINATES = " + coordinates + "\nLINEAR_UNITS = mm\nANGULAR_UNITS = degree\n" + joints});
  out.holds = "each joint by its own position, upwards and downwards apart";
  out.load = {
      "Copy the files joint*.comp beside the machine's INI file.",
      "Take COMP_FILE and COMP_FILE_TYPE of each [JOINT_n] over from machine.ini into the machine's own. "
      "Where the machine numbers its joints otherwise, go by the letters.",
      "Delete BACKLASH of these joints: with a COMP_FILE it is not used, and the reversal is in the table.",
      "Give the drives room: at a reversal the correction is run in with up to half the joint's velocity "
      "and acceleration on top of the move (STEPGEN_MAXACCEL, STEPGEN_MAXVEL).",
      "Start LinuxCNC anew and home: the tables act on homed joints."};
  out.reference =
      "Positions are those of the homed joint, in mm. Every table is zero at joint position 0 (mean of both "
      "directions), or at the end of the calibrated range that is nearest to it.";
  out.notes = {"LinuxCNC allows 256 points a joint; those here follow the curve within 0.02 um or are 241."};
  return out;
}

}  // namespace mm
