#pragma once
#include <string>
#include <vector>

namespace mm {

/// A message on one line: line breaks and runs of blanks become one blank; printableText().
std::string oneLine(const std::string& text);

/// A message of `mm` on standard error, one line.
void say(const std::string& message);
/// The same as a warning; nothing where the text is empty.
void warn(const std::string& doubt);
/// A warning each.
void warn(const std::vector<std::string>& doubts);

}  // namespace mm
