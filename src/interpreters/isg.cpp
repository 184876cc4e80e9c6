// Volumetric compensation of the ISG kernel and Beckhoff TF5280: "ISG CSV format" (blanks between columns, //
// remarks, # a new header), "Units of measure" (mm, arguments in mm or degrees), "List of parameters
// supported", "Interpolation mode" (GRID: linear), "General configuration", P-VOLC-00001 to 00014.
// "Parametric model in accordance with DIN ISO 230 and ISO TR 16907": errors displace a carriage from its
// nominal place, and the axis values follow from the inverted model, so that errors are taken off. What is
// open, and assumed: beyond a table its end holds; errors are looked up at the command.
#include <algorithm>
#include <cmath>
#include <set>

#include "base/erase_if.h"
#include "base/nearest_name.h"
#include "base/pattern.h"
#include "base/text.h"
#include "interpreters/table_sum.h"
#include "interpreters/targets.h"

namespace mm {
namespace {

constexpr const char* kIsgList = "volcomp.lis";
constexpr int kMostIsgFiles = 10, kMostIsgAxis = 65535;

/// Keys of the configuration; those that say nothing of where the motors stand at rest, or of rotary axes
/// alone, are not looked at.
std::vector<std::string> isgKeys() {
  std::vector<std::string> keys = wordsBetweenBlanks(
      "x y z a b c chain workpiece_axes negate set_to_zero alternative_model interpolation enable_splicing "
      "diagnosis_file manual_activation filter_steps associate_to_channel use_axis_offsets");
  for (int j = 0; j < kMostIsgFiles; ++j)
    for (const char* key : {"file", "file_format"}) keys.push_back(key + ("[" + std::to_string(j)) + "]");
  return keys;
}

KeyedValues readIsgList(const std::filesystem::path& file) {
  KeyedValues list({file, 0});
  const std::vector<std::string> known = isgKeys();
  for (const TextLine& line : textLines(file)) {
    const std::string_view text = trim(std::string_view(line.text).substr(0, line.text.find('#')));
    if (text.empty()) continue;
    const std::string word = wordsBetweenBlanks(text)[0], key = lower(word);
    const std::string_view value = trim(text.substr(word.size()));
    if (std::find(known.begin(), known.end(), key) == known.end())
      refuse(line.place, "'" + word + "' is not read" + didYouMean(key, known));
    if (value.empty()) refuse(line.place, "'" + word + "' has no value");
    list.set(key, value, line.place);
  }
  return list;
}

/// What a key says in capital letters, `missing` where it is not given.
std::string isgWord(const KeyedValues& list, const std::string& key, const std::string& missing) {
  return list.has(key) ? capitalsWithoutBlanks(list.find(key)->text) : missing;
}

void checkIsgList(const KeyedValues& list) {
  std::map<int, std::string> axes;
  for (const char* key : {"x", "y", "z"}) {
    list.need(key);
    const auto [entry, added] = axes.emplace(list.integer(key, 0, kMostIsgAxis), key);
    if (!added)
      list.refuse(key, list.find(key)->text + " is the logical number of " + entry->second + ", too");
  }
  const auto only = [&](const std::string& key, const std::vector<std::string>& read) {
    const std::string said = isgWord(list, key, read[0]);
    if (std::find(read.begin(), read.end(), said) == read.end())
      list.refuse(key, said + " is not read, only " + listOf(read));
  };
  only("chain", {"XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX"});
  only("workpiece_axes", {"0"});
  only("interpolation", {"GRID", "AUTO"});
  for (const char* key : {"use_axis_offsets", "alternative_model"}) only(key, {"0", "FALSE"});
  for (const std::string key : {"negate", "set_to_zero"})
    if (isgWord(list, key, "").find_first_not_of("XYZ") != std::string::npos)
      list.refuse(key, "'" + list.find(key)->text + "' is no set of X, Y and Z, as in XY");
}

/// By what the errors along a joint are multiplied.
double isgFactor(const KeyedValues& list, const std::string& joint) {
  const auto named = [&](const char* key) {
    return isgWord(list, key, "").find(capitals(joint)) != std::string::npos;
  };
  return named("set_to_zero") ? 0.0 : named("negate") ? -1.0 : 1.0;
}

/// Tables with their headers; # begins the next.
std::vector<TextTable> isgBlocks(const std::filesystem::path& file) {
  std::vector<TextTable> blocks(1);
  for (const TextLine& line : textLines(file)) {
    const std::string_view text = trim(std::string_view(line.text).substr(0, line.text.find("//")));
    if (text.empty()) continue;
    if (text[0] == '#') {
      if (text.size() > 1) refuse(line.place, "'" + std::string(text) + "': # stands alone on its line");
      blocks.emplace_back();
    } else {
      blocks.back().add(wordsBetweenBlanks(blocks.back().names.cells.empty() ? capitals(text) : text),
                        line.place);
    }
  }
  eraseIf(blocks, [](const TextTable& block) { return block.names.cells.empty(); });
  if (blocks.empty()) refuse({file, 0}, "has no header: a line with the names of columns is expected");
  return blocks;
}

bool isIsgArgument(const std::string& name) {
  return name.size() == 1 && std::string_view("XYZABC").find(name[0]) != std::string_view::npos;
}

/// EXX to EZZ. @throw InputError for another parameter.
bool isIsgError(const std::string& name, const FilePlace& place) {
  static const Pattern known("E[XYZ]{2}");
  if (isIsgArgument(name)) return false;
  if (!known.matches(name))
    refuse(place, "column " + name +
                      " is not read, only X, Y, Z, A, B, C and EXX to EZZ; about which point "
                      "angles turn is not documented");
  return true;
}

/// The positions of a block and which of its records belongs to each point of their grid.
struct IsgPlaces {
  std::vector<std::string> arguments;
  std::vector<std::vector<double>> at;
  std::vector<std::size_t> point;  // of a record
};

IsgPlaces isgPlaces(const TextTable& block) {
  IsgPlaces places;
  places.point.assign(block.rows.size(), 0);
  for (const std::string& name : block.names.cells) {
    if (!isIsgArgument(name)) continue;
    const std::string joint = lower(name);
    const std::vector<double> positions = inUnit(block.numbers(name), jointUnit(joint));
    std::vector<double> at = positions;
    std::sort(at.begin(), at.end());
    at.erase(std::unique(at.begin(), at.end()), at.end());
    if (at.size() < 2) continue;  // the same everywhere
    for (std::size_t i = 0; i < positions.size(); ++i)
      places.point[i] =
          places.point[i] * at.size() +
          static_cast<std::size_t>(std::lower_bound(at.begin(), at.end(), positions[i]) - at.begin());
    places.arguments.push_back(joint);
    places.at.push_back(std::move(at));
  }
  std::size_t count = 1;
  for (const std::vector<double>& at : places.at) count *= at.size();
  std::set<std::size_t> seen;
  for (std::size_t i = 0; i < places.point.size(); ++i)
    if (!seen.insert(places.point[i]).second)
      refuse(block.rows[i].place, "a record of these positions is there already");
  if (seen.size() != count)
    refuse(block.names.place, "the records are not on a grid: " + std::to_string(seen.size()) +
                                  " instead of " + std::to_string(count) + " combinations of positions");
  return places;
}

/// @param named errors that are there already.
void addIsgErrors(const TextTable& block, const KeyedValues& list, std::set<std::string>& named,
                  std::vector<AxesGrid>& grids) {
  std::set<std::string> arguments;
  std::vector<std::string> errors;
  for (const std::string& name : block.names.cells) {
    const bool error = isIsgError(name, block.names.place);
    if (!(error ? named : arguments).insert(name).second)
      refuse(block.names.place, "column " + name + " is there twice; which one counts is not documented");
    if (error) errors.push_back(name);
  }
  if (block.rows.empty()) refuse(block.names.place, "no records stand below this header");
  const IsgPlaces places = isgPlaces(block);
  for (const std::string& name : errors) {
    const std::string joint = lower(name.substr(1, 1));
    const double taken = -jointUnit(joint) * isgFactor(list, joint);
    const std::vector<double> numbers = block.numbers(name);
    AxesGrid grid{places.arguments, joint, places.at, std::vector<double>(numbers.size())};
    for (std::size_t i = 0; i < numbers.size(); ++i) grid.values[places.point[i]] = numbers[i] * taken;
    grids.push_back(std::move(grid));
  }
}

/// The file of a path on the control, in the folder here.
std::filesystem::path isgFile(const KeyedValues& list, const std::string& key,
                              const std::filesystem::path& folder) {
  const std::string& path = list.find(key)->text;
  const std::string name = path.substr(path.find_last_of("/\\") + 1);
  if (!std::filesystem::is_regular_file(folder / name))
    list.refuse(key, "there is no file '" + (folder / name).string() + "'; put it there");
  return folder / name;
}

}  // namespace

std::unique_ptr<Interpreter> interpretIsg(const std::filesystem::path& folder) {
  if (!std::filesystem::is_regular_file(folder / kIsgList))
    refuse({folder, 0}, std::string("has no ") + kIsgList + ", which isg reads");
  const KeyedValues list = readIsgList(folder / kIsgList);
  checkIsgList(list);
  std::set<std::string> named;
  std::vector<AxesGrid> grids;
  bool any = false;
  for (int j = 0; j < kMostIsgFiles; ++j) {
    const std::string index = "[" + std::to_string(j) + "]", kind = "file_format" + index;
    if (!list.has("file" + index)) continue;
    any = true;
    if (const std::string said = isgWord(list, kind, "ISG_CSV"); said != "ISG_CSV")
      list.refuse(kind, said + " is not read, only ISG_CSV");
    for (const TextTable& block : isgBlocks(isgFile(list, "file" + index, folder)))
      addIsgErrors(block, list, named, grids);
  }
  if (!any) refuse(list.whole(), "file[0] is missing");
  return std::make_unique<TableSum>(std::vector<AxisTable>{}, std::move(grids));
}

}  // namespace mm
