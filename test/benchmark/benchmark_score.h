#pragma once
#include <string>
#include <vector>

#include "diagnosis/diagnose.h"

namespace mm {

/// The same cause: the same type, and the same axis, direction, sensor … wherever both name one. The shape
/// (degree, power, lag) is no part of the cause.
bool sameCause(const EffectSpec& hidden, const EffectSpec& named);

/// How one hidden cause was found.
enum class Hit {
  kMissed,
  kNamed,
  kConfusable,  // it is one of at most two rivals of a named cause, which is none of the hidden ones
  kBesideDrift  // it changes with time, and is listed as what the drift may be
};

/// What a diagnosis said of the causes that were hidden.
struct Score {
  /// A list of more rivals than this points at nothing.
  static constexpr std::size_t kRivals = 2;

  std::vector<Hit> hits;  // of each hidden cause
  int wrong = 0;          // named causes that are no hidden cause and by which none was found as confusable
  int perhaps = 0;        // causes listed as what the drift may be
  /// The first named is right; or nothing is named, and a hidden cause is listed beside drift.
  bool firstRight = false, firstBesideDrift = false;
  bool claimed = false;  // a cause, a profile or a formula
  bool profile = false, formula = false;

  int count(Hit hit) const;  ///< hidden effects of that kind
  /// All found, nothing else claimed.
  bool exact() const;
};

/// Judges a diagnosis by what was hidden.
Score scoreOf(const Diagnosis& diagnosis, const std::vector<EffectSpec>& hidden);

}  // namespace mm
