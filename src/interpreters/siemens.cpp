// SINUMERIK: Function Manual Extended Functions, K3 (6FC5397-1BP40-3BA1, pages 237 to 249; 808D Function
// Manual 01/2017, page 106): a positive value of the leadscrew error compensation moves the axis in the
// negative direction. What is open there, and assumed: that this is so of the sag compensation, too, which K3
// describes as the same interpolatory compensation; that backlash adds nothing in the direction plus.
#include <algorithm>
#include <cctype>
#include <cmath>

#include "base/format.h"
#include "base/nearest_name.h"
#include "base/text.h"
#include "interpreters/table_sum.h"
#include "interpreters/targets.h"

namespace mm {
namespace {

constexpr int kMostTables = 62, kMostPoints = 5000;

/// The variables that count, and how many indices each has.
const std::map<std::string, std::size_t> kVariables = {{"$AN_CEC", 2},
                                                       {"$AN_CEC_INPUT_AXIS", 1},
                                                       {"$AN_CEC_OUTPUT_AXIS", 1},
                                                       {"$AN_CEC_STEP", 1},
                                                       {"$AN_CEC_MIN", 1},
                                                       {"$AN_CEC_MAX", 1},
                                                       {"$AN_CEC_DIRECTION", 1},
                                                       {"$AN_CEC_IS_MODULO", 1},
                                                       {"$AN_CEC_MULT_BY_TABLE", 1},
                                                       {"$SN_CEC_TABLE_ENABLE", 1},
                                                       {"$SN_CEC_TABLE_WEIGHT", 1},
                                                       {"$MN_MM_CEC_MAX_POINTS", 1},
                                                       {"$MA_CEC_ENABLE", 1},
                                                       {"$AA_ENC_COMP", 3},
                                                       {"$AA_ENC_COMP_STEP", 2},
                                                       {"$AA_ENC_COMP_MIN", 2},
                                                       {"$AA_ENC_COMP_MAX", 2},
                                                       {"$AA_ENC_COMP_IS_MODULO", 2},
                                                       {"$MA_ENC_COMP_ENABLE", 2},
                                                       {"$MA_BACKLASH", 2}};

/// Takes over what a line assigns to one of them: `$NAME[0,X1]=value`, the axis as its joint.
void readSiemensLine(const TextLine& line, KeyedValues& said) {
  std::string text = capitalsWithoutBlanks(std::string_view(line.text).substr(0, line.text.find(';')));
  if (text.size() > 1 && text[0] == 'N' && std::isdigit(static_cast<unsigned char>(text[1])) != 0)
    text.erase(0, text.find_first_not_of("0123456789", 1));
  if (text.empty() || text[0] != '$') return;
  const std::size_t open = text.find('['), equals = text.find("]=");
  const std::string name = text.substr(0, std::min(open, text.find('=')));
  const auto known = kVariables.find(name);
  if (known == kVariables.end()) {
    if (!startsWith(name, "$AN_CEC") && !startsWith(name, "$AA_ENC_COMP")) return;
    std::vector<std::string> names;
    for (const auto& [variable, count] : kVariables) names.push_back(variable);
    refuse(line.place, "variable '" + name + "' is not read" + didYouMean(name, names));
  }
  if (open > equals || equals == std::string::npos || equals + 2 == text.size())
    refuse(line.place, "'" + std::string(trim(line.text)) + "' is not [index]=value");
  std::vector<std::string> indices = partsBetween(text.substr(open + 1, equals - open - 1), ',');
  if (indices.size() != known->second)
    refuse(line.place,
           format("%s: has %zu indices in brackets, not %zu", name.c_str(), known->second, indices.size()));
  for (std::size_t i = 0; i < indices.size(); ++i) {
    std::string& index = indices[i];
    const int most = i == 0 ? kMostTables - 1 : kMostPoints;  // of a table or an encoder, of a point
    index = index.find_first_not_of("0123456789") != std::string::npos
                ? jointOfAxis(index, line.place)
                : std::to_string(tableInteger(index, line.place, name, 0, most));
  }
  std::string value = text.substr(equals + 2);
  for (const char quote : {'(', ')', '"'})
    value.erase(std::remove(value.begin(), value.end(), quote), value.end());
  said.set(name + "[" + joined(indices, ",") + "]", value, line.place);
}

/// What the values of a table take off the motor. @param prefix of its variables: $AN_CEC. @param index in
/// brackets. @param value the variable of a point.
Curve siemensCurve(const KeyedValues& said, const std::string& prefix, const std::string& index,
                   const std::string& input, const std::string& output,
                   const std::function<std::string(int point)>& value) {
  const auto name = [&](const char* what) { return prefix + what + index; };
  const double step = said.number(name("_STEP")), least = said.number(name("_MIN")),
               most = said.number(name("_MAX"));
  said.only(name("_IS_MODULO"), 0);
  if (!(step > 0.0)) said.refuse(name("_STEP"), "is not above 0");
  const int steps = static_cast<int>(std::lround((most - least) / step));
  constexpr double kWhole = 1e-6;  // of a step: rounding of the numbers in the file
  if (steps < 1 || steps >= kMostPoints || std::abs((most - least) / step - steps) > kWhole)
    said.refuse(name("_MAX"), "is not one or more whole steps above _MIN; give the end of a step");
  std::vector<double> positions, values;
  for (int n = 0; n <= steps; ++n) {
    positions.push_back((least + n * step) * jointUnit(input));
    values.push_back(-said.number(value(n), 0.0) * jointUnit(output));
  }
  if (const std::string beyond = value(steps + 1); said.has(beyond))
    said.refuse(beyond, "lies beyond " + name("_MAX"));
  return {positions, values};
}

}  // namespace

std::unique_ptr<Interpreter> interpretSiemens(const std::filesystem::path& folder) {
  const std::vector<std::filesystem::path> files = filesEndingIn({".mpf", ".spf", ".ini"}, folder);
  if (files.empty())
    refuse({folder, 0}, "has no file *.mpf, *.spf or *.ini, e.g. cec.mpf, which siemens reads");
  KeyedValues said({folder, 0});
  for (const auto& file : files)
    for (const TextLine& line : textLines(file)) readSiemensLine(line, said);
  std::vector<AxisTable> tables;
  std::map<std::string, std::set<int>> numbers;
  for (const char letter : std::string("xyzabcuvw")) {
    const std::string joint(1, letter);
    if (const double gap = said.number("$MA_BACKLASH[0," + joint + "]", 0.0); gap != 0.0)
      tables.push_back(reversal(joint, 0.0, -gap * jointUnit(joint)));
  }
  for (int table = 0; table < kMostTables; ++table) {
    const std::string number = std::to_string(table), index = "[" + number + "]";
    if (!said.hasAny("$AN_CEC[" + number + ",") || !said.flag("$SN_CEC_TABLE_ENABLE" + index, true)) continue;
    const auto axis = [&](const std::string& name) {
      const TextLine& named = said.need(name + index);
      return jointOfAxis(named.text, named.place);
    };
    const std::string input = axis("$AN_CEC_INPUT_AXIS"), output = axis("$AN_CEC_OUTPUT_AXIS");
    if (!said.flag("$MA_CEC_ENABLE[" + output + "]", true)) continue;
    said.only("$AN_CEC_MULT_BY_TABLE" + index, 0);
    said.only("$SN_CEC_TABLE_WEIGHT" + index, 1);
    const Curve curve = siemensCurve(said, "$AN_CEC", index, input, output, [&](int point) {
      return "$AN_CEC[" + number + "," + std::to_string(point) + "]";
    });
    const int points = static_cast<int>(curve.positions().size());
    if (said.integer("$MN_MM_CEC_MAX_POINTS" + index, 0, kMostPoints, points) < points)
      refuse(said.place("$MN_MM_CEC_MAX_POINTS" + index),
             format("table %d: (_MAX - _MIN) / _STEP asks for %d points, more than $MN_MM_CEC_MAX_POINTS",
                    table, points));
    const int direction = said.integer("$AN_CEC_DIRECTION" + index, -1, 1, 0);
    tables.push_back({input, output, direction < 0 ? Curve() : curve, direction > 0 ? Curve() : curve});
    numbers[output].insert(table);
  }
  for (const char letter : std::string("xyzabcuvw")) {
    const std::string joint(1, letter), index = "[0," + joint + "]";
    if (!said.has("$AA_ENC_COMP_STEP" + index) || !said.flag("$MA_ENC_COMP_ENABLE" + index, true)) continue;
    const Curve curve = siemensCurve(said, "$AA_ENC_COMP", index, joint, joint, [&](int point) {
      return "$AA_ENC_COMP[0," + std::to_string(point) + "," + joint + "]";
    });
    tables.push_back({joint, joint, curve, curve});
  }
  return std::make_unique<TableSum>(std::move(tables), std::move(numbers));
}

}  // namespace mm
