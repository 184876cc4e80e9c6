#include <set>

#include "base/format.h"
#include "base/units.h"
#include "export/fitted_tables.h"
#include "export/targets.h"

namespace mm {
namespace {

constexpr int kSiemensMostPoints = 200;  // a table of the 828D
constexpr double kSiemensLeast = 1e-8;   // m: a table whose values are all less is left out

std::string machineAxis(const ExportAxis& axis) { return "(" + capital(axis.letter) + "1)"; }

/// "X by Y, upwards, 193 points".
std::string nameOf(const ExportAxis& in, const ExportAxis& out, int direction, std::size_t points) {
  return format("%s by %s%s, %zu points", capital(out.letter).c_str(), capital(in.letter).c_str(),
                direction > 0   ? ", upwards"
                : direction < 0 ? ", downwards"
                                : "",
                points);
}

/// One table $AN_CEC: values are errors, which the control takes off (a positive value moves the axis back).
/// @param direction of the input's travel for which it counts; 0: both.
std::string cecTable(int number, const ExportAxis& in, const ExportAxis& out, int direction,
                     const std::vector<double>& at, const std::vector<double>& values) {
  std::string text = format("\n; table %d: %s\n", number, nameOf(in, out, direction, values.size()).c_str());
  for (std::size_t i = 0; i < values.size(); ++i)
    text += format("$AN_CEC[%d,%zu]=", number, i) + fixed(-values[i] / kMillimetre, 6) + "\n";
  const double step = at[1] - at[0];
  text += format("$AN_CEC_INPUT_AXIS[%d]=%s\n$AN_CEC_OUTPUT_AXIS[%d]=%s\n", number, machineAxis(in).c_str(),
                 number, machineAxis(out).c_str());
  text += format("$AN_CEC_STEP[%d]=%.4f\n$AN_CEC_MIN[%d]=%.4f\n$AN_CEC_MAX[%d]=%.4f\n", number,
                 step / kMillimetre, number, at.front() / kMillimetre, number, at.back() / kMillimetre);
  return text + format("$AN_CEC_DIRECTION[%d]=%d\n$AN_CEC_IS_MODULO[%d]=0\n", number, direction, number);
}

/// What is collected while tables are numbered: never by the number of one that stays.
struct Tables {
  std::string cec, memory, enable, list;
  int count = 0, number = 0;
  std::set<int> stay, before;  // numbers of other axes' tables, and of those that are replaced

  int next() {
    while (stay.count(number) > 0) ++number;
    before.erase(number);
    return number++;
  }

  void add(const ExportAxis& in, const ExportAxis& out, int direction, const std::vector<double>& at,
           const std::vector<double>& values) {
    const int index = next();
    cec += cecTable(index, in, out, direction, at, values);
    memory += format("$MN_MM_CEC_MAX_POINTS[%d]=%zu\n", index, values.size());
    enable += format("$SN_CEC_TABLE_ENABLE[%d]=1\n", index);
    list +=
        format("%s%d: %s", count == 0 ? "" : "; ", index, nameOf(in, out, direction, values.size()).c_str());
    ++count;
  }
};

void addTables(const LineTable& table, const ExportAxis& in, const ExportAxis& out, Tables& tables) {
  const int j = out.joint;
  if (table.largest(out.joint) < kSiemensLeast) return;
  std::vector<double> mean;
  double apart = 0.0;
  for (std::size_t i = 0; i < table.at.size(); ++i) {
    mean.push_back(table.mean(out.joint, i));
    apart = std::max(apart, std::abs(table.positive[j][i] - table.negative[j][i]));
  }
  if (apart < kSiemensLeast) return tables.add(in, out, 0, table.at, mean);
  tables.add(in, out, 1, table.at, table.positive[j]);
  tables.add(in, out, -1, table.at, table.negative[j]);
}

}  // namespace

Exported toSiemens(const NeededCorrection& needed, const ExportOptions&) {
  Exported out;
  std::vector<LineTable> by;  // a joint that moved, or over which a table was active
  for (const int input : needed.linear()) {
    if (!needed.moved(input) && needed.activePoints(input).empty()) continue;
    by.push_back(lineTable(needed, input, kSiemensMostPoints));
    addNotFollowed(needed, by.back(), needed.linear(), out);
    for (const int output : needed.linear())
      if (by.back().changes(output)) out.axes.insert(needed.axis(output).letter);
  }
  Tables tables;
  if (needed.active() != nullptr)
    for (const auto& [letter, numbers] : needed.active()->numbers())
      (out.axes.count(letter) > 0 ? tables.before : tables.stay).insert(numbers.begin(), numbers.end());
  std::string enabled;
  for (const LineTable& table : by)
    for (const int output : needed.linear()) {
      const ExportAxis& axis = needed.axis(output);
      if (out.axes.count(axis.letter) > 0) addTables(table, needed.axis(table.input), axis, tables);
    }
  for (const int old : tables.before) tables.enable += format("$SN_CEC_TABLE_ENABLE[%d]=0\n", old);
  for (const std::string& letter : out.axes) enabled += "$MA_CEC_ENABLE[" + capital(letter) + "1]=1\n";
  out.files = {
      {"cec_1_memory.mpf", "machine data: points of each table (changes the memory: back up first)",
       tables.memory + "M17\n"},
      {"cec_2_tables.mpf", "the tables, mm", "%_N_NC_CEC_INI\nCHANDATA(1)\n" + tables.cec + "\nM17\n"},
      {"cec_3_enable.mpf", "enables the tables and the axes", tables.enable + enabled + "M17\n"}};
  out.holds = "each axis by the position of each axis, upwards and downwards apart";
  out.load = {
      "Back up: $MN_MM_CEC_MAX_POINTS rearranges the memory of the NCK and takes effect with power on.",
      "Set the points of cec_1_memory.mpf (MD18342), power on, load the backup where the control asks for "
      "it.",
      "With $MA_CEC_ENABLE of the axes at 0, run cec_2_tables.mpf as a program: a table that is in use is "
      "write protected.",
      "Run cec_3_enable.mpf (MD32710, SD41300), NCK reset, home: CEC acts on homed axes.",
      "Where $MA_BACKLASH or $AA_ENC_COMP of these axes was active while measuring, it is in the tables: set "
      "it to 0, disable it. Set MD32711 $MA_CEC_SCALING_SYSTEM_METRIC to 1: values are in mm."};
  out.reference =
      "Positions are those of the machine axes, in mm. Each table is zero at position 0, or at the end of "
      "the calibrated range that is nearest to it; beyond its ends the last value holds.";
  out.unverified = {
      "The sign: that a positive value moves the axis in the negative direction is documented for "
      "$AA_ENC_COMP, the other table of the same function, and taken over from there. Check with one move.",
      "$AN_CEC_MULT_BY_TABLE is not used: the product counts beside the table's own value, so that a plane "
      "of two positions would need tables that are nothing by themselves. What depends on two positions at "
      "once (roll, twist) is therefore left.",
      "828D has eight tables of 200 points, which no table here exceeds; where there are more tables here, "
      "leave out the smallest, and leave cec_1_memory.mpf out: its points are fixed."};
  out.notes = {format("%d tables%s%s.", tables.count, tables.count == 0 ? "" : ": ", tables.list.c_str()),
               "Axes are named X1, Y1 … as machine axes; change the names where yours differ."};
  return out;
}

}  // namespace mm
