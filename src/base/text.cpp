#include "base/text.h"

#include <cctype>

namespace mm {

std::string_view trim(std::string_view text, std::string_view taken) {
  const std::size_t begin = text.find_first_not_of(taken);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(taken) - begin + 1);
}

bool startsWith(std::string_view text, std::string_view start) {
  return text.substr(0, start.size()) == start;
}

bool endsWith(std::string_view text, std::string_view end) {
  return text.size() >= end.size() && text.substr(text.size() - end.size()) == end;
}

std::string lower(std::string_view text) {
  std::string result(text);
  for (std::size_t i = 0; i < result.size(); ++i) {
    result[i] = static_cast<char>(std::tolower(static_cast<unsigned char>(result[i])));
    // the capital umlauts of UTF-8 are 0x20 below the small ones
    if (result[i] == '\xC3' && i + 1 < result.size()) {
      ++i;
      const auto c = static_cast<unsigned char>(result[i]);
      constexpr unsigned char kTimes = 0x97;  // a multiplication sign is no letter
      if (c >= 0x80 && c <= 0x9E && c != kTimes) result[i] = static_cast<char>(c + 0x20);
    }
  }
  return result;
}

std::string joined(const std::vector<std::string>& words, std::string_view between) {
  std::string text;
  for (const std::string& word : words) {
    if (&word != &words.front()) text += between;
    text += word;
  }
  return text;
}

}  // namespace mm
