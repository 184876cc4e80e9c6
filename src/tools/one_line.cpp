#include "tools/one_line.h"

#include <iostream>

#include "base/text.h"

namespace mm {

std::string oneLine(const std::string& text) {
  std::string line;
  for (const char c : printableText(text)) {
    if (c != ' ')
      line += c;
    else if (!line.empty() && line.back() != ' ')
      line += ' ';
  }
  if (!line.empty() && line.back() == ' ') line.pop_back();
  return line;
}

void say(const std::string& message) { std::cerr << "mm: " << oneLine(message) << std::endl; }

void warn(const std::string& doubt) {
  if (!doubt.empty()) say("warning: " + doubt);
}

void warn(const std::vector<std::string>& doubts) {
  for (const std::string& doubt : doubts) warn(doubt);
}

}  // namespace mm
