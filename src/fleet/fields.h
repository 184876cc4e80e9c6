#pragma once
#include <cmath>
#include <nlohmann/json.hpp>
#include <type_traits>

namespace mm {

/// Calls f(name, field) for each field that a plain struct lists in its static `fields(self, f)`: what is
/// written to JSON and to the tables is read back by the same list.
template <class Thing, class F>
void eachField(Thing& thing, const F& f) {
  std::remove_const_t<Thing>::fields(thing, f);
}

/// The fields of a thing as an object.
template <class Object, class Thing>
Object fieldsJson(const Thing& thing) {
  Object json;
  eachField(thing, [&](const char* name, const auto& field) { json[name] = field; });
  return json;
}

/// Fills them from an object. A number that is none (NaN is written as null), or that an older version did
/// not write, is NaN; such a flag stays as it is. @throw nlohmann::json::exception: another field is missing.
template <class Thing>
void readFields(const nlohmann::json& json, Thing& thing) {
  eachField(thing, [&](const char* name, auto& field) {
    using Field = std::decay_t<decltype(field)>;
    if constexpr (std::is_same_v<Field, double>)
      field =
          json.contains(name) && json[name].is_number() ? json[name].template get<double>() : std::nan("");
    else if constexpr (std::is_same_v<Field, bool>)
      field = json.value(name, field);
    else
      field = json.at(name).template get<Field>();
  });
}

}  // namespace mm
