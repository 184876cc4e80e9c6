#include "tools/one_line.h"

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

}  // namespace mm
