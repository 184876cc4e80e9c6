#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "base/error.h"
#include "base/format.h"
#include "base/grid_values.h"
#include "base/nearest_name.h"
#include "base/text.h"
#include "base/units.h"
#include "export/fitted_tables.h"
#include "export/targets.h"

namespace mm {
namespace {

constexpr int kIsgMostPoints = 241;        // of a table over one axis
constexpr std::size_t kIsgGridSteps = 15;  // at least, along an axis; each is one of its table, or 2, 4, 8 …
constexpr int kIsgOthers = 4;              // states of everything else, over which the grid is the mean
constexpr unsigned kIsgSeed = 91;
constexpr double kIsgLeast = 1e-8;  // m: a column whose values are all less is left out

using XyzJoints = std::array<int, 3>;

/// @throw InputError: the control compensates no machine with these axes.
XyzJoints xyzJoints(const NeededCorrection& needed) {
  std::vector<std::string> letters;
  for (const int joint : needed.linear()) letters.push_back(capital(needed.axis(joint).letter));
  XyzJoints joints{};
  for (std::size_t a = 0; a < joints.size(); ++a) {
    const ExportAxis* axis = needed.findAxis(std::string(1, "xyz"[a]));
    if (letters.size() != joints.size() || axis == nullptr || axis->kind != JointKind::kLinear)
      throw InputError("--to isg: the linear axes are " + listOf(letters) +
                       ", and volumetric compensation needs exactly three, X, Y and Z; name them with --axis "
                       "JOINT=LETTER, or export --to beckhoff");
    joints[a] = axis->joint;
  }
  return joints;
}

/// The corrections of X, Y and Z by the position of one of them.
struct IsgTable {
  std::size_t axis = 0;  // 0 to 2: X, Y, Z
  LineTable line;
  std::vector<std::size_t> gridPoints;  // of the points of the line, those at which the grid has its own
};

std::vector<IsgTable> isgTables(const NeededCorrection& needed, const XyzJoints& joints) {
  std::vector<IsgTable> tables;
  for (std::size_t a = 0; a < joints.size(); ++a) {
    if (!needed.moved(joints[a]) && needed.activePoints(joints[a]).empty()) continue;
    IsgTable table{a, lineTable(needed, joints[a], kIsgMostPoints), {}};
    const std::size_t last = table.line.at.size() - 1;
    std::size_t stride = 1;  // a power of two, by which the steps of a table are coarser or finer, too
    while (last / (2 * stride) >= kIsgGridSteps) stride *= 2;
    for (std::size_t i = 0; i < last; i += stride) table.gridPoints.push_back(i);
    table.gridPoints.push_back(last);
    tables.push_back(std::move(table));
  }
  return tables;
}

bool isMoreThanNothing(const std::vector<double>& values) {
  return std::any_of(values.begin(), values.end(), [](double v) { return std::abs(v) > kIsgLeast; });
}

/// What several positions do together: the correction less what each of them does alone.
struct IsgGrid {
  std::vector<std::vector<double>> at;       // a table: m
  std::array<std::vector<double>, 3> value;  // of X, Y, Z: m, one a grid point, the last table's axis fastest
  std::array<bool, 3> matters{};             // of X, Y, Z: it is not nothing

  /// Which of its positions a table has at a grid point.
  std::size_t place(std::size_t point, std::size_t table) const {
    for (std::size_t t = at.size() - 1; t > table; --t) point /= at[t].size();
    return point % at[table].size();
  }
};

IsgGrid isgGrid(const NeededCorrection& needed, const XyzJoints& joints,
                const std::vector<IsgTable>& tables) {
  IsgGrid grid;
  std::size_t count = 1;
  std::vector<double> reference;
  std::vector<std::vector<Eigen::VectorXd>> alone;  // a table, one of its positions
  for (const IsgTable& table : tables) {
    grid.at.emplace_back();
    alone.emplace_back();
    for (const std::size_t i : table.gridPoints) {
      grid.at.back().push_back(table.line.at[i]);
      alone.back().push_back(meanCorrection(needed, table.line.input, table.line.at[i]));
    }
    reference.push_back(needed.reference(table.line.input));
    count *= grid.at.back().size();
  }
  if (tables.size() < 2) return grid;
  std::vector<State> others = needed.states(kIsgOthers, kIsgSeed);
  for (std::size_t point = 0; point < count; ++point) {
    Eigen::VectorXd value = meanOver(needed, &NeededCorrection::at, others, [&](State& state) {
      for (std::size_t t = 0; t < tables.size(); ++t)
        state.position[tables[t].line.input] = grid.at[t][grid.place(point, t)];
    });
    for (std::size_t t = 0; t < tables.size(); ++t) value -= alone[t][grid.place(point, t)];
    for (std::size_t d = 0; d < joints.size(); ++d) grid.value[d].push_back(value[joints[d]]);
  }
  for (std::size_t d = 0; d < joints.size(); ++d) {
    const double zero = gridValue(gridCorners(grid.at, reference), grid.value[d]);
    for (double& value : grid.value[d]) value -= zero;
    grid.matters[d] = isMoreThanNothing(grid.value[d]);
  }
  return grid;
}

/// The table of which the grid has the errors along X, Y or Z, too: of the two that are not its own the one
/// with fewer points. Null: there is none.
const IsgTable* inIsgGrid(const std::vector<IsgTable>& tables, std::size_t along) {
  const IsgTable* best = nullptr;
  for (const IsgTable& table : tables)
    if (table.axis != along && (best == nullptr || table.line.at.size() < best->line.at.size()))
      best = &table;
  return best;
}

/// EXY: the error along X of the carriage Y.
std::string isgError(std::size_t along, std::size_t of) { return {'E', "XYZ"[along], "XYZ"[of]}; }

/// The text of an error table: blocks of a line with names and lines with numbers.
struct IsgText {
  std::string text =
      "// EXY: error along X of carriage Y, actual minus commanded, mm; the control takes it off.\n"
      "// X, Y, Z: positions of the axes, mm. Errors along one direction add up.\n";
  std::vector<std::string> blocks;  // their names
  std::size_t records = 0;

  /// @param positions, corrections m, a column each; the control is told the errors.
  void add(const std::vector<std::string>& names, const std::vector<std::vector<double>>& positions,
           const std::vector<std::vector<double>>& corrections) {
    text += (blocks.empty() ? "" : "#\n") + joined(names, " ") + "\n";
    blocks.push_back(joined(names, " "));
    for (std::size_t i = 0; i < positions[0].size(); ++i, ++records) {
      std::vector<std::string> cells;
      for (const auto& column : positions) cells.push_back(fixed(column[i] / kMillimetre, 4));
      for (const auto& column : corrections) cells.push_back(fixed(-column[i] / kMillimetre, 7));
      text += joined(cells, " ") + "\n";
    }
  }
};

/// All blocks. @param all also columns of zeros. @return the outputs that have a column.
std::set<std::size_t> writeIsgErrors(const NeededCorrection& needed, const XyzJoints& joints,
                                     const std::vector<IsgTable>& tables, bool all, IsgText& file) {
  IsgGrid grid = isgGrid(needed, joints, tables);
  std::vector<std::string> arguments, gridErrors;
  std::vector<std::vector<double>> places, gridded;
  std::set<std::size_t> written;
  for (std::size_t t = 0; t < tables.size(); ++t) {
    const IsgTable& table = tables[t];
    arguments.emplace_back(1, "XYZ"[table.axis]);
    places.emplace_back();
    for (std::size_t point = 0; point < grid.value[0].size(); ++point)
      places.back().push_back(grid.at[t][grid.place(point, t)]);
    std::vector<std::string> names = {arguments.back()};
    std::vector<std::vector<double>> columns;
    for (std::size_t d = 0; d < joints.size(); ++d) {
      std::vector<double> mean;
      for (std::size_t i = 0; i < table.line.at.size(); ++i) mean.push_back(table.line.mean(joints[d], i));
      const bool inGrid = grid.matters[d] && inIsgGrid(tables, d) == &table;
      if (!inGrid && !all && !isMoreThanNothing(mean)) continue;
      for (std::size_t point = 0; inGrid && point < grid.value[d].size(); ++point)
        grid.value[d][point] += mean[table.gridPoints[grid.place(point, t)]];
      (inGrid ? gridErrors : names).push_back(isgError(d, table.axis));
      (inGrid ? gridded : columns).push_back(inGrid ? grid.value[d] : mean);
      written.insert(d);
    }
    if (!columns.empty()) file.add(names, {table.line.at}, columns);
  }
  arguments.insert(arguments.end(), gridErrors.begin(), gridErrors.end());
  if (!gridded.empty()) file.add(arguments, places, gridded);
  return written;
}

void describeIsg(Exported& out) {
  out.holds =
      "each axis by the position of each axis and by all three together, both directions of travel alike";
  out.load = {
      "Volumetric compensation is an option of the control with a licence of its own (TF5280).",
      "Compare the logical axis numbers in volcomp.lis with the control's, copy volcomp.lis and volcomp.csv "
      "to the control, and write the whole path of volcomp.csv behind file[0].",
      "Take the lines of startup.lis over into the start-up list, with the whole path of volcomp.lis. Where "
      "vol_comp[0] is in use, take another index up to 4.",
      "Set lr_param.vol_comp.v_limit (P-AXIS-00526) of X, Y and Z: the velocity at which compensation runs "
      "out.",
      "Start the control anew, home, and switch on: #VOLCOMP ON [ID0]. To load other tables: #VOLCOMP OFF "
      "[ID0], #VOLCOMP [ID0 UPDATE], #VOLCOMP ON [ID0]."};
  out.reference =
      "Positions are those of the referenced axes, in mm. Each table is zero at position 0, or at the end "
      "of the calibrated range that is nearest to it.";
  out.unverified = {
      "The sign: the documents say that the control inverts a model of the machine with these errors, and "
      "leave the sign of an error to ISO 230-1 (actual minus commanded). Check with one move; 'negate' in "
      "volcomp.lis turns the compensation of an axis round.",
      "The documents do not say what holds beyond the ends of a table (here: the last value), and whether "
      "errors are looked up at the commanded or at the corrected position (here: the commanded one).",
      "That a component error may depend on three positions is documented, and so is one example; that "
      "EXX, EXY and EXZ add up follows from the model that they describe."};
  out.notes = {
      "Angular errors (EAX and so on) are not written: the documents do not say about which point they turn "
      "a carriage. What angles do at the tip is in the grid, for the probe that was measured with: leave "
      "N0X, N0Y and N0Z out, or the control adds the length of the tool.",
      "Where positions act together along a direction, one of its tables stands in the grid, and has the "
      "grid's points only: 16 to 31 an axis.",
      "No column tells the direction of travel or a temperature: reversals and thermal growth are left."};
}

}  // namespace

Exported toIsg(const NeededCorrection& needed, const ExportOptions&) {
  Exported out;
  describeIsg(out);
  const XyzJoints joints = xyzJoints(needed);
  if (std::none_of(joints.begin(), joints.end(), [&](int joint) { return needed.changes(joint); }))
    return out;
  const std::vector<IsgTable> tables = isgTables(needed, joints);
  for (const IsgTable& table : tables) addNotFollowed(needed, table.line, needed.linear(), out);
  IsgText file;
  const bool all = needed.active() != nullptr;  // whose file this one replaces, for all axes
  for (const std::size_t d : writeIsgErrors(needed, joints, tables, all, file))
    out.axes.insert(needed.axis(joints[d]).letter);
  if (out.axes.empty()) return out;
  out.files = {{"volcomp.csv", "the error table (ISG_CSV): mm", file.text},
               {"volcomp.lis", "the configuration of the volumetric compensation",
                "# Logical axis numbers: change them where the control's differ.\nx 1\ny 2\nz 3\nchain XYZ\n"
                "workpiece_axes 0\nmanual_activation 1\ninterpolation GRID\n# The whole path on the "
                "control:\nfile[0] volcomp.csv\n"
                "file_format[0] ISG_CSV\n"},
               {"startup.lis", "lines for the start-up list",
                format("vol_comp[0].max_records %zu\nvol_comp[0].file_name volcomp.lis\n", file.records)}};
  out.notes.push_back(format("%zu records: ", file.records) + joined(file.blocks, "; ") + ".");
  return out;
}

}  // namespace mm
