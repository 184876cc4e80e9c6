#pragma once
#include "calibration_file/calibration.h"

namespace mm {

/// Whether the parameters of an effect mean the same error in both calibrations: one that counts from the
/// observed range (Legendre polynomials) does not where the ranges differ. Found by trial at states within
/// both ranges; to a thousandth of the error.
bool meansTheSame(const EffectSpec& effect, const Calibration& a, const Calibration& b);

/// How far two calibrations differ in what they say of the tip.
struct TipChange {
  double rms = 0.0, largest = 0.0;  // m, less a displacement and a rotation of the whole workpiece
  double byChance = 0.0;            // m: RMS that the uncertainties of both alone would make
};
/// Over a grid of the volume that both calibrations hold for, both directions of travel; everything else in
/// the middle of the range of `a`. Zero where the ranges have nothing in common.
TipChange tipChange(const Calibration& a, const Calibration& b);

}  // namespace mm
