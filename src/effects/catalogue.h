#pragma once
#include <string>
#include <vector>

#include "effects/key_recorder.h"

namespace mm {

/// One key of an effect's spec.
struct CatalogueKey {
  KeyUse use;
  bool known = true;      // false: what it takes could not be found out
  bool required = false;  // at the axes where it is taken
  std::string onlyAt;     // "linear" or "rotary": at such axes alone; empty: at all
};

/// One unknown constant: its unit where the effect acts at a linear axis, and at a rotary one.
struct CatalogueParameter {
  std::string name, unit, rotaryUnit;  // empty: it does not act there
};

/// The machine of the examples, which has linear and rotary joints.
inline constexpr const char* kExampleMachine = "five_axis";

/// One type of effect, as a user needs to know it.
struct CatalogueEntry {
  std::string type;
  bool composite = false;  // never a candidate of a diagnosis
  std::string example;     // one line of YAML that is valid on the example machine; empty: none was found
  std::string iso230;      // symbol of the example there; empty: it has none
  std::vector<CatalogueKey> keys;
  std::vector<CatalogueParameter> parameters;
  std::vector<std::string> needs;  // recorded inputs on which it depends: "position", "temperature" …
  std::string shownBy, cause, remedy;
};

/// The whole registry, the types of plugins included, told by the effects themselves: each is made on an
/// example machine (three linear and two rotary joints, sensors, a covariate, balls, a laser), and what it
/// asks for, contains and depends on is noted. Nothing of it is written down anywhere else.
/// @throw InputError when the example machine cannot be read.
std::vector<CatalogueEntry> effectCatalogue();

/// "a joint", "2 to 5", "true or false": what a key takes, for people.
std::string takesInWords(const KeyUse& use);

}  // namespace mm
