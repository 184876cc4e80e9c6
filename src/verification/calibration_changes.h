#pragma once
#include <algorithm>
#include <string>
#include <vector>

#include "calibration_file/calibration.h"
#include "estimation/calibrate.h"
#include "session/session.h"

namespace mm {

constexpr double kSignificant = 0.01;  ///< p below which a change of a parameter counts as one

/// Holm's step-down correction (1979) of p-values that were asked together: the smallest times the number
/// asked, the next times one less … Sets their pValue and significant.
template <typename T>
void correctForMany(std::vector<T*> asked) {
  std::sort(asked.begin(), asked.end(), [](const T* a, const T* b) { return a->pValue < b->pValue; });
  double before = 0.0, left = asked.size();
  for (T* one : asked) {
    before = one->pValue = std::min(1.0, std::max(before, left * one->pValue));
    left -= 1.0;
    one->significant = one->pValue < kSignificant;
  }
}

/// One parameter in two calibrations. In its unit for people.
struct ParameterChange {
  EffectSpec effect;
  std::string name, unit;
  double before = 0.0, beforeStd = 0.0, after = 0.0, afterStd = 0.0;  // NaN: not in that calibration
  double change = 0.0, std = 0.0;
  /// Of such a change by chance, corrected for all parameters asked (Holm 1979). NaN: not asked, both are of
  /// one session.
  double pValue = 1.0;
  bool significant = false;  // pValue below 0.01
  /// The effect counts from the observed range, and the ranges differ: the same number means another error.
  bool comparable = true;
};

/// How far two calibrations differ in what they say of the tip: over the volume that both hold for, less a
/// displacement and a rotation of everything.
struct TipChange {
  double rms = 0.0, largest = 0.0;  // m
  double byChance = 0.0;            // m: RMS that the uncertainties of both alone would make
};

/// What differs between two calibrations of one machine.
struct CalibrationChanges : TipChange {
  std::string before, after;  // ids or files
  std::string beforeTime, afterTime;
  /// Both were fitted to the same measurements: their estimates have the same noise in them, the standard
  /// deviation of a change is not known from theirs, and no change is judged.
  bool sameSession = false;
  std::vector<ParameterChange> parameters;  // most significant first
  std::vector<EffectSpec> onlyBefore, onlyAfter;
  std::string inWords;
};

/// Whether the parameters of an effect mean the same error in both calibrations: one that counts from the
/// observed range (Legendre polynomials) does not where the ranges differ. Found by trial at states within
/// both ranges; to a thousandth of the error.
bool meansTheSame(const EffectSpec& effect, const Calibration& a, const Calibration& b);

/// Over a grid of the volume that both calibrations hold for, both directions of travel; everything else in
/// the middle of the range of `a`. Zero where the ranges have nothing in common.
TipChange tipChange(const Calibration& a, const Calibration& b);

/// Compares parameter by parameter (of two sessions they are independent estimates: the variances add), and
/// at the tip.
/// @throw InputError: of different machines.
CalibrationChanges changesBetween(const Calibration& before, const Calibration& after);

/// What changed between two sessions: the model of the calibration is fitted to each of them, in the
/// calibration's own ranges. @throw as calibrate.
CalibrationChanges changesBetween(const Session& before, const Session& after, const Calibration& calibration,
                                  CalibrateOptions options);

}  // namespace mm
