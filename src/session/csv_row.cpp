#include "session/csv_row.h"

#include <cmath>

namespace mm {

std::string rowFault(const Observation& o, const RowKinds& kinds, const Machine& machine) {
  if (kinds.measured() > 1)
    return "a row holds one of feature, length_mm, reference_*_mm and deviation_*; leave the others empty";
  if (kinds.measured() == 0)
    return "nothing was measured: feature, length, reference and deviation are all empty or have no column";
  if (kinds.length && !kinds.feature)
    return "length_mm: 'feature' must name the point of the artifact file from which it was measured";
  if (kinds.length && !kinds.setup && o.length <= 0.0)
    return "length_mm must be above 0; lengths that count from an unknown zero need a 'setup'";
  if (kinds.contact() && kinds.setup)
    return "'setup' belongs to rows with a length, a reference or a deviation";
  for (std::size_t j = 0; j < o.position.size(); ++j)
    if (std::isnan(o.position[j])) return "the reading of joint '" + machine.joints()[j].name + "' is empty";
  return "";
}

void setKind(Observation& o, const RowKinds& kinds) {
  o.kind = kinds.deviation   ? ObservationKind::kDeviation
           : kinds.length    ? ObservationKind::kLength
           : kinds.reference ? ObservationKind::kPosition
                             : ObservationKind::kContact;
  if (o.kind == ObservationKind::kDeviation) return;
  o.deviation.clear();
  o.deviationStd.clear();
}

}  // namespace mm
