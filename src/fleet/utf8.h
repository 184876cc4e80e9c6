#pragma once
#include <string>

namespace mm {

/// Whether a text is UTF-8 (RFC 3629), which is all that JSON and the tables hold.
bool isUtf8(const std::string& text);

/// A text of unknown bytes for a message: what is not ASCII as `\xE4`, in quotes.
std::string readable(const std::string& text);

}  // namespace mm
