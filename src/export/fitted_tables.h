#pragma once
#include <Eigen/Core>
#include <functional>
#include <vector>

#include "export/needed_correction.h"

namespace mm {

struct Exported;

/// Correction of every joint over the position of one axis, for either direction of its travel: what is
/// common to the whole calibrated volume and its temperatures (the mean over them), less its value at the
/// reference. SI.
struct LineTable {
  int input = 0;                                        // joint
  std::vector<double> at;                               // m or rad, equal steps, ascending
  std::vector<std::vector<double>> positive, negative;  // a joint that is corrected; m, one a point
  int samplesAStep = 0;                                 // inside each step, to which the points were fitted
  std::vector<double> left;   // a joint: the most that the table leaves of what the calibration adds, m
  std::vector<double> added;  // a joint: the largest that the calibration adds, m

  /// Of both directions of travel at a point of a joint that is corrected; m.
  double mean(int output, std::size_t point) const {
    return 0.5 * (positive[output][point] + negative[output][point]);
  }
  /// Linear between the points, the ends held. @param travel +1, -1; 0: the mean.
  double value(int output, double position, double travel) const;
  /// The calibration has something for this output; else what was active says it as it is.
  bool changes(int output) const { return added[output] > kLeastOfATable; }
  double largest(int output) const;               ///< absolute value of an output, m
  static constexpr double kLeastOfATable = 1e-8;  // m
};

/// At most `mostPoints` of them: as few as follow the curve within 0.02 um by straight lines; where not even
/// the most do, as few as leave hardly more of it than those. Points are fitted to samples between them
/// (hatOrLineFit): what no table of so many points can follow is left as it is, never made worse. The steps
/// are whole tenths of a micrometre, and cover the observed range. Where tables over this axis were active
/// that have equal steps, the points are theirs and whole parts of their steps: there the new table is the
/// active one and what the calibration adds.
/// @param part adds() leaves the active one out.
LineTable lineTable(const NeededCorrection& needed, int input, int mostPoints,
                    CorrectionPart part = &NeededCorrection::at);

/// The mean of the correction over states that are put in their place one after the other.
Eigen::VectorXd meanOver(const NeededCorrection& needed, CorrectionPart part, std::vector<State>& states,
                         const std::function<void(State&)>& put);

/// What lineTable's curve is at a position, both directions together: m, a joint each, not less its value at
/// the reference.
Eigen::VectorXd meanCorrection(const NeededCorrection& needed, int input, double position,
                               CorrectionPart part = &NeededCorrection::at);

/// Tells in `out` which of `outputs` the table does not follow, how many points it has and what it leaves.
void addNotFollowed(const NeededCorrection& needed, const LineTable& table, const std::vector<int>& outputs,
                    Exported& out);

/// Correction of every joint over the positions of two axes: the mean over everything else, less its value at
/// the reference. SI.
struct PlaneTable {
  int first = 0, second = 0;              // joints
  std::vector<double> atFirst, atSecond;  // equal steps, ascending
  std::vector<Eigen::MatrixXd> value;     // a joint that is corrected: rows by first, columns by second

  /// Of a joint that is corrected, at positions of both joints: bilinear, the borders held; m.
  double interpolated(int output, double first, double second) const;
};
/// @param atFirst, atSecond ascending positions, at least two each.
PlaneTable planeTable(const NeededCorrection& needed, int first, int second, std::vector<double> atFirst,
                      std::vector<double> atSecond, CorrectionPart part = &NeededCorrection::at);

/// The straight part of the correction, by least squares over the calibrated volume: m/m, m, m/K. What does
/// not stand out of the rest by four standard errors is chance, and 0.
struct StraightPart {
  Eigen::MatrixXd byPosition;  // row: corrected joint, column: joint that moves
  Eigen::MatrixXd byTravel;    // half of what a reversal of the column's joint changes
  Eigen::MatrixXd bySensor;    // column: sensor of the domain

  /// Of two axes the whole angle by which they are not square, as a correction of `output` by `input`:
  /// whichever of them the calibration holds for the reference, as the other part only turns the workpiece.
  double square(int output, int input) const { return byPosition(output, input) + byPosition(input, output); }
};
/// @param part adds(): what the calibration adds. activeAt(): of what was active all counts, nothing is
/// chance.
StraightPart straightPart(const NeededCorrection& needed, CorrectionPart part);

/// `from` to beyond `to` in `intervals` equal steps, each a whole number of 0.1 um.
std::vector<double> evenSteps(double from, double to, int intervals);

}  // namespace mm
