#include "workbench/request_body.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "base/error.h"

namespace mm {
namespace {

constexpr std::size_t kMostKeys = 32, kLongestName = 40, kLongestFileName = 120;

std::string printable(const std::string& given) {
  std::string text;
  for (const char c : given)
    if (static_cast<unsigned char>(c) >= 0x20 && c != 0x7f) text += c;
  return text;
}

/// Whether this byte goes on with a letter of UTF-8 that began before it.
bool insideLetter(char c) { return (static_cast<unsigned char>(c) & 0xc0) == 0x80; }

}  // namespace

RequestBody::RequestBody(const std::string& json) {
  using Json = nlohmann::json;
  std::string key;
  // as it comes: nothing is built that a client could make deep
  const auto take = [&](int depth, Json::parse_event_t event, const Json& part) {
    if (event == Json::parse_event_t::key) {
      key = part.get<std::string>();
      if (values_.count(key) > 0)
        throw InputError("the request has '" + key.substr(0, kLongestName) + "' twice");
      if (values_.size() == kMostKeys) throw InputError("the request has more keys than are known");
    } else if (depth > 0 && part.is_string()) {
      values_[key] = part.get<std::string>();
    } else if (depth > 0 && part.is_number_unsigned()) {
      values_[key] = part.get<std::uint64_t>();
    } else if (depth > 0) {
      throw InputError("the request's '" + key.substr(0, kLongestName) +
                       "' is neither a text nor a whole number");
    }
    return true;
  };
  try {
    if (!Json::parse(json, take).is_object()) throw InputError("the request is no object");
  } catch (const Json::exception&) {
    throw InputError("the request is not JSON");
  }
}

std::string RequestBody::text(const std::string& key) const {
  const auto found = values_.find(key);
  if (found == values_.end()) return {};
  if (const auto* value = std::get_if<std::string>(&found->second)) return *value;
  throw InputError("the request's '" + key + "' is not a text");
}

std::uint64_t RequestBody::number(const std::string& key) const {
  const auto found = values_.find(key);
  if (found == values_.end()) return 0;
  if (const auto* value = std::get_if<std::uint64_t>(&found->second)) return *value;
  throw InputError("the request's '" + key + "' is not a whole number");
}

void RequestBody::refuseOthers(const std::string& action, const std::vector<std::string>& known) const {
  for (const auto& [key, value] : values_)
    if (std::find(known.begin(), known.end(), key) == known.end())
      throw InputError("'" + action + "' knows no '" + key.substr(0, kLongestName) + "'");
}

std::string personsName(const std::string& given) {
  const std::string name = printable(given);
  std::size_t end = std::min(name.size(), kLongestName);
  while (end > 0 && end < name.size() && insideLetter(name[end])) --end;
  return name.substr(0, end);
}

std::string shownFileName(const std::string& given) {
  const std::string name = printable(given);
  if (name.size() <= kLongestFileName) return name;
  std::size_t begin = name.size() - kLongestFileName;
  while (begin < name.size() && insideLetter(name[begin])) ++begin;
  return "…" + name.substr(begin);
}

}  // namespace mm
