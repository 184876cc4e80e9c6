#pragma once
#include <string>
#include <string_view>
#include <vector>

namespace mm {

inline constexpr std::string_view kBlanks = " \t\r\n\v\f";

/// Without blanks (or what else is in `taken`) at either end. Points into `text`.
std::string_view trim(std::string_view text, std::string_view taken = kBlanks);
bool startsWith(std::string_view text, std::string_view start);
bool endsWith(std::string_view text, std::string_view end);
/// ASCII letters and the German umlauts in lower case.
std::string lower(std::string_view text);
/// Words one after the other, with `between` between them.
std::string joined(const std::vector<std::string>& words, std::string_view between);
/// "a, b and c"; empty of none.
std::string enumerated(const std::vector<std::string>& words);
/// Text of a foreign file without what would steer a terminal: of the control characters (C0, DEL, C1) tabs
/// and line ends become blanks, the others U+FFFD. @param lines whether line ends stay.
std::string printableText(std::string_view text, bool lines = false);
/// A cell or a name of a foreign file for people: printable, of a longer one the first 120 letters and "…".
std::string shownText(std::string_view text);

}  // namespace mm
