#include <algorithm>
#include <cmath>

#include "base/units.h"
#include "design/point_set.h"
#include "machine/joint_units.h"
#include "report/json_parts.h"
#include "report/text_parts.h"
#include "session/session_summary.h"

namespace mm {
namespace {

std::string featuresText(const PointSet& set) {
  if (set.features.empty()) return {};
  std::string text = "\nBalls and points        contacts   cone of approach   centre, alone\n";
  for (const FeatureCoverage& f : set.features) {
    text += "  " + padded(f.name, 22) + format("%8d   ", f.contacts);
    text +=
        padded(std::isfinite(f.coneHalfAngle) ? format("± %.0f deg", f.coneHalfAngle / kDegree) : "-", 19);
    text += !f.ball                           ? "-"
            : std::isfinite(f.centrePerNoise) ? format("%.2g x the noise", f.centrePerNoise)
                                              : std::string("not determined: touch it from more directions");
    if (f.lengths > 0) text += format("; %d lengths from it", f.lengths);
    text += "\n";
  }
  return text;
}

std::string jointsText(const PointSet& set) {
  std::string text =
      "\nJoints            range                      positions   travel + / - / unknown   with time\n";
  for (const JointCoverage& j : set.joints) {
    const double unit = j.rotary ? kDegree : kMillimetre;
    text += "  " + padded(j.name, 16) +
            padded(j.upper > j.lower
                       ? format("%.4g … %.4g %s", j.lower / unit, j.upper / unit, j.rotary ? "deg" : "mm")
                       : format("%.4g %s, not moved", j.lower / unit, j.rotary ? "deg" : "mm"),
                   27) +
            padded(j.positions > 0 ? std::to_string(j.positions) : "many", 12) +
            padded(format("%d / %d / %d", j.up, j.down, j.unknown), 25) + format("%5.2f\n", j.withTime);
  }
  return text;
}

std::string inputsText(const PointSet& set) {
  if (set.inputs.empty()) return {};
  std::string text = "\nLogged            range                      missing     correlation with time\n";
  for (const InputCoverage& i : set.inputs)
    text += "  " + padded(i.name, 16) +
            padded(format("%.4g … %.4g %s", i.lower, i.upper, i.unit.c_str()), 27) +
            padded(std::to_string(i.missing), 12) +
            format("%5.2f%s\n", i.withTime,
                   std::abs(i.withTime) > 0.95 ? "  not separable from a drift in time" : "");
  return text;
}

std::string modelText(const PointSet& set) {
  if (!set.hasModel) return {};
  const Identifiability& id = set.identifiability;
  std::string text = format("\nThe model: %d of %d parameters are determined\n", id.rank, id.parameters);
  for (const LostDirection& l : id.lost)
    if (l.ofTheModel)
      text += "  lost: " + l.inWords +
              (l.byConvention  ? " (held by convention)"
               : l.noInfluence ? " (held: nothing measured depends on it)"
                               : "") +
              "; " + l.wouldShow + "\n";
  for (const WeakParameter& w : set.weak)
    text += "  weak: " + w.name + " only to ± " + sixDigits(std::stod(format("%.2g", 2.0 * w.std))) +
            (w.unit == "1" ? "" : " " + w.unit) + " (k = 2)\n";
  return text;
}

/// "b = -90 deg, a = 45 deg, t = 4 mm, on s0" and the readings that put the probe there.
std::string postureText(const Machine& machine, const ProposedPosture& p) {
  std::string angles, linear;
  for (int j = 0; j < machine.jointCount(); ++j) {
    const bool rotary = machine.joints()[j].kind == JointKind::kRotary;
    std::string& to = rotary ? angles : linear;
    to += (to.empty() ? "" : ", ") + machine.joints()[j].name + " " +
          (rotary ? format("%.4g deg", p.position[j] / kDegree)
                  : format("%.5g mm", p.position[j] / kMillimetre));
  }
  return angles +
         (std::isfinite(p.laserReading) ? format(", reading %.3g mm", p.laserReading / kMillimetre) : "") +
         ", on " + p.feature + "; there " + linear;
}

std::string doubtsText(const PointSet& set) {
  std::string text;
  for (const std::string& doubt : set.doubts) text += "  " + doubt + "\n";
  return text.empty() ? text : "\nPostures\n" + text;
}

std::string adviceText(const PointSet& set) {
  if (set.advice.postures.empty()) return {};
  std::string text = "  most useful additional postures (five contacts each, around the probe direction):\n";
  for (const ProposedPosture& p : set.advice.postures)
    text += "    " + postureText(set.problem->session().machine, p) + "\n";
  for (const PostureAdvice::Gain& g : set.advice.gains)
    text += format("    %s: from ± %.2g to ± %.2g%s%s (k = 2)\n", g.parameter.c_str(), 2.0 * g.before,
                   2.0 * g.after, g.unit == "1" ? "" : " ", g.unit == "1" ? "" : g.unit.c_str());
  return text;
}

/// "axis x, degree 2"
std::string keysOf(const EffectSpec& effect) {
  std::string text;
  for (const auto& [key, value] : effect.keys) {
    text += (text.empty() ? "" : ", ") + key;
    for (const std::string& item : value.items) text += " " + item;
  }
  return text;
}

/// Members of one type that are hidden for the same reason, on one line; those of joints that never moved on
/// one line too.
std::string hiddenText(const PointSet& set) {
  if (set.cannotShow.empty()) return "\nEvery effect of the catalogue would show in this session.\n";
  const std::vector<std::string> idle = idleJoints(set.problem->model().domain());
  std::vector<char> told;
  for (const CannotBeShown& c : set.cannotShow) told.push_back(isOf(c.effect, idle) ? 1 : 0);
  const auto ofIdle = static_cast<std::size_t>(std::count(told.begin(), told.end(), 1));
  std::string text = "\nThis session cannot show (--json says what would)\n" + idleText(idle, ofIdle);
  for (std::size_t first = 0; first < set.cannotShow.size(); ++first) {
    if (told[first] != 0) continue;
    const CannotBeShown& head = set.cannotShow[first];
    std::vector<std::string> members;
    for (std::size_t i = first; i < set.cannotShow.size(); ++i) {
      const CannotBeShown& c = set.cannotShow[i];
      if (told[i] != 0 || c.why != head.why || c.effect.type != head.effect.type) continue;
      told[i] = 1;
      members.push_back(keysOf(c.effect));
    }
    text += "  " + padded(head.effect.type, 24);
    constexpr std::size_t kShown = 3;
    for (std::size_t i = 0; i < std::min(kShown, members.size()); ++i)
      text += (i > 0 ? "; " : "") + members[i];
    if (members.size() > kShown) text += format("; %zu more", members.size() - kShown);
    text += "\n      " + head.why + "\n";
  }
  return text;
}

std::string separationsText(const PointSet& set) {
  if (set.separations.empty()) return {};
  std::string told, open;
  for (const Separation& s : set.separations)
    (s.told ? told : open) += "  " + s.what + (s.told ? "" : ": it takes " + s.needs) + "\n";
  return (told.empty() ? "" : "\nTold apart\n" + told) + (open.empty() ? "" : "\nNot separable\n" + open);
}

Json coverageJson(const FeatureCoverage& f) {
  return jsonObject(
      {{{"name", f.name}, {"kind", f.ball ? "ball" : "point"}, {"contacts", f.contacts}},
       entryIf(f.lengths > 0, "lengths", f.lengths),
       {{"cone_half_angle_deg", f.coneHalfAngle / kDegree}, {"centre_std_per_noise", f.centrePerNoise}}});
}

Json jointCoverageJson(const JointCoverage& j) {
  const std::string unit = j.rotary ? "deg" : "mm";
  const double factor = j.rotary ? kDegree : kMillimetre;
  return {{"name", j.name},
          {"lower_" + unit, j.lower / factor},
          {"upper_" + unit, j.upper / factor},
          {"positions", orNull(j.positions > 0, j.positions)},
          {"travel", {{"up", j.up}, {"down", j.down}, {"unknown", j.unknown}}},
          {"slowest_" + unit + "_s", j.slowest / factor},
          {"fastest_" + unit + "_s", j.fastest / factor},
          {"correlation_with_time", j.withTime}};
}

Json inputCoverageJson(const InputCoverage& i) {
  return {{"name", i.name},   {"unit", i.unit},       {"lower", i.lower},
          {"upper", i.upper}, {"missing", i.missing}, {"correlation_with_time", i.withTime}};
}

/// What the model's parameters are determined to.
Json determinedJson(const PointSet& set) {
  const auto weak = [](const WeakParameter& w) -> Json {
    return {{"name", w.name}, {"std", w.std}, {"unit", w.unit}};
  };
  return {{"identifiability", identifiabilityJson(*set.problem, set.identifiability, set.problem->start())},
          {"weak", jsonList(set.weak, weak)}};
}

/// The postures that would help, and what the parameters would be determined to with them.
Json adviceJson(const PointSet& set) {
  const std::vector<Joint>& joints = set.problem->session().machine.joints();
  const auto posture = [&](const ProposedPosture& p) {
    Json one{{"feature", p.feature}};
    for (std::size_t j = 0; j < joints.size(); ++j) {
      const JointUnit unit = readingUnit(joints[j]);
      one[joints[j].name + "_" + unit.symbol] = p.position[j] / unit.factor;
    }
    if (std::isfinite(p.laserReading)) one["reading_mm"] = p.laserReading / kMillimetre;
    return one;
  };
  const auto gain = [](const PostureAdvice::Gain& g) -> Json {
    return {{"name", g.parameter}, {"std_before", g.before}, {"std_after", g.after}, {"unit", g.unit}};
  };
  return {{"proposed_postures", jsonList(set.advice.postures, posture)},
          {"with_them", jsonList(set.advice.gains, gain)}};
}

Json separationJson(const Separation& s) {
  return {{"what", s.what}, {"told", s.told}, {"needs", s.told ? "" : s.needs}};
}

Json cannotBeShownJson(const CannotBeShown& c) {
  return {{"effect", effectJson(c.effect)}, {"why", c.why}, {"moves", c.moves}};
}

}  // namespace

std::string pointSetText(const PointSet& set) {
  std::string first;
  for (const Doubt& d : set.questions) first += d.question + "\n";
  if (!first.empty()) first = "Questions first\n" + first + "\n";
  const Session& session = set.problem->session();
  const std::string assumed = assumedText(session);
  std::string notes = assumed.empty() ? assumed : assumed + "\n";
  for (const std::string& line : setAsideLines(session)) notes += line + "\n";
  for (const StandardTest& test : standardTests(session)) notes += test.inWords + "\n";
  return first +
         format("%lld contacts, %lld references", static_cast<long long>(set.contacts),
                static_cast<long long>(set.references)) +
         (set.duration > 0.0 ? format(" in %.4g s", set.duration) : "") +
         format("; noise %.3g um, %s\n", set.noise / kMicrometre,
                set.noiseDeclared ? "declared" : "assumed for the figures below") +
         notes + featuresText(set) + jointsText(set) + inputsText(set) + separationsText(set) +
         doubtsText(set) + modelText(set) + adviceText(set) + hiddenText(set);
}

Json pointSetObject(const PointSet& set) {
  return jsonObject({{{"observations", set.contacts + set.references},
                      {"contacts", set.contacts},
                      {"references", set.references},
                      {"duration_s", set.duration},
                      {"noise_um", set.noise / kMicrometre},
                      {"noise_from", set.noiseDeclared ? "declared" : "assumed"},
                      {"features", jsonList(set.features, coverageJson)},
                      {"joints", jsonList(set.joints, jointCoverageJson)},
                      {"logged", jsonList(set.inputs, inputCoverageJson)}},
                     set.hasModel ? determinedJson(set) : Json(),
                     {{"doubts", set.doubts}, {"tests", testsJson(standardTests(set.problem->session()))}},
                     sessionNotes(set.problem->session(), set.questions),
                     set.hasModel ? adviceJson(set) : Json(),
                     {{"separates", jsonList(set.separations, separationJson)},
                      {"cannot_show", jsonList(set.cannotShow, cannotBeShownJson)}}});
}

std::string pointSetJson(const PointSet& set) { return jsonText(pointSetObject(set)); }

}  // namespace mm
