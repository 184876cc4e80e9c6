#include <algorithm>

#include "base/format.h"
#include "base/units.h"
#include "export/fitted_tables.h"
#include "export/targets.h"

namespace mm {
namespace {

constexpr int kHeidenhainMostPoints = 256;

/// A row a point: where, what was measured downwards, and the error of each axis, in mm.
std::string comTable(const LineTable& table, const std::string& name,
                     const std::vector<const ExportAxis*>& axes) {
  std::string text = "BEGIN " + name + " MM\nNR AXISPOS BACKLASH";
  for (const ExportAxis* axis : axes) text += " " + capital(axis->letter);
  text += "\n";
  const int own = table.input;
  for (std::size_t i = 0; i < table.at.size(); ++i) {
    // The control is told the error, and takes it from the position.
    text += format("%zu %s %s", i, fixed(table.at[i] / kMillimetre, 4).c_str(),
                   fixed(-table.negative[own][i] / kMillimetre, 6).c_str());
    for (const ExportAxis* axis : axes)
      text +=
          " " + fixed(-(axis->joint == table.input ? table.positive[own][i] : table.mean(axis->joint, i)) /
                          kMillimetre,
                      6);
    text += "\n";
  }
  return text + "[END]\n";
}

}  // namespace

Exported toHeidenhain(const NeededCorrection& needed, const ExportOptions&) {
  Exported out;
  std::vector<const ExportAxis*> axes;
  for (const int joint : needed.linear()) axes.push_back(&needed.axis(joint));
  std::string columns = "NR ACTIVE", line = "0 *";
  bool changes = false;
  for (const ExportAxis* axis : axes) changes = changes || needed.changes(axis->joint);
  for (const ExportAxis* axis : axes) {
    const bool active = !needed.activePoints(axis->joint).empty();
    if (!changes || (!needed.moved(axis->joint) && !active)) continue;
    const std::string name = capital(axis->letter) + ".COM", file = axis->letter + ".com";
    const LineTable table = lineTable(needed, axis->joint, kHeidenhainMostPoints);
    const auto changed = [&](const ExportAxis* output) { return table.changes(output->joint); };
    if (!active && std::none_of(axes.begin(), axes.end(), changed)) continue;
    for (const ExportAxis* output : axes)
      if (changed(output) || table.largest(output->joint) > LineTable::kLeastOfATable)
        out.axes.insert(output->letter);
    addNotFollowed(needed, table, needed.linear(), out);
    out.files.push_back({file,
                         "errors of the axes by the position of " + capital(axis->letter) +
                             " in mm; BACKLASH: of " + capital(axis->letter) + " itself, downwards",
                         comTable(table, name, axes)});
    columns += " " + capital(axis->letter);
    line += " " + file;
  }
  out.files.push_back({"config.cma", "which table belongs to which axis",
                       "BEGIN CONFIG.CMA\n" + columns + "\n" + line + "\n[END]\n"});
  out.holds = "each axis by the position of each axis; its own upwards and downwards apart";
  out.load = {
      "Back up the tables that are in use.",
      "Copy the .com files and config.cma into the folder for compensation tables of the control "
      "(code number of the machine tool builder).",
      "Switch the nonlinear axis error compensation of the axes on (iTNC: MP730; TNC 620, 640: "
      "CfgAxisComp), and choose the line with * in config.cma.",
      "Where the backlash of these axes (MP710, backLash) was active while measuring, it is in the column "
      "BACKLASH of the tables: set it to 0.",
      "Home. Beyond the ends of a table the last value holds."};
  out.reference =
      "AXISPOS counts from the machine datum, in mm. Each table is zero at position 0, or at the end of "
      "the calibrated range that is nearest to it. Older controls (TNC 407) demand zero at the first point.";
  out.unverified = {
      "The sign: for the linear compensation (MP720) the manual says that the error is positive when the "
      "travel is too long; that the tables mean it likewise is taken over from there. Check with one move.",
      "That BACKLASH holds the whole error downwards, and not its difference to the one upwards, is how "
      "the manual reads (\"compensation values measured in the negative direction\").",
      "Column widths: the control's editor aligns columns; import the tables through it, or by TNCremo."};
  out.notes = {"At most 256 points a table."};
  return out;
}

}  // namespace mm
