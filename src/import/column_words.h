#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace mm {

/// What a word in the name of a column says.
enum class WordClass {
  kTime,
  kDate,
  kFeature,
  kDeviation,
  kError,
  kReference,
  kStd,
  kVelocity,
  kTemperature,
  kSetup,
  kPlacement,
  kStylus,
  kRun,
  kDirection,
  kDisplay,
  kReading,
  kTarget,
  kMeasured,
  kIndex,
  kNote,
  kFiller
};

/// The class of a word in small letters: English, German, French and some more. Nothing: it is in none.
std::optional<WordClass> classOf(std::string_view word);

/// A column's name without its unit, and the unit: `X [mm]`, `x_mm`, `Temp (°C)`, `enc1/um`.
struct NameAndUnit {
  std::string stem;
  std::string unitText;  // as written; empty: none
};
NameAndUnit splitUnit(const std::string& name);  ///< of a head

/// The words of a name in small letters: letters and digits, cut at everything else.
std::vector<std::string> wordsOf(std::string_view name);

}  // namespace mm
