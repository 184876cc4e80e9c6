#pragma once
#include <set>
#include <string>

#include "diagnosis/diagnose.h"
#include "uncatalogued.h"

namespace mm {

/// Names of the variables in the text of a `formula`: no functions, constants or unknowns (k1, k2 …).
std::set<std::string> variablesOfFormula(const std::string& formula);

/// Whether a profile or a formula is made of just the variables on which an error truly depends. Speed and
/// direction of travel of a joint are its velocity; the tip's speed and the approach are made of velocities
/// of any joints.
bool justTheVariables(const std::set<std::string>& variables, const UncataloguedTruth& truth);

/// What was said of an error that no effect of the catalogue describes.
struct UnknownJudgement {
  /// Held-out RMS, over the noise, up to which it counts as explained.
  static constexpr double kExplained = 1.15;

  UncataloguedTruth truth;
  bool profile = false;           // one was given
  bool byDrift = false;           // it depends on time alone, and was told as drift along its direction
  bool justTheVariables = false;  // of the first profile, or of all together, or of the drift
  bool rightDirection = false;    // of the first profile, or of the drift
  double heldOut = 0.0;           // RMS with the profiles or the drift, over the noise
  bool explained = false;
  std::string formula;        // the first; empty: none, which is no fault
  bool formulaRight = false;  // it is made of just the variables
};

/// @param noise m (rad for angular sessions).
UnknownJudgement judge(const Diagnosis& diagnosis, const UncataloguedTruth& truth, double noise);

}  // namespace mm
