#include <algorithm>
#include <cmath>

#include "base/text.h"
#include "diagnosis/wording.h"
#include "effects/owned.h"
#include "effects/registry.h"

namespace mm {

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
  constexpr std::size_t kFew = 4;
  std::string each;
  for (const NamedValue& v : p)
    if (p.size() <= kFew && v.std > 0.0 && std::abs(v.value) > 2.0 * v.std)
      each += (each.empty() ? "" : ", ") + spaced(v.name) + " " + expanded(v.value, v.std, v.unit);
  if (!each.empty()) return each;
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

int repeatsOfMoves(double deviations, std::size_t moves) {
  constexpr double kEnough = 3.0;  // standard deviations
  constexpr double kMost = 100.0;  // repeats: nobody measures more
  if (moves == 0 || !(deviations > kEnough / std::sqrt(kMost))) return 0;
  return std::max(1, static_cast<int>(std::ceil(std::pow(kEnough / deviations, 2))));
}

std::string movesInWords(double deviations, std::size_t moves) {
  if (moves == 0) return "no move within the machine's limits separates them";
  const std::string apart = " differ by " + shortNumber(deviations) + " standard deviations";
  const int times = repeatsOfMoves(deviations, moves);
  if (times == 0)
    return "the best moves within the machine's limits" + apart +
           ": no practicable number of repeats separates them";
  return "the " + std::to_string(moves) + " proposed moves" + apart +
         (times > 1 ? ": measure them " + std::to_string(times) + " times" : "");
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
