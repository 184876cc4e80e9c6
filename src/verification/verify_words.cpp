#include "verification/verify_words.h"

#include <algorithm>
#include <cmath>

#include "base/format.h"
#include "base/quantity_words.h"
#include "base/text.h"
#include "effects/effect_words.h"

namespace mm {
namespace {

constexpr double kCertain = 3.3;  // standard deviations

/// Of one or several axes, by the order of AxisState.
std::string stateInWords(AxisState state, bool loaded, bool several) {
  struct Words {
    const char *one, *several;
  };
  static constexpr Words kLoaded[] = {{"is corrected", "are corrected"},
                                      {"is not corrected", "are not corrected"},
                                      {"has the wrong sign", "have the wrong sign"},
                                      {"is corrected twice", "are corrected twice"}};
  static constexpr Words kRaw[] = {
      {"is as calibrated", "are as calibrated"},
      {"does not have the error that was calibrated", "do not have the error that was calibrated"},
      {"has the wrong sign", "have the wrong sign"},
      {"is twice as far off as calibrated", "are twice as far off as calibrated"}};
  const Words& words = (loaded ? kLoaded : kRaw)[static_cast<std::size_t>(state)];
  return several ? words.several : words.one;
}

/// "9.81 -> 0.42 um at 50 fresh points (k = 2: ±0.31, ±0.06)"
std::string figuresInWords(const Verification& v) {
  const double unit = unitOf(v.angular);
  const auto digits = [&](const Figure& f) {
    const double wide = 2.0 * f.std / unit;
    return wide > 0.0 ? std::clamp(1 - static_cast<int>(std::floor(std::log10(wide))), 0, 4) : 3;
  };
  const int places = std::min(3, std::max(digits(v.before), digits(v.after)));
  return format("%.*f -> %.*f %s at %d fresh points (k = 2: ±%.*f, ±%.*f)", places, v.before.rms / unit,
                places, v.after.rms / unit, nameOfUnit(v.angular).c_str(), v.observations, places,
                2.0 * v.before.std / unit, places, 2.0 * v.after.std / unit);
}

std::string changesInWords(const Verification& v) {
  std::vector<std::string> all;
  for (const ChangedEffect& c : v.changed) {
    std::vector<std::string> parts;
    for (const ChangedEffect::Parameter& p : c.parameters)
      parts.push_back(p.name + " " + (p.change >= 0.0 ? "+" : "") + expanded(p.change, p.std, p.unit));
    if (all.size() < 3) all.push_back(inWords(c.effect) + " (" + joined(parts, ", ") + ")");
  }
  const std::size_t more = v.changed.size() - all.size();
  return enumerated(all) + (more > 0 ? " and " + std::to_string(more) + " more" : "");
}

std::string noChangeInWords(const Verification& v, const std::string& figures) {
  if (v.finding == "too_small")
    return v.loaded ? "no change visible: these points cannot show whether it is loaded, " + figures
                    : "no change: the correction is too small to be seen at these points, " + figures;
  if (v.finding == "not_corrected")
    return v.loaded ? "no change: is it loaded? " + figures
                    : "no change: the machine does not have these errors; was it corrected already while "
                      "this was measured (--loaded)? " +
                          figures;
  if (v.finding == "corrected_twice")
    return "no change: corrected twice, the errors are as large as before with the opposite sign, " + figures;
  return std::string("no change: ") + (v.loaded ? "it is loaded" : "the errors are as calibrated") +
         ", but the correction is too small to show in the figure, " + figures;
}

/// Of tables that are alike and the external offsets beside them.
std::string besideInWords(const LoadedHow& how) {
  const AxisState tables = how.state(), offsets = *how.offsets;
  if (tables == AxisState::kNotCorrected && offsets == tables)
    return "neither the tables nor the external offsets are loaded";
  if (tables == offsets) return std::string("the tables and the external offsets ") + factsOf(tables).loaded;
  // "are not" needs what they are not.
  if (tables == AxisState::kNotCorrected && offsets != AxisState::kCorrected)
    return std::string("the tables are not loaded, the external offsets ") + factsOf(offsets).loaded;
  if (tables == AxisState::kNotCorrected) return "the external offsets are loaded, the tables are not";
  return std::string("the tables ") + factsOf(tables).loaded + ", the external offsets " +
         (offsets == AxisState::kNotCorrected && tables != AxisState::kCorrected ? "are not loaded"
                                                                                 : factsOf(offsets).loaded);
}

/// What these points tell of the external offsets, where the verdict has not said so.
std::string offsetsInWords(const Verification& v) {
  if (!v.offsets || v.finding == "too_small") return {};
  if (!v.tablesSeen) return "; these points show the external offsets alone, the tables are too small";
  if (!v.hypothesis.offsets) return "; these points cannot show whether the external offsets are loaded";
  return v.finding == "corrected" ? "; " + besideInWords(v.hypothesis) : std::string();
}

/// What is loaded how, of a correction that neither helps nor leaves everything as it is.
std::string causeInWords(const Verification& v, const std::vector<std::string>& names) {
  if (v.finding == "wrong_sign")
    return v.loaded ? "sign is wrong" : "sign is wrong: the machine's error has the opposite sign";
  if (v.finding == "too_small")
    return v.loaded ? "these points cannot show whether it is loaded"
                    : "the correction is too small to be judged axis by axis";
  if (v.finding == "not_corrected")
    return v.loaded ? "it is not loaded"
                    : "the machine does not have these errors (was it corrected already while this was "
                      "measured: --loaded?)";
  if (v.finding == "corrected_twice")
    return v.loaded ? "corrected twice: the errors are there with the opposite sign"
                    : "the errors are twice as large as calibrated";
  if (v.finding == "corrected") return v.loaded ? "it is loaded" : "it still fits in part";
  if (v.hypothesis.alike() && v.hypothesis.offsets) return besideInWords(v.hypothesis);
  return (v.finding == "exchanged" ? "axes are exchanged: " : "not every axis alike: ") +
         inWords(v.hypothesis, names, v.loaded);
}

std::string moreLeftInWords(const Verification& v) {
  const double unit = unitOf(v.angular);
  return format(
      "; but %.3g %s remain, while the calibration left %.3g in its own session (held out): the machine may "
      "have changed, or be less repeatable; mm diagnose shows what is new",
      v.unforeseen / unit, nameOfUnit(v.angular).c_str(), v.calibratedRms / unit);
}

std::string headOf(const Verification& v, const std::vector<std::string>& names) {
  const std::string figures = figuresInWords(v);
  if (v.verdict == VerifyVerdict::kHelped)
    return (v.loaded ? "it helped: " : "it helps: ") + figures +
           (v.finding == "too_small" ? "; these points do not show which axis" : "");
  if (v.verdict == VerifyVerdict::kNoChange) return noChangeInWords(v, figures);
  std::string text = causeInWords(v, names);
  if (v.verdict == VerifyVerdict::kWorse)
    text += v.loaded ? ", the errors rose" : ", applying it makes it worse";
  else if (v.finding == "corrected" || v.finding == "too_small")
    text += ", but the machine has drifted since";
  else if (v.better)
    text += ", yet the error is smaller than without it";
  return text + ": " + figures;
}

/// Whether an effect that is said to have changed is there as if nobody corrected it.
bool mayBeNotCarried(const Verification& v) {
  const auto whole = [&](const ChangedEffect& changed) {
    return std::any_of(v.effects.begin(), v.effects.end(), [&](const RemainingOfEffect& effect) {
      return effect.effect == changed.effect && effect.inWords == "not corrected";
    });
  };
  return v.loaded && v.target.empty() && std::any_of(v.changed.begin(), v.changed.end(), whole);
}

/// What the tables of an export leave by their nature.
std::string notCarriedInWords(const Verification& v) {
  constexpr double kMostly = 0.5;   // share of an effect
  constexpr double kNothing = 0.1;  // of the noise
  if (v.target.empty() || v.notCarried < kNothing * v.noise) return {};
  std::vector<std::string> effects;
  for (const RemainingOfEffect& effect : v.effects)
    if (effect.notCarried > kMostly && effect.size > kNothing * v.noise)
      effects.push_back(inWords(effect.effect));
  return std::string("; the tables ") + (v.offsets ? "and offsets " : "") + "for " + v.target +
         format(" do not carry %.3g %s of it", v.notCarried / unitOf(v.angular),
                nameOfUnit(v.angular).c_str()) +
         (effects.empty() ? "" : " (" + enumerated(effects) + ")") + ", which is not drift";
}

}  // namespace

std::string nameOf(VerifyVerdict verdict) {
  static constexpr const char* kNames[] = {"helped", "no_change", "worse", "mixed"};
  return kNames[static_cast<std::size_t>(verdict)];
}

VerifyVerdict verdictOf(const Verification& v, double improvement) {
  const bool better = improvement > kFiguresDiffer, worse = improvement < -kFiguresDiffer;
  const bool seen = v.finding != "too_small";
  // Of a correction that these points cannot show nobody knows whether it is loaded, nor what it did.
  if (!seen && v.loaded && !v.drifted) return VerifyVerdict::kNoChange;
  if (worse) return VerifyVerdict::kWorse;
  if ((!seen || v.finding == "corrected") && !v.drifted)
    return better ? VerifyVerdict::kHelped : VerifyVerdict::kNoChange;
  const bool asBefore = v.finding == "not_corrected" || (v.loaded && v.finding == "corrected_twice");
  return asBefore && !better ? VerifyVerdict::kNoChange : VerifyVerdict::kMixed;
}

std::string whyKept(const Verification& v) {
  if (v.loaded && v.finding == "too_small") return "kept, these points cannot show whether it is loaded";
  return v.better ? "kept, the machine is more accurate with it than without" : "";
}

std::string inWords(const LoadedHow& hypothesis, const std::vector<std::string>& axes, bool loaded) {
  if (hypothesis.offsets) {
    if (hypothesis.alike()) return besideInWords(hypothesis);
    LoadedHow tables = hypothesis;
    tables.offsets.reset();
    return inWords(tables, axes, loaded) + ", the external offsets " +
           (hypothesis.offsets == AxisState::kNotCorrected ? "are not loaded"
                                                           : factsOf(*hypothesis.offsets).loaded);
  }
  if (hypothesis.exchanges.size() == 2) {
    const Exchange& e = hypothesis.exchanges.front();
    const std::string both = axes[e.of] + " and " + axes[e.on];
    return both + (e.entered ? " have each other's table" : " have each other's correction");
  }
  if (hypothesis.exchanges.size() == 1) {
    const Exchange& e = hypothesis.exchanges.front();
    const std::string of = axes[e.of], on = axes[e.on];
    return on + " has the " + (e.entered ? "table" : "correction") + " of " + of + ", and " + of +
           " has none";
  }
  std::vector<std::string> parts;
  for (const AxisState state :
       {AxisState::kNotCorrected, AxisState::kWrongSign, AxisState::kTwice, AxisState::kCorrected}) {
    std::vector<std::string> names;
    for (std::size_t a = 0; a < axes.size(); ++a)
      if (hypothesis.axes[a] == state) names.push_back(axes[a]);
    if (!names.empty())
      parts.push_back(enumerated(names) + " " + stateInWords(state, loaded, names.size() > 1));
  }
  return joined(parts, ", ");
}

std::string inWords(const RemainingShare& share) {
  constexpr double kNear = 0.05, kHalfWay = 0.5;  // to the next state
  const double wide = std::max(kCertain * share.std, kNear);
  const double least = share.remaining - wide, most = share.remaining + wide;
  bool between = true;
  for (const AxisState state :
       {AxisState::kCorrected, AxisState::kNotCorrected, AxisState::kWrongSign, AxisState::kTwice}) {
    const StateFacts& facts = factsOf(state);
    if (!(least <= facts.remaining && facts.remaining <= most)) continue;
    between = false;
    const bool noneBelow = state == AxisState::kTwice, noneAbove = state == AxisState::kWrongSign;
    if ((noneBelow || least > facts.remaining - kHalfWay) && (noneAbove || most < facts.remaining + kHalfWay))
      return facts.words;
  }
  if (!between || wide > kHalfWay) return "these points cannot tell whether it is corrected";
  return share.remaining < 0.0 ? format("corrected by %.0f %%", 100.0 * (1.0 - share.remaining))
                               : format("%.0f %% remain", 100.0 * share.remaining);
}

std::string inWords(const RemainingOfEffect& effect) {
  constexpr double kSome = 0.1;
  if (effect.notCarried > 1.0 - kSome) return "not in any table";
  const RemainingShare& carried = effect;
  return inWords(carried) +
         (effect.notCarried > kSome ? format(", %.0f %% of it in no table", 100.0 * effect.notCarried) : "");
}

std::string sentenceOf(const Verification& v) {
  std::vector<std::string> names;
  for (const RemainingOfAxis& axis : v.axes) names.push_back(axis.axis);
  std::string text = headOf(v, names);
  const bool told = text.find("the machine has drifted since") != std::string::npos;
  if (v.drifted)
    text += (told ? std::string("; ") : std::string("; and the machine has drifted since: ")) +
            (v.changed.empty() ? "no effect of the calibration explains how"
                               : "changed since the calibration: " + changesInWords(v));
  text += offsetsInWords(v) + notCarriedInWords(v);
  if (v.moreLeft && !v.drifted) text += moreLeftInWords(v);
  if (v.drifted && mayBeNotCarried(v))
    text += "; if tables of mm export were loaded, which may carry less, name them with --export";
  if (v.drifted) text += "; calibrate again, mm diagnose shows what is new";
  if (!v.rivals.empty()) text += "; not excluded by these points: " + v.rivals.front().inWords;
  return text;
}

}  // namespace mm
