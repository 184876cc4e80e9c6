#include "verification/verify_words.h"

#include <algorithm>
#include <cmath>

#include "base/format.h"
#include "base/text.h"
#include "base/units.h"
#include "diagnosis/wording.h"
#include "effects/effect_words.h"

namespace mm {
namespace {

constexpr double kTold = 0.25;    // a larger standard deviation of a share tells nothing
constexpr double kCertain = 3.3;  // standard deviations

std::string list(const std::vector<std::string>& words) {
  if (words.size() < 2) return words.empty() ? std::string() : words.front();
  return joined({words.begin(), words.end() - 1}, ", ") + " and " + words.back();
}

std::string stateInWords(AxisState state, bool loaded, bool several) {
  const std::string is = several ? "are " : "is ";
  switch (state) {
    case AxisState::kNotCorrected:
      return loaded ? is + "not corrected"
                    : (several ? "do" : "does") + std::string(" not have the error that was calibrated");
    case AxisState::kWrongSign:
      return several ? "have the wrong sign" : "has the wrong sign";
    case AxisState::kTwice:
      return is + (loaded ? "corrected twice" : "twice as far off as calibrated");
    case AxisState::kCorrected:
      break;
  }
  return is + (loaded ? "corrected" : "as calibrated");
}

/// "9.81 -> 0.42 um at 50 fresh points (k = 2: ±0.31, ±0.06)"
std::string figuresInWords(const Verification& v) {
  const double unit = v.angular ? kArcsecond : kMicrometre;
  const auto digits = [&](const Figure& f) {
    const double wide = 2.0 * f.std / unit;
    return wide > 0.0 ? std::clamp(1 - static_cast<int>(std::floor(std::log10(wide))), 0, 4) : 3;
  };
  const int places = std::min(3, std::max(digits(v.before), digits(v.after)));
  return format("%.*f -> %.*f %s at %d fresh points (k = 2: ±%.*f, ±%.*f)", places, v.before.rms / unit,
                places, v.after.rms / unit, v.angular ? "arcsec" : "um", v.observations, places,
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
  return list(all) + (more > 0 ? " and " + std::to_string(more) + " more" : "");
}

std::string headOf(const Verification& v, const std::vector<std::string>& names) {
  const std::string figures = figuresInWords(v);
  if (v.finding == "too_small")
    return "no change: the correction is too small to be seen at these points, " + figures;
  if (v.finding == "corrected" && !v.drifted) {
    if (v.verdict == VerifyVerdict::kHelped) return (v.loaded ? "it helped: " : "it helps: ") + figures;
    return "as it should be, but no better: the correction is too small to show in the figure, " + figures;
  }
  if (v.finding == "corrected")
    return std::string(v.loaded ? "it is loaded, " : "it still fits in part, ") +
           "but the machine has drifted since: " + figures;
  if (v.finding == "not_corrected")
    return v.loaded
               ? "no change: is it loaded? " + figures
               : "the machine does not have these errors, applied it gets worse: was it corrected already "
                 "while this was measured (--loaded)? " +
                     figures;
  if (v.finding == "wrong_sign")
    return v.loaded ? "sign is wrong: it got twice as bad, " + figures
                    : "sign is wrong: the machine errs to the other side, applied it gets worse, " + figures;
  if (v.finding == "corrected_twice")
    return v.loaded ? "corrected twice: the errors are as large as before, to the other side, " + figures
                    : "the errors are twice as large as calibrated, " + figures;
  const std::string kind = v.finding == "exchanged" ? "axes are exchanged: " : "not every axis alike: ";
  return kind + inWords(v.hypothesis, names, v.loaded) + ", " + figures;
}

}  // namespace

std::string nameOf(VerifyVerdict verdict) {
  switch (verdict) {
    case VerifyVerdict::kHelped:
      return "helped";
    case VerifyVerdict::kNoChange:
      return "no_change";
    case VerifyVerdict::kWorse:
      return "worse";
    case VerifyVerdict::kMixed:
      break;
  }
  return "mixed";
}

std::string inWords(const LoadedHow& hypothesis, const std::vector<std::string>& axes, bool loaded) {
  if (hypothesis.exchanges.size() == 2) {
    const Exchange& e = hypothesis.exchanges.front();
    const std::string both =
        axes[static_cast<std::size_t>(e.of)] + " and " + axes[static_cast<std::size_t>(e.on)];
    return both + (e.entered ? " have each other's table" : " have each other's correction");
  }
  if (hypothesis.exchanges.size() == 1) {
    const Exchange& e = hypothesis.exchanges.front();
    const std::string of = axes[static_cast<std::size_t>(e.of)], on = axes[static_cast<std::size_t>(e.on)];
    return on + " has the " + (e.entered ? "table" : "correction") + " of " + of + ", and " + of +
           " has none";
  }
  std::vector<std::string> parts;
  for (const AxisState state :
       {AxisState::kNotCorrected, AxisState::kWrongSign, AxisState::kTwice, AxisState::kCorrected}) {
    std::vector<std::string> names;
    for (std::size_t a = 0; a < axes.size(); ++a)
      if (hypothesis.axes[a] == state) names.push_back(axes[a]);
    if (!names.empty()) parts.push_back(list(names) + " " + stateInWords(state, loaded, names.size() > 1));
  }
  return joined(parts, ", ");
}

std::string inWords(const RemainingShare& share) {
  if (!(share.std < kTold)) return "not told by these points";
  const auto near = [&](double value) {
    return std::abs(share.remaining - value) < std::max(kCertain * share.std, 0.05);
  };
  const auto excludes = [&](double value) {
    return std::abs(share.remaining - value) > kCertain * share.std;
  };
  if (near(0.0) && excludes(1.0)) return "corrected";
  if (near(1.0) && excludes(0.0)) return "not corrected";
  if (near(2.0)) return "wrong sign";
  if (near(-1.0)) return "corrected twice";
  return format("%.0f %% remain", 100.0 * share.remaining);
}

std::string sentenceOf(const Verification& v) {
  std::vector<std::string> names;
  for (const RemainingOfAxis& axis : v.axes) names.push_back(axis.axis);
  std::string text = headOf(v, names);
  if (!v.changed.empty()) {
    text += std::string(v.finding == "corrected" ? "; " : "; and the machine has drifted since: ") +
            "changed since the calibration: " + changesInWords(v);
  } else if (v.drifted) {
    text += v.finding == "corrected"
                ? "; no effect of the calibration says how"
                : "; and the machine has drifted since, in a way that no effect of the calibration says";
  }
  if (v.drifted) text += "; calibrate again, mm diagnose says what is new";
  if (!v.rivals.empty()) text += "; not excluded by these points: " + v.rivals.front().inWords;
  return text;
}

}  // namespace mm
