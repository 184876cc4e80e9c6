#pragma once
#include "base/units.h"
#include "diagnosis/diagnose.h"
#include "diagnosis/wording.h"

namespace mm::test_support {

// Diagnoses that nobody measured, to see how they are told.

inline EffectSpec backlash(const std::string& axis) { return EffectSpec("backlash").set("axis", axis); }
inline EffectSpec growth(const std::string& direction) {
  return EffectSpec("thermal_growth").set("direction", direction).set("sensor", "bed");
}

/// Play of x: 2.06 um, known to 0.03 um, 0.93 -> 0.32 um held out.
inline CandidateResult play() {
  CandidateResult c;
  c.effect = backlash("x");
  c.parameters = {{"gap", "um", 2.06, 0.03}};
  c.gain = 183.0;
  c.odds = 0.999;
  c.pValue = 1e-40;
  c.heldOutBefore = 0.93e-6;
  c.heldOutAfter = 0.32e-6;
  c.size = 0.87e-6;
  c.cause = "play in the drive";
  c.remedy = "preload or replace the nut; approach from one side";
  return c;
}

inline Confusable rival(const EffectSpec& effect, double odds, const std::string& moves = "") {
  return {effect, 1.1, odds, false, "", moves, moves.empty() ? 0 : 1};
}

/// An error along z of 1.41 um at one end of x.
inline ProfileResult bump() {
  ProfileResult p;
  p.effect = EffectSpec("profile").set("direction", "z").set("variable", "x");
  p.direction = "z";
  p.variables = {"x"};
  p.units = {"mm"};
  p.gain = 60.0;
  p.odds = 0.9999;
  p.heldOutBefore = 0.93e-6;
  p.heldOutAfter = 0.33e-6;
  for (int i = 0; i <= 16; ++i) {
    const double x = -16.0 + 2.0 * i;
    p.curve.push_back({x, 1.41 * x * x / 256.0 - 0.5, 0.1 + 0.01 * i});
  }
  return p;
}

/// x drifts by 0.4 um in 20 minutes.
inline DriftResult wander() { return {"x", 0.4e-6, 1200.0, {}, ""}; }

/// A verdict with noise of 0.31 um beside a declared repeatability of 0.3 um; it has its sentence by `told`.
inline Diagnosis verdict(Verdict what) {
  Diagnosis d;
  d.verdict = what;
  d.base.repeatability = 0.3e-6;
  d.base.repeatabilityFrom = "declared";
  d.base.figures.rms = 0.92e-6;
  d.base.figures.heldOutRms = 0.93e-6;
  d.noise = 0.31e-6;
  d.noiseStd = 0.008e-6;
  d.heldOutBefore = 0.93e-6;
  d.heldOut = what == Verdict::kExplained || what == Verdict::kScatter ? 0.93e-6 : 0.32e-6;
  return d;
}

inline Diagnosis told(Diagnosis d) {
  d.sentence = sentenceOf(d);
  return d;
}

}  // namespace mm::test_support
