#include "fleet/utf8.h"

#include <nlohmann/json.hpp>

#include "base/format.h"

namespace mm {

bool isUtf8(const std::string& text) {
  try {
    (void)nlohmann::json(text).dump();  // refuses anything else
    return true;
  } catch (const nlohmann::json::exception&) {
    return false;
  }
}

std::string readable(const std::string& text) {
  std::string out = "'";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    out += byte < 0x80 ? std::string(1, c) : format("\\x%02X", static_cast<unsigned>(byte));
  }
  return out + "'";
}

}  // namespace mm
