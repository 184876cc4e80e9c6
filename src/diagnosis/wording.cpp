#include "diagnosis/wording.h"

#include <cmath>
#include <cstdio>

#include "machine/units.h"

namespace mm {
std::string shortNumber(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

std::string nameOf(Verdict verdict) {
  switch (verdict) {
    case Verdict::kInsufficientData:
      return "insufficient_data";
    case Verdict::kUnknownEffect:
      return "unknown_effect";
    case Verdict::kConfusable:
      return "confusable";
    case Verdict::kMissingEffect:
      return "missing_effect";
    case Verdict::kScatter:
      return "scatter";
    default:
      return "explained";
  }
}

}  // namespace mm
