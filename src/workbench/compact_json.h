#pragma once
#include <nlohmann/json.hpp>
#include <string>

namespace mm {

/// An object on one line; what is not UTF-8 is replaced. Private to this folder's sources.
inline std::string compact(const nlohmann::ordered_json& object) {
  return object.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace mm
