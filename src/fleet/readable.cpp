#include "fleet/readable.h"

#include "base/format.h"

namespace mm {

std::string readable(const std::string& text) {
  std::string out = "'";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    out += byte < 0x80 ? std::string(1, c) : format("\\x%02X", static_cast<unsigned>(byte));
  }
  return out + "'";
}

}  // namespace mm
