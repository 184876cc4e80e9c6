#include "verification/calibration_changes.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/format.h"
#include "base/quantity_words.h"
#include "base/text.h"
#include "base/units.h"
#include "effects/effect_words.h"
#include "machine/machine_fit.h"
#include "workflow/recalibration.h"

namespace mm {
namespace {

const EffectSpec* sameIn(const Calibration& c, const EffectSpec& effect) {
  for (const EffectSpec& other : c.effects)
    if (sameEffect(other, effect, c.domain)) return &other;
  return nullptr;
}

const Calibration::Value* valueIn(const Calibration& c, const EffectSpec& effect, const std::string& name) {
  for (const Calibration::Value& v : c.values)
    if (v.name == name && sameEffect(c.effects[v.effect], effect, c.domain)) return &v;
  return nullptr;
}

ParameterChange changeOf(const Calibration& a, const Calibration::Value& before, const Calibration& b,
                         const Calibration::Value& after) {
  ParameterChange change;
  change.effect = a.effects[before.effect];
  change.name = before.name;
  change.unit = before.unit;
  change.before = before.value * before.toUnit;
  change.beforeStd = before.std * before.toUnit;
  change.after = after.value * before.toUnit;
  change.afterStd = after.std * before.toUnit;
  change.change = change.after - change.before;
  change.std = std::hypot(change.beforeStd, change.afterStd);
  change.comparable = meansTheSame(change.effect, a, b);
  change.pValue = change.std > 0.0 ? std::erfc(std::abs(change.change) / (change.std * std::sqrt(2.0))) : 1.0;
  return change;
}

std::string sentenceOf(const CalibrationChanges& c) {
  std::vector<std::string> said;
  std::size_t significant = 0;
  for (const ParameterChange& p : c.parameters) {
    if (!p.significant) continue;
    ++significant;
    if (said.size() < 4)
      said.push_back(inWords(p.effect) + ", " + p.name + " " + (p.change >= 0.0 ? "+" : "") +
                     expanded(p.change, p.std, p.unit));
  }
  std::string text =
      c.sameSession ? "both are from the same session: the model or the fit differs, not the machine, so no "
                      "change is evaluated"
      : significant == 0 ? "no parameter changed significantly"
                         : std::to_string(significant) + " of " + std::to_string(c.parameters.size()) +
                               " parameters changed significantly: " + joined(said, "; ");
  if (significant > said.size()) text += " and others";
  if (!c.onlyBefore.empty()) text += "; taken out: " + listInWords(c.onlyBefore);
  if (!c.onlyAfter.empty()) text += "; added: " + listInWords(c.onlyAfter);
  text += format("; at the tip %.3g um RMS, at most %.3g um (%.2g um RMS by the uncertainties alone)",
                 c.rms / kMicrometre, c.largest / kMicrometre, c.byChance / kMicrometre);
  return text;
}

}  // namespace

CalibrationChanges changesBetween(const Calibration& before, const Calibration& after) {
  const Machine machine(before.urdf, before.machineName);
  const std::string difference =
      differenceOf(machine, Machine(after.urdf, after.machineName), "in calibration '" + after.id + "'");
  if (!difference.empty())
    throw InputError("calibrations '" + before.id + "' and '" + after.id +
                     "' are of different machines: " + difference);
  CalibrationChanges changes;
  changes.before = before.id;
  changes.after = after.id;
  changes.beforeTime = before.created;
  changes.afterTime = after.created;
  for (const Calibration::Value& v : before.values) {
    const EffectSpec& effect = before.effects[v.effect];
    const Calibration::Value* other = valueIn(after, effect, v.name);
    if (other == nullptr || v.fixed || other->fixed) continue;
    changes.parameters.push_back(changeOf(before, v, after, *other));
  }
  changes.sameSession = !before.sessionHash.empty() && before.sessionHash == after.sessionHash;
  if (changes.sameSession) {
    for (ParameterChange& p : changes.parameters) p.std = p.pValue = std::nan("");
  } else {
    std::sort(changes.parameters.begin(), changes.parameters.end(),
              [](const ParameterChange& a, const ParameterChange& b) { return a.pValue < b.pValue; });
    std::vector<ParameterChange*> asked;
    for (ParameterChange& p : changes.parameters)
      if (p.comparable) asked.push_back(&p);
    correctForMany(asked);
  }
  for (const EffectSpec& effect : before.effects)
    if (sameIn(after, effect) == nullptr) changes.onlyBefore.push_back(effect);
  for (const EffectSpec& effect : after.effects)
    if (sameIn(before, effect) == nullptr) changes.onlyAfter.push_back(effect);
  static_cast<TipChange&>(changes) = tipChange(before, after);
  changes.inWords = sentenceOf(changes);
  return changes;
}

CalibrationChanges changesBetween(const Session& before, const Session& after, const Calibration& calibration,
                                  CalibrateOptions options) {
  options.method = Method::kLeastSquares;
  const auto fitted = [&](const Session& session) {
    checkMachine(calibration, session);
    const CalibrationResult result = calibrate(session, modelOf(calibration), options, valuesOf(calibration));
    Calibration found = toCalibration(result, calibration.machineName);
    found.id = session.source;
    return found;
  };
  return changesBetween(fitted(before), fitted(after));
}

}  // namespace mm
