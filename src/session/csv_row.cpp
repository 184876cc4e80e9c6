#include "session/csv_row.h"

#include <cmath>

namespace mm {

std::string rowFault(const Observation& o, const RowKinds& kinds, const Machine& machine) {
  if (kinds.measured() > 1)
    return "a row holds one of feature, reference_*_mm and deviation_*; leave the others empty";
  if (kinds.measured() == 0)
    return "nothing was measured: feature, reference and deviation are all empty or have no column";
  if (kinds.feature && kinds.setup) return "'setup' belongs to rows with a reference or a deviation";
  for (std::size_t j = 0; j < o.position.size(); ++j)
    if (std::isnan(o.position[j])) return "the reading of joint '" + machine.joints()[j].name + "' is empty";
  return "";
}

void setKind(Observation& o, const RowKinds& kinds) {
  o.kind = kinds.deviation   ? ObservationKind::kDeviation
           : kinds.reference ? ObservationKind::kPosition
                             : ObservationKind::kContact;
  if (o.kind == ObservationKind::kDeviation) return;
  o.deviation.clear();
  o.deviationStd.clear();
}

}  // namespace mm
