#pragma once
#include <ostream>

#include "base/json_text.h"

namespace mm {

/// Prints an answer and a line break; numbers read back to the bit.
inline void printJson(std::ostream& out, const Json& answer) { out << jsonText(answer) << '\n'; }

}  // namespace mm
