#pragma once
#include <string>

namespace mm {

/// A text of unknown bytes for a message: what is not ASCII as `\xE4`, in quotes.
std::string readable(const std::string& text);

}  // namespace mm
