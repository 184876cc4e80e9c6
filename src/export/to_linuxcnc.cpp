#include "base/format.h"
#include "base/units.h"
#include "export/fitted_tables.h"
#include "export/offset_grid.h"
#include "export/targets.h"

namespace mm {
namespace {

constexpr int kLinuxcncMostPoints = 256;  // of a COMP_FILE

/// Axes in the order in which LinuxCNC numbers its joints with trivial kinematics.
std::vector<const ExportAxis*> inOrder(const NeededCorrection& needed) {
  std::vector<const ExportAxis*> ordered;
  for (const char letter : std::string("xyzabcuvw"))
    if (const ExportAxis* axis = needed.findAxis(std::string(1, letter))) ordered.push_back(axis);
  return ordered;
}

std::string triplets(const LineTable& table, int joint) {
  std::string text;
  for (std::size_t i = 0; i < table.at.size(); ++i)
    text += fixed(table.at[i] / kMillimetre, 4) + " " + fixed(table.positive[joint][i] / kMillimetre, 7) +
            " " + fixed(table.negative[joint][i] / kMillimetre, 7) + "\n";
  return text;
}

/// HAL lines that start the component and wire it. The axes' positions are those without offsets, so that an
/// offset does not ask for another one.
std::string offsetsHal(const OffsetGrid& grid) {
  std::string text =
      "# What joint tables cannot hold. The temperatures must be wired to signals of yours: mm-<sensor>.\n"
      "# A pin of LinuxCNC can have one signal: where yours has one already, name it here instead.\n"
      "loadusr -Wn mm-offsets linuxcnc_offsets external_offsets.json\n"
      "net mm-motion-enabled motion.motion-enabled => mm-offsets.motion-enabled\n"
      "net mm-all-homed motion.is-all-homed => mm-offsets.all-homed\n";
  for (const std::string& letter : grid.letters) {
    const char* l = letter.c_str();
    text += format("net mm-%s-position axis.%s.pos-cmd => mm-offsets.%s-position\n", l, l, l);
    text += format("net mm-%s-request axis.%s.eoffset-request => mm-offsets.%s-request\n", l, l, l);
    text += format("net mm-%s-offset axis.%s.eoffset => mm-offsets.%s-offset\n", l, l, l);
    for (const char* pin : {"counts", "scale", "enable", "clear"})
      text += format("net mm-%s-%s mm-offsets.%s-%s => axis.%s.eoffset-%s\n", l, pin, l, pin, l, pin);
  }
  for (const std::string& sensor : grid.sensors)
    text += "net mm-" + sensor + " mm-offsets." + sensor + "-degC\n";
  return text;
}

constexpr double kLeastOffset = 2e-8;  // m: less is not worth a program

void addOffsets(const NeededCorrection& needed, Exported& out) {
  OffsetGrid grid = offsetGrid(needed, &NeededCorrection::adds);
  if (grid.largest < kLeastOffset) {
    out.notes.push_back("Nothing is left for external offsets.");
    return;
  }
  if (needed.active() != nullptr) grid = offsetGrid(needed);
  out.files.push_back({"external_offsets.json",
                       "what joint tables cannot hold, for the HAL component linuxcnc_offsets", grid.json});
  out.files.push_back({"external_offsets.hal", "starts the component and wires it", offsetsHal(grid)});
  out.offsets = true;
  out.load.insert(
      out.load.end() - 1,  // LinuxCNC starts anew after it
      "For the cross-axis and thermal parts, too: copy external_offsets.json and external_offsets.hal beside "
      "the INI file, add HALFILE = external_offsets.hal, and OFFSET_AV_RATIO = 0.1 to each linear [AXIS_l] "
      "(a tenth of its velocity and acceleration is then kept for offsets); put the folder of "
      "linuxcnc_offsets (lib/measuring_machine) on PATH, and wire the temperatures. Where the machine's HAL "
      "has motion.is-all-homed, or another pin that is read here, on a signal of its own already, that line "
      "net fails: take that signal's name instead of mm-all-homed, and leave the pin of LinuxCNC out. "
      "Offsets are given while the machine is on and all joints are homed; pin mm-offsets.arrived tells that "
      "all are there.");
  out.notes.push_back(
      "External offsets follow the commanded position about fifty times a second; at rest they stand within "
      "0.03 um of what external_offsets.json says. LinuxCNC holds position and offset together within the "
      "soft limits of [AXIS_l]: the last of the way there, by as much as the offset, is not corrected. A "
      "joint that an offset moves last, moves like any other: its direction is the one that counts for the "
      "table and the backlash.");
}

}  // namespace

Exported toLinuxcnc(const NeededCorrection& needed, const ExportOptions& options) {
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
    const LineTable table = lineTable(needed, axis.joint, kLinuxcncMostPoints);
    if (!table.changes(axis.joint)) continue;
    out.axes.insert(axis.letter);
    addNotFollowed(needed, table, {axis.joint}, out);
    joints += "COMP_FILE = " + file + "\nCOMP_FILE_TYPE = 1\n";
    out.files.push_back({file,
                         format("joint %zu (%s): position in mm, what is added to the motor upwards and "
                                "downwards in mm; %zu points",
                                n, capital(axis.letter).c_str(), table.at.size()),
                         triplets(table, axis.joint)});
  }
  out.files.insert(out.files.begin(), {"machine.ini", "the lines for the INI file; not a whole one",
                                       "[TRAJ]\nCOORDINATES = " + coordinates +
                                           "\nLINEAR_UNITS = mm\nANGULAR_UNITS = degree\n" + joints});
  out.holds = "each joint by its own position, upwards and downwards apart";
  out.load = {
      "Copy the files joint*.comp beside the machine's INI file.",
      "Take COMP_FILE and COMP_FILE_TYPE of each [JOINT_n] over from machine.ini into the machine's own. "
      "Where the machine numbers its joints otherwise, go by the letters.",
      "With a COMP_FILE the BACKLASH of a joint is not used: what is left of its reversal, or all of it, is "
      "in the table. Joints without a COMP_FILE here keep theirs.",
      "Give the drives room: at a reversal the correction is run in with up to half the joint's velocity "
      "and acceleration on top of the move (STEPGEN_MAXACCEL, STEPGEN_MAXVEL).",
      "Start LinuxCNC anew, which loads the tables, and home: they count from the homed zero of each joint."};
  out.reference =
      "Positions are those of the homed joint, in mm. Every table is zero at joint position 0 (mean of both "
      "directions), or at the end of the calibrated range that is nearest to it.";
  out.notes.push_back(
      "LinuxCNC allows 256 points a joint: here are as few as follow its curve within 0.02 um, at most 241.");
  if (options.tablesAlone)
    out.notes.push_back("Without external offsets, as asked for: tables alone.");
  else
    addOffsets(needed, out);
  return out;
}

}  // namespace mm
