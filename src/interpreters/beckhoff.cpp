// Beckhoff: TF5200 (lists, see compensation_list.cpp); Tc2_MC2 MC_TableBasedPositionCompensation (position,
// additive value, equidistant and ascending, WorkDirection, Modulo) and TcNc FB_PositionCompensation (another
// axis as reference). Backlash of TF5200: lr_param.anwahl_losekomp says in which direction the axis moved
// last before (1 positive, 2 negative); assumed that nothing is added in that direction.
#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/text.h"
#include "base/units.h"
#include "interpreters/compensation_list.h"
#include "interpreters/table_sum.h"
#include "interpreters/targets.h"

namespace mm {
namespace {

class BeckhoffInterpreter : public Interpreter {
 public:
  std::map<std::string, double> motors(const CommandedState& command) const override {
    std::map<std::string, double> motors = TableSum(tables).motors(command);
    for (const auto& [joint, compensations] : lists) {
      const auto motor = motors.find(joint);
      if (motor == motors.end()) continue;
      for (const auto& compensation : compensations) motor->second += compensation->added(command);
    }
    return motors;
  }

  JointPoints points() const override {
    JointPoints points = TableSum(tables).points();
    for (const auto& [joint, compensations] : lists)
      for (const auto& compensation : compensations) {
        points[joint];
        compensation->addTo(points);
      }
    return points;
  }

  std::map<std::string, std::vector<std::unique_ptr<ListCompensation>>> lists;
  std::vector<AxisTable> tables;
};

std::vector<std::filesystem::path> filesWithExtension(const std::filesystem::path& folder,
                                                      const char* extension) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    if (lower(entry.path().extension().string()) == extension) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

/// `x` of x.lis, x_negative.csv.
std::string jointOfFile(const std::filesystem::path& file) {
  const std::string stem = file.filename().string();
  return jointOfAxis(stem.substr(0, stem.find_first_of("_.")), {file, 0});
}

/// What one remark above a table of MC_TableBasedPositionCompensation says.
struct NcTableHead {
  int direction = 0;
  bool modulo = false;
  std::string reference;
};

void readNcHead(const TextLine& line, NcTableHead& head) {
  const std::size_t equals = line.text.find('=');
  if (equals == std::string::npos) return;
  const std::string key = lower(trim(std::string_view(line.text).substr(1, equals - 1)));
  const std::string value(trim(std::string_view(line.text).substr(equals + 1)));
  if (key == "direction") {
    const std::string word = lower(value);
    if (word == "workdirectionboth")
      head.direction = 0;
    else if (word == "workdirectionpositive")
      head.direction = 1;
    else if (word == "workdirectionnegative")
      head.direction = -1;
    else
      refuse(line.place, "Direction: '" + value +
                             "' is none of WorkDirectionBoth, WorkDirectionPositive, "
                             "WorkDirectionNegative");
  } else if (key == "modulo") {
    if (lower(value) != "true" && lower(value) != "false")
      refuse(line.place, "Modulo: '" + value + "' is neither TRUE nor FALSE");
    head.modulo = lower(value) == "true";
  } else if (key == "referenceaxis") {
    head.reference = jointOfAxis(value, line.place);
  }
}

void needEquidistant(const std::vector<double>& positions, const std::vector<FilePlace>& places) {
  if (positions.size() < 2) refuse(places[0], "is the only element; a table has at least two");
  const double step = positions[1] - positions[0];
  constexpr double kEqual = 1e-6;  // part of a step
  for (std::size_t i = 1; i < positions.size(); ++i) {
    const double here = positions[i] - positions[i - 1];
    if (!(here > 0.0)) refuse(places[i], "Position: is not above that of the line before");
    if (std::abs(here - step) > kEqual * std::abs(step))
      refuse(places[i], "Position: " + std::to_string(here) + " after the one before, the first step is " +
                            std::to_string(step) + "; the table must be equidistant");
  }
}

AxisTable readNcTable(const std::filesystem::path& file) {
  const std::string joint = jointOfFile(file);
  NcTableHead head;
  head.reference = joint;
  std::vector<double> positions, values;
  std::vector<FilePlace> places;
  bool named = false;
  for (const TextLine& line : textLines(file)) {
    const std::string_view text = trim(line.text);
    if (text.empty()) continue;
    if (text[0] == '#') {
      readNcHead({std::string(text), line.place}, head);
      continue;
    }
    const std::vector<std::string> cells =
        partsBetween(text, text.find(';') != std::string::npos ? ';' : ',');
    if (!named) {
      if (cells.size() != 2 || lower(cells[0]) != "position" || lower(cells[1]) != "compensation")
        refuse(line.place, "'" + std::string(text) + "' instead of the columns Position,Compensation");
      named = true;
      continue;
    }
    if (cells.size() != 2) refuse(line.place, std::to_string(cells.size()) + " cells instead of 2");
    positions.push_back(tableNumber(cells[0], line.place, "Position"));
    values.push_back(tableNumber(cells[1], line.place, "Compensation") * jointUnit(joint));
    places.push_back(line.place);
  }
  if (places.empty()) refuse({file, 0}, "has no elements");
  needEquidistant(positions, places);
  for (double& position : positions) position *= jointUnit(head.reference);
  const double period = head.modulo ? positions.back() - positions.front() : 0.0;
  const Curve curve(positions, values, period);
  return {head.reference, joint, head.direction >= 0 ? curve : Curve(),
          head.direction <= 0 ? curve : Curve()};
}

void addListBacklash(const CompensationList& list, const std::string& joint, std::vector<AxisTable>& tables) {
  const int selected = list.integer("lr_param.anwahl_losekomp", 0, 2, 0);
  if (selected == 0) return;
  constexpr double kTenthMicrometre = 1e-4;  // of mm; 0.0001 deg
  const double size = list.number("getriebe[0].lose") * kTenthMicrometre * jointUnit(joint);
  tables.push_back({joint, joint, Curve(selected == 1 ? 0.0 : size), Curve(selected == 1 ? -size : 0.0)});
}

/// Logical numbers of the axes: of the lists, else 1 is x, 2 y, 3 z, 4 a, 5 b, 6 c.
std::map<int, std::string> logicalAxes(const std::map<std::string, CompensationList>& lists) {
  std::map<int, std::string> axes;
  for (const auto& [joint, list] : lists) {
    for (const char* key : {"kopf.log_achs_nr", "kopf.achs_nr"}) {
      if (!list.has(key)) continue;
      const int number = list.integer(key, 1, 1000, 0);
      const auto [entry, added] = axes.emplace(number, joint);
      if (!added && entry->second != joint)
        refuse(list.place(key), std::string(key) + ": " + std::to_string(number) + " is that of axis " +
                                    entry->second + ", too");
    }
  }
  constexpr std::string_view kOrder = "xyzabc";
  for (std::size_t i = 0; i < kOrder.size(); ++i)
    axes.emplace(static_cast<int>(i) + 1, std::string(1, kOrder[i]));
  return axes;
}

}  // namespace

std::unique_ptr<Interpreter> interpretBeckhoff(const std::filesystem::path& folder) {
  auto interpreter = std::make_unique<BeckhoffInterpreter>();
  std::map<std::string, CompensationList> lists;
  for (const auto& file : filesWithExtension(folder, ".lis")) lists[jointOfFile(file)].read(file);
  const std::map<int, std::string> axes = logicalAxes(lists);
  for (const auto& [joint, list] : lists) {
    for (auto& compensation : listCompensations(list, joint, axes))
      interpreter->lists[joint].push_back(std::move(compensation));
    addListBacklash(list, joint, interpreter->tables);
  }
  const auto tables = filesWithExtension(folder, ".csv");
  for (const auto& file : tables) interpreter->tables.push_back(readNcTable(file));
  if (lists.empty() && tables.empty())
    throw InputError(folder.string() + ": has neither <axis>.lis nor <axis>.csv, which beckhoff reads");
  return interpreter;
}

}  // namespace mm
