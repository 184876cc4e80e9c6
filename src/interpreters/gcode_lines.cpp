#include "interpreters/gcode_lines.h"

#include <cctype>

#include "base/text.h"

namespace mm {
namespace {

std::string withoutGcodeRemarks(const std::string& text) {
  std::string result;
  bool inside = false;
  for (const char c : text) {
    if (c == ';' && !inside) break;
    if (c == '(') inside = true;
    if (!inside) result += c;
    if (c == ')') inside = false;
  }
  const std::size_t checksum = result.find('*');
  return checksum == std::string::npos ? result : result.substr(0, checksum);
}

bool isLetter(char c) { return std::isalpha(static_cast<unsigned char>(c)) != 0; }

/// Takes a letter and the digits behind it off the front.
std::string takeWord(std::string_view& text) {
  text = trim(text);
  std::size_t end = 1;
  while (end < text.size() && !isLetter(text[end]) && kBlanks.find(text[end]) == std::string_view::npos)
    ++end;
  std::string word = capitals(text.substr(0, std::min(end, text.size())));
  text.remove_prefix(std::min(end, text.size()));
  return word;
}

}  // namespace

std::map<char, std::optional<double>> GcodeCommand::words() const {
  std::map<char, std::optional<double>> words;
  std::string_view text = trim(rest);
  while (!(text = trim(text)).empty()) {
    if (!isLetter(text.front()))
      refuse(place, name + ": '" + std::string(text) + "' does not begin with a letter of a parameter");
    const std::string word = takeWord(text);
    std::optional<double> value;
    if (word.size() > 1) value = tableNumber(word.substr(1), place, name + " " + word[0]);
    if (!words.emplace(word[0], value).second)
      refuse(place, name + ": parameter " + word[0] + " is there twice");
  }
  return words;
}

std::vector<GcodeCommand> gcodeCommands(const std::filesystem::path& file) {
  std::vector<GcodeCommand> commands;
  for (const TextLine& line : textLines(file)) {
    const std::string text = withoutGcodeRemarks(line.text);
    std::string_view rest = trim(text);
    if (rest.empty() || !isLetter(rest.front())) continue;
    std::string name = takeWord(rest);
    if (name[0] == 'N' && name.size() > 1) {
      rest = trim(rest);
      if (rest.empty()) continue;
      name = takeWord(rest);
    }
    commands.push_back({name, std::string(rest), line.place});
  }
  return commands;
}

double ReversalBacklash::added(const std::string& joint, int direction) const {
  const auto found = distances_.find(joint);
  if (found == distances_.end() || direction > 0) return 0.0;
  return direction < 0 ? -found->second : -0.5 * found->second;
}

void ReversalBacklash::addTo(JointPoints& points) const {
  for (const auto& [joint, distance] : distances_)
    if (distance != 0.0) points[joint];
}

}  // namespace mm
