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

std::string enumerated(const std::vector<std::string>& words) {
  if (words.size() < 2) return joined(words, "");
  return joined({words.begin(), words.end() - 1}, ", ") + " and " + words.back();
}

std::string printableText(std::string_view text, bool lines) {
  std::string result;
  result.reserve(text.size());
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto c = static_cast<unsigned char>(text[i]);
    const auto next = i + 1 < text.size() ? static_cast<unsigned char>(text[i + 1]) : 0;
    const bool c1 = c == 0xC2 && next >= 0x80 && next < 0xA0;  // as UTF-8 writes it
    if ((c >= 0x20 && c != 0x7F && !c1) || (lines && c == '\n'))
      result += text[i];
    else
      result += kBlanks.find(text[i]) != std::string_view::npos ? " " : "\uFFFD";
    i += c1;
  }
  return result;
}

std::string shownText(std::string_view text) {
  constexpr std::size_t kLettersShown = 120;
  const auto inside = [](char c) { return (static_cast<unsigned char>(c) & 0xC0) == 0x80; };
  std::size_t end = 0;
  for (std::size_t letters = 0; end < text.size(); ++end)
    if (!inside(text[end]) && letters++ == kLettersShown) break;
  return printableText(text.substr(0, end)) + (end < text.size() ? "…" : "");
}

}  // namespace mm
