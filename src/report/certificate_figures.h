#pragma once
#include <string>
#include <vector>

#include "report/certificate.h"

namespace mm {

// Every figure of a certificate, rounded once: page, plots and digital certificate show these.

/// One figure with the digits that its uncertainty allows.
struct StatedFigure {
  std::string of, name;           // "scale of x (EXX)", "s"; `of` may be empty
  std::string value;              // a decimal number, in `unit`
  std::string expanded;           // U (k = 2), in `unit`; empty: none is stated
  std::string unit;               // "um", "mm", "um/m", "1" …
  bool held = false;              // by a convention: it has no uncertainty
  std::string distribution = {};  // of the value; empty: not stated
  std::string coverage = "0.95";  // probability of value ± U
  std::string standard = {};      // u, in `unit`, of what is not symmetric about its value; it has no U
  std::string interval = {};      // 95 % of it: "0.12 … 0.55"
  std::string note = {};          // what its uncertainty leaves out, or that it has none
};

/// How figures came about: those of different origin are never put into one table.
enum class FigureOrigin { kEstimated, kMeasured, kCalculated, kPredicted };
/// "estimated from the measurements", "measured" …
const char* nameOf(FigureOrigin origin);

/// Figures of one origin.
struct StatedGroup {
  FigureOrigin origin = FigureOrigin::kMeasured;
  std::string title;
  std::vector<StatedFigure> figures;
  std::string uncertainty = "U (k = 2)";  // what `expanded` is
};

/// All of a certificate: parameters, residuals, what was measured in a session, what is calculated for it
/// with the correction, and what is predicted of each task.
std::vector<StatedGroup> statedGroups(const Certificate& certificate);

/// What is predicted of a task, its lengths left out where there are several (see lengthTable).
StatedGroup taskFigures(const CertifiedTask& task);

/// One length of a task with several.
struct LengthRow {
  double length = 0.0;  // mm
  double sum = 0.0;     // |E| + U, um
  StatedFigure error;   // E with its U, um
  std::string sumText;  // of `sum`
};
/// The lengths of a task: what the table prints and the plot draws.
struct LengthTable {
  std::vector<LengthRow> rows;  // empty: the task has fewer than two lengths
  std::size_t largest = 0;      // of `sum`
  PermissibleError least;       // that every sum keeps
  double wholeTest = 0.0;       // expected largest |E| of all measurements of the test, um
};
/// Every measured length of a task with its reference and its error. @param task lengths in one position.
LengthTable lengthTable(const TaskUncertainty& task);

/// "-12 to 12 mm"; "not recorded" of one that is not finite. @param lower, upper in the unit.
std::string rangeText(double lower, double upper, const std::string& unit);

/// Whether the calibration knows times; a session without them tells an order alone.
bool timesRecorded(const Domain& domain);

/// What a session's drift along a direction was: "along x: standard deviation 0.4 um, time constant 12 min".
std::string driftText(const Domain& domain, const Wandering& drift);

/// What the uncertainty of the parameters is: without that of the reference, where this was taken as exact.
std::string parameterUncertainty(const Calibration& calibration);

/// How much more than the repeatability the model leaves: a sentence without its stop.
std::string modelLeaves(const Calibration& calibration);

/// What of the artifact's uncertainty is not stated, each with the line that would state it; empty: it is all
/// stated. @param alongLine of a task whose points are on one line: the scale alone states it.
std::vector<std::string> uncertaintyNotStated(const Calibration& calibration,
                                              const TaskConditions& conditions, bool alongLine);

/// Leaves no verdict on a task of which the reference's uncertainty is not stated, on which the calibration
/// does not hold, or whose model leaves more than the repeatability, and says which.
void decideConformity(Certificate& certificate);

/// Of what a verdict is: "ISO 10360-2 (predicted, no test was made)".
std::string headOf(const CertifiedTask& task, const TaskVerdict& verdict);

}  // namespace mm
