#pragma once
#include <string>

namespace mm {

/// A message on one line: line breaks and runs of blanks become one blank; printableText().
std::string oneLine(const std::string& text);

}  // namespace mm
