#include "import/column_mapping.h"

#include <sstream>

#include "base/read_file.h"
#include "base/yaml_mapping.h"

namespace mm {
namespace {

/// What formats ask for; each is a word or a number.
constexpr const char* kSettings[] = {"axis",      "plane",     "radius_mm", "feed_mm_min", "direction",
                                     "start_deg", "centre_mm", "surface",   "mount",       "position_mm",
                                     "unit",      "date",      "sign"};

std::map<std::string, std::string> words(const YamlMapping& file, const std::string& key,
                                         const std::string& what) {
  std::map<std::string, std::string> found;
  if (!file.has(key)) return found;
  const YAML::Node node = file.node(key);
  if (!node.IsMap()) file.fail(key, what);
  for (const auto& entry : node) {
    if (!entry.first.IsScalar() || !entry.second.IsScalar()) file.fail(key, what);
    if (!found.emplace(entry.first.Scalar(), entry.second.Scalar()).second)
      file.fail(key, "'" + entry.first.Scalar() + "' is given twice");
  }
  return found;
}

}  // namespace

std::string ColumnMapping::setting(const std::string& key) const {
  const auto found = settings.find(key);
  return found == settings.end() ? "" : found->second;
}

std::string ColumnMapping::place(const std::string& key) const {
  return source + ":" + std::to_string(lines.at(key)) + ": ";
}

ColumnMapping parseColumnMapping(const std::string& yaml, const std::string& source) {
  std::vector<std::string> keys = {"format",  "separator", "decimal",  "header_line",
                                   "columns", "others",    "features", "fixed"};
  keys.insert(keys.end(), std::begin(kSettings), std::end(kSettings));
  const YAML::Node root = YamlMapping::load(yaml, source);
  const YamlMapping file(root, source, "the mapping", keys);
  ColumnMapping m;
  m.source = source;
  if (file.has("format")) m.format = file.text("format");
  if (file.has("separator")) {
    static const std::map<std::string, char> kSeparators = {{",", ','},   {";", ';'},     {"|", '|'},
                                                            {" ", ' '},   {"space", ' '}, {"blank", ' '},
                                                            {"\t", '\t'}, {"tab", '\t'}};
    const auto known = kSeparators.find(file.text("separator"));
    if (known == kSeparators.end())
      file.fail("separator",
                "is '" + file.text("separator") + "', but must be one of \",\" \";\" \"|\" tab blank");
    m.separator = known->second;
  }
  if (file.has("decimal")) {
    const std::string s = file.text("decimal");
    if (s != "comma" && s != "point") file.fail("decimal", "is '" + s + "', but must be comma or point");
    m.decimalComma = s == "comma";
  }
  if (file.has("header_line")) m.headerLine = static_cast<std::size_t>(file.count("header_line", 0));
  m.columns =
      words(file, "columns", "must be a mapping of a column's name to what it holds: {Position: x_mm}");
  if (file.has("others")) {
    if (file.text("others") != "ignore") file.fail("others", "can only be 'ignore'");
    m.ignoreOthers = true;
  }
  m.features =
      words(file, "features", "must be a mapping of names in the file to names in the artifact: {A: b0}");
  for (const auto& [name, value] :
       words(file, "fixed", "must be a mapping of joints to numbers: {y_mm: 12.5}")) {
    std::istringstream in(value);
    double number = 0.0;
    if (!(in >> number) || !in.eof()) file.fail("fixed", "'" + value + "' of " + name + " is not a number");
    m.fixed[name] = number;
  }
  for (const std::string key : kSettings) {
    if (!file.has(key)) continue;
    const YAML::Node node = file.node(key);
    std::string value;
    if (node.IsSequence())
      for (const YAML::Node& n : node) value += (value.empty() ? "" : " ") + n.Scalar();
    else
      value = file.text(key);
    m.settings[key] = value;
    m.lines[key] = file.line(key);
  }
  return m;
}

ColumnMapping loadColumnMapping(const std::filesystem::path& file) {
  return parseColumnMapping(readWholeFile(file, "check --columns"), file.string());
}

}  // namespace mm
