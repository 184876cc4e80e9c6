#pragma once
#include "verification/hypotheses.h"
#include "verification/point_system.h"
#include "verification/verify.h"

namespace mm {

/// RMS before and after the correction, and whether they differ.
struct ComparedFigures : BeforeAndAfter {
  double freedoms = 0.0;     // of the sum of squares after, its noise correlated as these points show it
  double improvement = 0.0;  // difference of the squares over its standard deviation
};

/// What was measured stands on one side; on the other the same points with the correction taken back (loaded:
/// what the controller added is the table's, not the machine's, and known exactly) or applied. Errors that
/// the calibration does not explain are in both.
/// @param hypothesis of what was loaded how, for what the controller added. @param loaded: after is what was
/// measured; else before is.
ComparedFigures beforeAndAfter(const FreshPoints& points, const PointSystem& system,
                               const LoadedHow& hypothesis, bool loaded);

/// RMS of whitened columns (length x k) over the rows that the figures tell: m, or rad where there are none
/// in m.
Eigen::VectorXd rmsOf(const FreshPoints& points, const Eigen::MatrixXd& whitened);

}  // namespace mm
