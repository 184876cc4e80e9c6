#pragma once
#include <type_traits>

namespace mm {

/// Calls f(name, field) for each field that a plain struct lists in its static `fields(self, f)`: what is
/// written to JSON and to the tables is read back by the same list.
template <class Thing, class F>
void eachField(Thing& thing, F&& f) {
  std::remove_const_t<Thing>::fields(thing, f);
}

}  // namespace mm
