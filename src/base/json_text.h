#pragma once
#include <functional>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <string>

namespace mm {

/// Keys stay in their order; a number that is NaN or infinite is written as null.
using Json = nlohmann::ordered_json;

/// A list with an entry for each of a range. @param entry of one: a function, or a member.
template <class Range, class Entry>
Json jsonList(const Range& range, const Entry& entry) {
  Json list = Json::array();
  for (const auto& one : range) list.push_back(std::invoke(entry, one));
  return list;
}

/// One object with the entries of several, in their order; a part that is null has none.
inline Json jsonObject(std::initializer_list<Json> parts) {
  Json object = Json::object();
  for (const Json& part : parts)
    if (!part.is_null()) object.update(part);
  return object;
}

/// An object with one entry, or null where it is not `there`.
template <class Value>
Json entryIf(bool there, const std::string& name, const Value& value) {
  return there ? Json{{name, value}} : Json(nullptr);
}

/// The value, or null where it is not `there`.
template <class Value>
Json orNull(bool there, const Value& value) {
  return there ? Json(value) : Json(nullptr);
}

/// Without a line break at its end. Text that is not UTF-8 (a name from a foreign file) is replaced, never
/// thrown over: the answer counts. @param indent blanks a level.
inline std::string jsonText(const Json& json, int indent = 2) {
  return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

/// The same on one line.
inline std::string jsonLine(const Json& json) { return jsonText(json, -1); }

}  // namespace mm
