#pragma once
#include <string>

#include "machine/machine.h"
#include "session/session.h"

namespace mm {

/// What was written in one row of a CSV, beside the observation itself.
struct RowKinds {
  bool feature = false, reference = false, deviation = false, length = false, logged = false, setup = false;
  bool contact() const { return feature && !length; }                          ///< the feature was touched
  int measured() const { return contact() + length + reference + deviation; }  ///< how many kinds
  bool logsOnly() const { return measured() == 0 && logged; }                  ///< only temperatures
};

/// Why a row holds no observation; empty: it does.
std::string rowFault(const Observation& o, const RowKinds& kinds, const Machine& machine);

/// Sets the kind of an observation, and takes from it what belongs to deviations only.
void setKind(Observation& o, const RowKinds& kinds);

}  // namespace mm
