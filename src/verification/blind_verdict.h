#pragma once
#include <limits>
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
};

/// The blocks of a trial in the order of time, and what is amiss with them.
struct TrialBlocks {
  std::string trial;                      // as TrialBlock::trial
  int planned = 0;                        // blocks
  std::vector<TrialBlockFigures> blocks;  // that are judged
  std::vector<std::string> remarks;       // blocks that are missing, incomplete, measured twice
  bool angular = false;                   // in rad: there are no residuals in m
  double predicted = 0.0;                 // m (rad): RMS of the predicted error at these points
};

/// A quantity in the two states: least squares with a level, a linear trend in time and a step between the
/// states, a block each. Half-widths are of 99 % (Student's t); infinite where the blocks are too few.
struct StatesCompared {
  double a = 0.0, b = 0.0;  // in the middle of the trial
  double aHalf = 0.0, bHalf = 0.0;
  double difference = 0.0, half = std::numeric_limits<double>::infinity();  // b - a
  double p = 1.0;  // two-sided, of a step so large over all orders that may have been drawn
};

/// A trial whose key is not open: what differs between A and B, to either side.
struct LabelledTrial {
  StatesCompared remaining, logRms;  // of TrialBlockFigures; the natural logarithm
  double smallestP = 1.0;            // that so many blocks can give
  int blocksA = 0, blocksB = 0;
};

enum class TrialVerdict { kHelped, kDidNothing, kWrongSign, kWorse, kCannotTell };
std::string nameOf(TrialVerdict verdict);  ///< "helped", "did_nothing", "wrong_sign", "worse", "cannot_tell"

/// A figure with the ends of its 99 % interval.
struct TrialFigure {
  double value = 0.0, lower = 0.0, upper = 0.0;
};

/// The same with the key.
struct OpenedTrial {
  TrialVerdict verdict = TrialVerdict::kCannotTell;
  TrialFigure gain;  // share of the predicted correction that arrives: 1 all, 0 nothing, -1 wrong sign
  TrialFigure without, with;  // m (rad): RMS with the correction off and on (geometric mean of the blocks)
  TrialFigure ratio;          // with / without
  double gainP = 1.0, rmsP = 1.0;
  int blocksWanted = 0;  // cannot tell: of a trial that could; 0: none of reasonable size
  std::string inWords;
};

/// The blocks of a session of a blind trial. No parameter of the calibration is refitted. A block with less
/// than half of the usual measurements is left out; one that was measured again counts once, as the mean.
/// @param options for the session's own unknowns; `progress` is told of each block. @throw InputError:
/// another machine, no trial or two, the calibration predicts nothing at these points. Cancelled.
TrialBlocks trialBlocks(const Session& session, const Calibration& calibration,
                        const CalibrateOptions& options);

/// Compares the states without knowing in which of them the correction acts.
LabelledTrial compareStates(const std::vector<TrialBlockFigures>& blocks);

/// Says what it means. "Helped" and "wrong sign" need a gain and an RMS whose 99 % intervals exclude that
/// nothing differs, and a gain whose p is at most 1 %, or the smallest that the blocks can give: by chance
/// they are said in at most 1 % of the trials, together. "Did nothing": less than half of the correction
/// arrives, for sure, and the RMS does not differ, or by less than a quarter for sure.
/// @param on state in which the correction acts: A or B. @param angular figures are in rad.
OpenedTrial opened(const LabelledTrial& trial, char on, bool angular);

}  // namespace mm
