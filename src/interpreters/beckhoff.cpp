// Beckhoff TF5200 "Axis compensation" and ISG kernel, P-COMP-00001 to 00061: lists of one axis, a key and a
// value a line, lengths in 0.1 µm. Backlash: lr_param.anwahl_losekomp says in which direction the axis moved
// last before (1 positive, 2 negative); assumed that nothing is added in that direction.
#include <cmath>

#include "base/format.h"
#include "base/pattern.h"
#include "base/text.h"
#include "interpreters/table_sum.h"
#include "interpreters/targets.h"

namespace mm {
namespace {

constexpr int kMostLeadscrewPoints = 1499, kMostCrossIndex = 1000, kMostPlanePoints = 10201;

double listUnit(const std::string& joint) {
  constexpr double kTenthMicrometre = 1e-4;  // of mm; 0.0001 deg
  return kTenthMicrometre * jointUnit(joint);
}

/// Of the keys kw.… all that are read.
bool isReadKey(const std::string& key) {
  static const Pattern known(
      R"(kw\.(ssfk\.(unit|interval|kw_startpos|kw_nr_max|bilateral|modulo|table\[\d+\]\.(pos|neg))|)"
      R"(crosscomp\.(unit|last_index|master_ax_nr|table\[\d+\]\.(setpoint|correction))|)"
      R"(crosscomp2\.(unit|interval|last_index_master[12]|start_position_master[12]|master[12]_ax_nr|)"
      R"(table\[\d+\]\[\d+\]\.correction)))");
  return known.matches(key);
}

void readList(const std::filesystem::path& file, KeyedValues& list) {
  for (const TextLine& line : textLines(file)) {
    const std::string_view text = trim(std::string_view(line.text).substr(0, line.text.find('#')));
    if (text.empty()) continue;
    const std::vector<std::string> words = wordsBetweenBlanks(text);
    if (words.size() < 2) refuse(line.place, "'" + words[0] + "' has no value");
    if (startsWith(words[0], "kw.") && !isReadKey(words[0]))
      refuse(line.place, "'" + words[0] +
                             "' is not read; docs/interpreters.md names the parameters of which "
                             "the rules are known");
    list.set(words[0], words[1], line.place);
  }
}

/// A number of the table of a list, `kw.ssfk.table[3].pos`, 0 where it is not given.
double tableValue(const KeyedValues& list, const std::string& table, int i, const std::string& what) {
  return list.number(table + ".table[" + std::to_string(i) + "]" + what, 0.0);
}

/// Leadscrew error compensation: the values are absolute position errors (actual minus programmed, as the
/// documented example computes them), so they are taken off; the ends hold beyond the table (assumed:
/// documented of the plane).
AxisTable leadscrewTable(const KeyedValues& list, const std::string& joint) {
  list.only("kw.ssfk.unit", 1);
  list.only("kw.ssfk.modulo", 0);
  const int count = list.integer("kw.ssfk.kw_nr_max", 1, kMostLeadscrewPoints);
  const double interval = list.number("kw.ssfk.interval"), start = list.number("kw.ssfk.kw_startpos", 0.0);
  if (!(interval > 0.0)) list.refuse("kw.ssfk.interval", "is not above 0");
  const std::string downwards = list.flag("kw.ssfk.bilateral", false) ? ".neg" : ".pos";
  std::vector<double> positions, positive, negative;
  for (int i = 0; i < count; ++i) {
    positions.push_back((start + i * interval) * listUnit(joint));
    positive.push_back(-tableValue(list, "kw.ssfk", i, ".pos") * listUnit(joint));
    negative.push_back(-tableValue(list, "kw.ssfk", i, downwards) * listUnit(joint));
  }
  return {joint, joint, {positions, positive}, {positions, negative}, true};
}

/// @param axes logical number of an axis -> joint.
std::string masterAxis(const KeyedValues& list, const std::string& key,
                       const std::map<int, std::string>& axes) {
  const auto found = axes.find(list.integer(key, 1, 1000));
  if (found == axes.end())
    list.refuse(key,
                "axis " + list.find(key)->text + " has no list here; give one with its kopf.log_achs_nr");
  return found->second;
}

/// Cross compensation: what is added to this axis by the command of another (corrections relative to the
/// command of the slave: added as they are; the documents give no example with a sign).
AxisTable crossTable(const KeyedValues& list, const std::string& slave,
                     const std::map<int, std::string>& axes) {
  list.only("kw.crosscomp.unit", 1);
  const std::string master = masterAxis(list, "kw.crosscomp.master_ax_nr", axes);
  const int last = list.integer("kw.crosscomp.last_index", 0, kMostCrossIndex, 0);
  std::vector<double> positions, values;
  for (int i = 0; i <= last; ++i) {
    const double position = tableValue(list, "kw.crosscomp", i, ".setpoint") * listUnit(master);
    if (!positions.empty() && position <= positions.back())
      refuse(list.place("kw.crosscomp.table[" + std::to_string(i) + "].setpoint"),
             "setpoint " + std::to_string(i) + " is not above the one before");
    positions.push_back(position);
    values.push_back(tableValue(list, "kw.crosscomp", i, ".correction") * listUnit(slave));
  }
  return {master, slave, {positions, values}, {positions, values}, true};
}

/// Plane compensation: linear between the four points of a square, the margin beyond (documented).
AxesGrid planeCompensation(const KeyedValues& list, const std::string& slave,
                           const std::map<int, std::string>& axes) {
  const std::string name = "kw.crosscomp2";
  list.only(name + ".unit", 1);
  AxesGrid plane{{}, slave, {}, {}, true};
  const double interval = list.number(name + ".interval");
  if (!(interval > 0.0)) list.refuse(name + ".interval", "is not above 0");
  for (const std::string which : {"1", "2"}) {
    const std::string master = masterAxis(list, name + ".master" + which + "_ax_nr", axes);
    const int last = list.integer(name + ".last_index_master" + which, 1, kMostPlanePoints);
    const double start = list.number(name + ".start_position_master" + which, 0.0);
    plane.inputs.push_back(master);
    plane.at.emplace_back();
    for (int i = 0; i <= last; ++i) plane.at.back().push_back((start + i * interval) * listUnit(master));
  }
  const int columns = static_cast<int>(plane.at[0].size()), rows = static_cast<int>(plane.at[1].size());
  if (columns * rows > kMostPlanePoints)
    refuse(list.place(name + ".last_index_master1"),
           format("%s: %d x %d points are more than %d", name.c_str(), columns, rows, kMostPlanePoints));
  for (int i = 0; i < columns; ++i)
    for (int k = 0; k < rows; ++k)
      plane.values.push_back(tableValue(list, name, k, "[" + std::to_string(i) + "].correction") *
                             listUnit(slave));
  return plane;
}

/// Logical numbers of the axes: of the lists, else 1 is x, 2 y, 3 z, 4 a, 5 b, 6 c.
std::map<int, std::string> logicalAxes(const std::map<std::string, KeyedValues>& lists) {
  const std::string key = "kopf.log_achs_nr";
  std::map<int, std::string> axes;
  for (const auto& [joint, list] : lists) {
    if (!list.has(key)) continue;
    const auto [entry, added] = axes.emplace(list.integer(key, 1, 1000), joint);
    if (!added) list.refuse(key, list.find(key)->text + " is that of axis " + entry->second + ", too");
  }
  for (int i = 0; i < 6; ++i) axes.emplace(i + 1, std::string(1, "xyzabc"[i]));
  return axes;
}

}  // namespace

std::unique_ptr<Interpreter> interpretBeckhoff(const std::filesystem::path& folder) {
  std::map<std::string, KeyedValues> lists;
  for (const auto& file : filesEndingIn({".lis"}, folder)) {
    const std::string name = file.filename().string();  // x.lis, x.axis.lis
    const std::string joint = jointOfAxis(name.substr(0, name.find_first_of("_.")), {file, 0});
    readList(file, lists.emplace(joint, KeyedValues({file, 0})).first->second);
  }
  if (lists.empty()) refuse({folder, 0}, "has no <axis>.lis, which beckhoff reads");
  const std::map<int, std::string> axes = logicalAxes(lists);
  std::vector<AxisTable> tables;
  std::vector<AxesGrid> planes;
  for (const auto& [joint, list] : lists) {
    const auto on = [&](const std::string& name) {
      return list.hasAny("kw." + name + ".") && list.flag("lr_param." + name, true);
    };
    if (const int first = list.integer("lr_param.anwahl_losekomp", 0, 2, 0); first != 0) {
      const double gap = list.number("getriebe[0].lose", 0.0) * listUnit(joint);
      tables.push_back(reversal(joint, first == 1 ? 0.0 : gap, first == 1 ? -gap : 0.0));
    }
    if (on("ssfk")) tables.push_back(leadscrewTable(list, joint));
    if (on("crosscomp")) tables.push_back(crossTable(list, joint, axes));
    if (on("crosscomp2")) planes.push_back(planeCompensation(list, joint, axes));
  }
  return std::make_unique<TableSum>(std::move(tables), std::move(planes));
}

}  // namespace mm
