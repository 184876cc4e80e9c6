#include "interpreters/siemens_tables.h"

#include <algorithm>
#include <functional>

#include "base/error.h"
#include "base/nearest_name.h"
#include "base/text.h"

namespace mm {
namespace {

/// `$NAME[a,b]=value` of a line.
struct SiemensAssignment {
  std::string name;  // with its $
  std::vector<std::string> indices;
  std::string value;
  FilePlace place;
};

std::string withoutSiemensBlanks(std::string_view text) {
  std::string result;
  for (const char c : text)
    if (kBlanks.find(c) == std::string_view::npos) result += c;
  return capitals(result);
}

/// @return false for a line without a system variable: %_N_…, CHANDATA, M17, an empty one.
bool readSiemensLine(const TextLine& line, SiemensAssignment& assignment) {
  std::string text = withoutSiemensBlanks(std::string_view(line.text).substr(0, line.text.find(';')));
  if (text.size() > 1 && text[0] == 'N' && std::isdigit(static_cast<unsigned char>(text[1])) != 0)
    text.erase(0, text.find_first_not_of("0123456789", 1));
  if (text.empty() || text[0] != '$') return false;
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals + 1 == text.size())
    refuse(line.place, "'" + std::string(trim(line.text)) + "' assigns no value");
  const std::size_t open = text.find('[');
  assignment = {text.substr(0, std::min(open, equals)), {}, text.substr(equals + 1), line.place};
  if (open < equals) {
    const std::size_t close = text.find(']', open);
    if (close == std::string::npos || close + 1 != equals)
      refuse(line.place, "'" + text.substr(0, equals) + "': the indices do not end in ]");
    assignment.indices = partsBetween(text.substr(open + 1, close - open - 1), ',');
  }
  for (const char quote : {'(', ')', '"'})
    assignment.value.erase(std::remove(assignment.value.begin(), assignment.value.end(), quote),
                           assignment.value.end());
  return true;
}

/// Puts assignments where they belong.
class SiemensReader {
 public:
  void read(const SiemensAssignment& a) {
    if (readCec(a) || readEncoder(a) || readMachineData(a)) return;
    const bool compensation = startsWith(a.name, "$AN_CEC") || startsWith(a.name, "$AA_ENC_COMP");
    if (compensation)
      refuse(a.place, "variable '" + a.name + "' does not exist" + didYouMean(a.name, known_));
  }
  SiemensData take() { return std::move(data_); }

 private:
  using Setter = std::function<void(SiemensTable&, const SiemensAssignment&)>;

  std::string indexed(const SiemensAssignment& a, std::size_t count) const {
    if (a.indices.size() != count)
      refuse(a.place, a.name + ": has " + std::to_string(a.indices.size()) + " indices instead of " +
                          std::to_string(count));
    return a.indices.back();
  }
  static double number(const SiemensAssignment& a) { return tableNumber(a.value, a.place, a.name); }
  static int integer(const std::string& text, const SiemensAssignment& a, int lower, int upper) {
    return tableInteger(text, a.place, a.name, lower, upper);
  }

  /// X1, or AX1 by $MN_AXCONF_MACHAX_NAME_TAB, without it by the order X1, Y1, Z1, A1, B1, C1.
  std::string joint(const std::string& axis, const SiemensAssignment& a) const {
    if (!startsWith(axis, "AX")) return jointOfAxis(axis, a.place);
    const int n =
        tableInteger(axis.substr(2), a.place, a.name + ": number of the machine axis", 1, kMostAxes);
    const auto named = axisNames_.find(n);
    if (named != axisNames_.end()) return jointOfAxis(named->second, a.place);
    constexpr std::string_view kOrder = "xyzabc";
    if (n > static_cast<int>(kOrder.size()))
      refuse(a.place, a.name + ": axis " + axis + " has no name; assign $MN_AXCONF_MACHAX_NAME_TAB before");
    return std::string(1, kOrder[n - 1]);
  }

  bool setOf(const std::map<std::string, Setter>& setters, SiemensTable& table, const SiemensAssignment& a) {
    setters.at(a.name)(table, a);
    if (table.place.line == 0) table.place = a.place;
    return true;
  }

  std::map<std::string, Setter> shape(const std::string& prefix) {
    return {{prefix + "_STEP", [](SiemensTable& t, const SiemensAssignment& a) { t.step = number(a); }},
            {prefix + "_MIN", [](SiemensTable& t, const SiemensAssignment& a) { t.min = number(a); }},
            {prefix + "_MAX", [](SiemensTable& t, const SiemensAssignment& a) { t.max = number(a); }},
            {prefix + "_IS_MODULO", [](SiemensTable& t, const SiemensAssignment& a) {
               t.modulo = tableFlag(a.value, a.place, a.name);
             }}};
  }

  bool readCec(const SiemensAssignment& a) {
    auto setters = shape("$AN_CEC");
    setters["$AN_CEC_INPUT_AXIS"] = [&](SiemensTable& t, const SiemensAssignment& s) {
      t.input = joint(s.value, s);
    };
    setters["$AN_CEC_OUTPUT_AXIS"] = [&](SiemensTable& t, const SiemensAssignment& s) {
      t.output = joint(s.value, s);
    };
    setters["$AN_CEC_DIRECTION"] = [](SiemensTable& t, const SiemensAssignment& s) {
      t.direction = integer(s.value, s, -1, 1);
    };
    setters["$AN_CEC_MULT_BY_TABLE"] = [](SiemensTable& t, const SiemensAssignment& s) {
      t.multipliedBy = integer(s.value, s, 0, kMostTables);
    };
    setters["$SN_CEC_TABLE_ENABLE"] = [](SiemensTable& t, const SiemensAssignment& s) {
      t.enabled = tableFlag(s.value, s.place, s.name);
    };
    setters["$SN_CEC_TABLE_WEIGHT"] = [](SiemensTable& t, const SiemensAssignment& s) {
      t.weight = number(s);
    };
    setters["$MN_MM_CEC_MAX_POINTS"] = [](SiemensTable& t, const SiemensAssignment& s) {
      t.mostPoints = integer(s.value, s, 0, kMostPoints);
    };
    for (const auto& setter : setters) known_.push_back(setter.first);
    if (a.name == "$AN_CEC") {
      indexed(a, 2);
      SiemensTable& table = data_.cec[integer(a.indices[0], a, 0, kMostTables - 1)];
      if (table.place.line == 0) table.place = a.place;
      table.values[integer(a.indices[1], a, 0, kMostPoints - 1)] = number(a);
      return true;
    }
    if (setters.count(a.name) == 0) return false;
    return setOf(setters, data_.cec[integer(indexed(a, 1), a, 0, kMostTables - 1)], a);
  }

  /// [encoder, axis], the values [encoder, point, axis]; the first encoder is the one that is used.
  bool readEncoder(const SiemensAssignment& a) {
    auto setters = shape("$AA_ENC_COMP");
    setters["$MA_ENC_COMP_ENABLE"] = [](SiemensTable& t, const SiemensAssignment& s) {
      t.enabled = tableFlag(s.value, s.place, s.name);
    };
    setters["$MA_MM_ENC_COMP_MAX_POINTS"] = [](SiemensTable& t, const SiemensAssignment& s) {
      t.mostPoints = integer(s.value, s, 0, kMostPoints);
    };
    for (const auto& setter : setters) known_.push_back(setter.first);
    const bool value = a.name == "$AA_ENC_COMP";
    if (!value && setters.count(a.name) == 0) return false;
    const std::string axis = joint(indexed(a, value ? 3 : 2), a);
    if (integer(a.indices[0], a, 0, 1) != 0) return true;
    SiemensTable& table = data_.encoder[axis];
    table.input = table.output = axis;
    if (!value) return setOf(setters, table, a);
    if (table.place.line == 0) table.place = a.place;
    table.values[integer(a.indices[1], a, 0, kMostPoints - 1)] = number(a);
    return true;
  }

  bool readMachineData(const SiemensAssignment& a) {
    if (a.name == "$MN_AXCONF_MACHAX_NAME_TAB") {
      axisNames_[integer(indexed(a, 1), a, 0, kMostAxes - 1) + 1] = a.value;
    } else if (a.name == "$MA_CEC_ENABLE") {
      data_.cecEnabled[joint(indexed(a, 1), a)] = tableFlag(a.value, a.place, a.name);
    } else if (a.name == "$MA_REFP_CAM_DIR_IS_MINUS") {
      data_.referencedToMinus[joint(indexed(a, 1), a)] = tableFlag(a.value, a.place, a.name);
    } else if (a.name == "$MA_BACKLASH") {
      const std::string axis = joint(indexed(a, 2), a);
      if (integer(a.indices[0], a, 0, 1) == 0) data_.backlash[axis] = number(a);
    } else {
      return false;
    }
    return true;
  }

  static constexpr int kMostTables = 62, kMostPoints = 5000, kMostAxes = 31;
  SiemensData data_;
  std::map<int, std::string> axisNames_;
  std::vector<std::string> known_;
};

}  // namespace

SiemensData readSiemensFiles(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const std::string extension = lower(entry.path().extension().string());
    if (extension == ".mpf" || extension == ".spf" || extension == ".ini") files.push_back(entry.path());
  }
  if (files.empty())
    throw InputError(folder.string() +
                     ": has no file *.mpf, *.spf or *.ini, e.g. cec.mpf, which siemens reads");
  std::sort(files.begin(), files.end());
  SiemensReader reader;
  SiemensAssignment assignment;
  for (const auto& file : files)
    for (const TextLine& line : textLines(file))
      if (readSiemensLine(line, assignment)) reader.read(assignment);
  return reader.take();
}

}  // namespace mm
