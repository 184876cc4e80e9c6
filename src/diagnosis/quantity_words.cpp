#include <algorithm>
#include <cmath>
#include <cstdio>

#include "base/text.h"
#include "base/tiny.h"
#include "base/units.h"
#include "diagnosis/wording.h"
#include "effects/owned.h"
#include "effects/registry.h"

namespace mm {
namespace {

std::string printed(const char* pattern, int digits, double value) {
  char text[64];
  std::snprintf(text, sizeof text, pattern, digits, value);
  // what is rounded to nothing has no sign
  const std::string number = text;
  return number.find_first_of("123456789") == std::string::npos && number.front() == '-' ? number.substr(1)
                                                                                         : number;
}

}  // namespace

std::string shortNumber(double value) {
  if (!std::isfinite(value)) return "-";
  const double size = std::abs(value);
  return size >= 1000.0 && size < 1e6 ? printed("%.*f", 0, value) : printed("%.*g", 3, value);
}

std::string expanded(double value, double std, const std::string& unit) {
  const std::string suffix = unit.empty() || unit == "1" ? "" : " " + unit;
  if (!std::isfinite(std) || !(std > 0.0)) return shortNumber(value) + suffix;
  const double wide = 2.0 * std;
  int place = static_cast<int>(std::floor(std::log10(wide)));
  if (wide / std::pow(10.0, place) >= 9.5) ++place;      // 0.096 is rounded to 0.10
  const bool two = wide / std::pow(10.0, place) < 2.95;  // one digit of 0.14 would be a third off
  const int decimals = (two ? 1 : 0) - place;
  if (decimals > 6 || decimals < -4 || std::abs(value) >= 1e7)
    return printed("%.*g", 6, value) + " ± " + printed("%.*g", two ? 2 : 1, wide) + suffix;
  return printed("%.*f", std::max(0, decimals), value) + " ± " +
         printed("%.*f", std::max(0, decimals), wide) + suffix;
}

double unitOf(bool angular) { return angular ? kArcsecond : kMicrometre; }
std::string nameOfUnit(bool angular) { return angular ? "arcsec" : "um"; }
std::string errorInWords(double value, bool angular) {
  return shortNumber(value / unitOf(angular)) + " " + nameOfUnit(angular);
}
bool positive(double value) { return std::isfinite(value) && value > 0.0; }

std::string withFactor(const std::string& text) {
  return text.find("±") == std::string::npos ? text : text + " (k = 2)";
}

std::string oddsInWords(double probability) {
  if (!std::isfinite(probability)) return "not known";
  const double p = std::clamp(probability, 0.0, 1.0);
  const bool likely = p >= 0.5;
  const double ratio = std::max(p, 1.0 - p) / std::max(kTiny, std::min(p, 1.0 - p));
  const auto said = [&](const std::string& about, const std::string& more, const std::string& less) {
    return about + (likely ? more + " to " + less : less + " to " + more);
  };
  if (ratio < 1.25) return "even";
  if (ratio < 1.75) return said("", "3", "2");
  if (ratio < 9.5) return said("", printed("%.*f", 0, ratio), "1");
  if (ratio > 1000.5) return said(likely ? "more than " : "less than ", "1000", "1");
  const double decade = std::pow(10.0, std::floor(std::log10(ratio)));
  double nearest = decade;
  for (const double step : {1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0})
    if (std::abs(std::log(ratio / (step * decade))) < std::abs(std::log(ratio / nearest)))
      nearest = step * decade;
  return said("about ", printed("%.*f", 0, nearest), "1");
}

std::string durationInWords(double seconds) {
  if (seconds < 90.0) return printed("%.*g", 2, seconds) + " s";
  if (seconds < 5400.0) return printed("%.*f", 0, seconds / 60.0) + " min";
  if (seconds < 172800.0) return printed("%.*g", 2, seconds / 3600.0) + " h";
  return printed("%.*g", 2, seconds / 86400.0) + " days";
}

std::string sizeInWords(const CandidateResult& c, bool angular) {
  const auto named = [&](const std::string& name) {
    const auto at = std::find_if(c.parameters.begin(), c.parameters.end(),
                                 [&](const NamedValue& v) { return v.name == name; });
    return at == c.parameters.end() ? nullptr : &*at;
  };
  const NamedValue *sine = named("S"), *cosine = named("K");
  if (sine != nullptr && cosine != nullptr && sine->unit == cosine->unit) {
    const double amplitude = std::hypot(sine->value, cosine->value);
    const double std =
        amplitude > 0.0 ? std::hypot(sine->value * sine->std, cosine->value * cosine->std) / amplitude : 0.0;
    return "amplitude " + expanded(amplitude, std, sine->unit);
  }
  // one constant; a second one that is a time says how fast, not how much
  const auto& p = c.parameters;
  if (p.size() == 1 || (p.size() == 2 && (p[1].unit == "s" || p[1].unit == "min" || p[1].unit == "h")))
    return expanded(p[0].value, p[0].std, p[0].unit);
  return c.size > 0.0 ? errorInWords(c.size, angular) + " RMS" : "";
}

std::string ownerOf(const EffectSpec& effect, const Diagnosis& d) {
  if (d.base.problem == nullptr) return "machine";
  const Session& session = d.base.problem->session();
  EffectSpec law = effect;
  const Owner owner = takeOwner(law);
  if (owner.fromSession > 1)
    return "session " + (session.recordings.size() < static_cast<std::size_t>(owner.fromSession)
                             ? std::to_string(owner.fromSession)
                             : session.recordings[static_cast<std::size_t>(owner.fromSession) - 1].source);
  if (!owner.stylus.empty()) return "stylus " + owner.stylus;
  const EffectPtr made = createEffect(law, d.base.problem->model().domain());
  if (made->nature().stage == Stage::kArtifact) return "artifact " + session.artifact.name;
  const auto& styli = session.artifact.styli;
  if (made->nature().stage == Stage::kProbe && styli.size() == 1) return "stylus " + styli.front().name;
  return "machine";
}

std::string foundInWords(const CandidateResult& c) {
  EffectSpec spec(c.effect.type);
  std::string found;
  for (const auto& [key, value] : c.effect.keys) {
    const std::string name = key.substr(0, key.rfind('_'));
    const auto p = std::find_if(c.parameters.begin(), c.parameters.end(),
                                [&](const NamedValue& v) { return v.name == name; });
    if (c.effect.text(key) == "unknown" && p != c.parameters.end())
      found += ", " + name + " " + expanded(p->value, p->std, p->unit);
    else
      spec.keys.emplace_back(key, value);
  }
  return inWords(spec) + found;
}

std::string movesInWords(double deviations, std::size_t moves) {
  if (moves == 0) return "no move within the machine's limits separates them";
  constexpr double kEnough = 3.0;              // standard deviations
  constexpr double kSmallestDeviation = 1e-3;  // of them: nobody measures a million times
  const std::string all = "the " + std::to_string(moves) + " proposed moves differ by " +
                          shortNumber(deviations) + " standard deviations";
  if (deviations >= kEnough) return all;
  const double times = std::ceil(std::pow(kEnough / std::max(deviations, kSmallestDeviation), 2));
  return all + (times > 100.0 ? ": no practicable number of repeats separates them"
                              : ": measure them " + shortNumber(times) + " times");
}

std::string variableInWords(const std::string& name, const std::string& unit) {
  if (name == "t") return "time";
  const std::string velocity = "_velocity";
  if (endsWith(name, velocity)) return "the velocity of " + name.substr(0, name.size() - velocity.size());
  return unit == "degC" ? "the temperature " + name : name;
}

std::string variablesInWords(const ProfileResult& profile) {
  std::string text;
  for (std::size_t i = 0; i < profile.variables.size(); ++i)
    text += (i == 0 ? "" : " and ") +
            variableInWords(profile.variables[i], i < profile.units.size() ? profile.units[i] : "");
  return text;
}

std::string inputInWords(const std::string& input) {
  return input.rfind("the ", 0) == 0 ? input : "the " + input;
}

bool isAngular(const Diagnosis& d, const std::string& direction) {
  if (!d.base.problem) return d.angular;
  const Machine& machine = d.base.problem->session().machine;
  const int joint = machine.findJoint(direction);
  if (joint < 0) return d.angular;
  return machine.joints()[static_cast<std::size_t>(joint)].kind == JointKind::kRotary;
}

}  // namespace mm
