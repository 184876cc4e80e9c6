#pragma once
#include <map>
#include <string>
#include <vector>

#include "calibration_file/calibration.h"
#include "estimation/calibrate.h"
#include "session/session.h"

namespace mm {

/// What one block of a blind trial shows, judged as a session of its own: pose of the artifact, zeros of
/// setups and free balls are fitted in it alone, so that neither state is favoured, and homing after the
/// correction was switched does no harm.
struct TrialBlockFigures {
  int number = 0;     // of the block, from 1
  char state = 'A';   // of the controller: A or B
  double time = 0.0;  // s from the session's start, the mean of its measurements
  int measurements = 0, outliers = 0;
  double remaining = 0.0;  // how much of the predicted error is there: 1 all of it, 0 nothing, 2 twice
  double rms = 0.0;        // m (rad) of the residuals
  /// The same as `remaining` of each corrected axis, where there are several and the points tell them apart.
  std::map<std::string, double> ofAxis;
};

/// The blocks of a trial in the order of time, and what is amiss with them.
struct TrialBlocks {
  std::string trial;                      // as TrialBlock::trial
  int planned = 0;                        // blocks
  std::vector<TrialBlockFigures> blocks;  // that are judged
  std::vector<std::string> remarks;       // blocks that are missing, incomplete, measured twice
  bool fittedPose = false;                // the RMS is about the pose that each block fits
  std::string notJudged;                  // a sentence: what each block fits for itself; empty: nothing
  bool angular = false;                   // in rad: there are no residuals in m
  double predicted = 0.0;                 // m (rad): RMS of the predicted error at these points
};

/// A quantity in the two states: least squares with a level, a linear trend in time and a step between the
/// states, a block each. Half-widths are of 99 % (Student's t), each state with the scatter of its own blocks
/// (degrees of freedom by Welch and Satterthwaite); infinite where the blocks are too few, NaN where a state
/// has none.
struct StatesCompared {
  double a = kNotMeasured, b = kNotMeasured;  // in the middle of the trial
  double aHalf = kNotMeasured, bHalf = kNotMeasured;
  double difference = kNotMeasured, half = kNotMeasured;  // b - a
  double p = 1.0;  // two-sided, of a step so large over all orders that may have been drawn
};

/// A trial whose key is not open: what differs between A and B, to either side.
struct LabelledTrial {
  StatesCompared remaining, logRms;  // of TrialBlockFigures; the natural logarithm
  /// Of TrialBlockFigures::ofAxis, where every block tells it; the half-widths of all together are of 99 %.
  std::map<std::string, StatesCompared> ofAxis;
  double smallestP = 1.0;  // that so many blocks can give
  int blocksA = 0, blocksB = 0;
};

inline constexpr double kFalseAnswers = 0.01;  // of trials, that say by chance "helped" or "wrong sign"

enum class TrialVerdict {
  kHelped,
  kHelpedInPart,
  kOvercorrected,
  kDidNothing,
  kWrongSign,
  kWorse,
  kCannotTell
};
std::string nameOf(TrialVerdict verdict);  ///< "helped", "helped_in_part", "overcorrected", "did_nothing" …

/// A figure with the ends of its 99 % interval.
struct TrialFigure {
  double value = 0.0, lower = 0.0, upper = 0.0;
};

struct AxisGain {
  std::string axis;
  TrialFigure gain;  // all axes' intervals together are of 99 %
  double p = 1.0;
};

/// The same with the key.
struct OpenedTrial {
  TrialVerdict verdict = TrialVerdict::kCannotTell;
  TrialFigure gain;  // share of the predicted correction that arrives: 1 all, 0 nothing, -1 wrong sign
  std::vector<AxisGain> axes;  // the same of each axis; empty: it has one, or they cannot be told apart
  TrialFigure without, with;   // m (rad): RMS with the correction off and on (geometric mean of the blocks)
  TrialFigure ratio;           // with / without
  double gainP = 1.0, rmsP = 1.0;
  int blocksWanted = 0;  // cannot tell: of a trial that could; 0: none of reasonable size
  std::string inWords;
};

/// The blocks of a session of a blind trial. No parameter of the calibration is refitted. A block with less
/// than half of the usual measurements is left out, and so is one in which the correction cannot show; one
/// that was measured again counts once, as the mean.
/// @param options for the session's own unknowns; `progress` is told of each block. @throw InputError:
/// another machine, no trial or two, the calibration predicts nothing at these points. Cancelled.
TrialBlocks trialBlocks(const Session& session, const Calibration& calibration,
                        const CalibrateOptions& options);

/// Compares the states without knowing in which of them the correction acts.
LabelledTrial compareStates(const std::vector<TrialBlockFigures>& blocks);

/// Says what it means. "Helped" and "wrong sign" need a gain and an RMS whose 99 % intervals exclude that
/// nothing differs, and a gain whose p is at most 1 %, or the smallest that the blocks can give: by chance
/// each is said in at most 1 % of the trials. "Helped" needs, too, that the gain may be 1 (0.8 to 1.25: what
/// interpolated, rounded tables reach), and that no axis gets less than half for sure; else "helped in part",
/// or "overcorrected". The wrong sign of a single axis is said where its gain is surely below 0: the sum of
/// right and wrong axes may have any gain. "Did nothing": less than half of the correction arrives, for sure,
/// of no axis more, and the RMS does not differ, or by less than a quarter for sure.
/// @param on state in which the correction acts: A or B. @param angular figures are in rad.
OpenedTrial opened(const LabelledTrial& trial, char on, bool angular);

}  // namespace mm
