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

}  // namespace mm
