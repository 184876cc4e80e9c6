// A formula is given only where it is equivalent to the curve that the evidence found: an engineer reads it
// faster.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "base/error.h"
#include "diagnosis/answers.h"
#include "diagnosis/shape_maker.h"
#include "effects/registry.h"

namespace mm {
namespace {

/// Forms of one variable v, of two variables a and b: at most three constants, each of them counted.
const char* const kOfOne[] = {
    "k1*{v}",          "k1*{v}^2",        "k1*{v}^3",          "k1*abs({v})",       "k1*{v}*abs({v})",
    "k1*{v}+k2*{v}^2", "k1*{v}+k2*{v}^3", "k1*sqrt(abs({v}))", "k1*{v}^2+k2*{v}^3", "k1*{v}+k2*abs({v})"};
const char* const kOfTwo[] = {"k1*{a}*{b}",     "k1*{a}*{b}^2",      "k1*{a}^2*{b}",
                              "k1*{a}^2*{b}^2", "k1*{a}*abs({b})",   "k1*abs({a})*{b}",
                              "k1*{a}+k2*{b}",  "k1*{a}*{b}+k2*{a}", "k1*{a}*{b}+k2*{b}"};

std::string filled(std::string form, const std::vector<std::string>& names) {
  const auto replace = [&](const std::string& mark, const std::string& name) {
    for (std::size_t at = form.find(mark); at != std::string::npos; at = form.find(mark))
      form.replace(at, 3, name);
  };
  replace("{v}", names[0]);
  replace("{a}", names[0]);
  if (names.size() > 1) replace("{b}", names[1]);
  return form;
}

std::string waveOf(const std::string& name, double period) {
  char text[200];
  std::snprintf(text, sizeof text, "k1*sin(2*pi*%s/%.4g)+k2*cos(2*pi*%s/%.4g)", name.c_str(), period,
                name.c_str(), period);
  return text;
}

/// A formula that was asked.
struct Asked {
  EffectSpec spec;
  EffectPtr effect;
  RowMatrix columns;
  Gain gain;
};

}  // namespace

void describeProfiles(const Search& search, const Explanation& found, const HeldOut& held, double unit,
                      Diagnosis& out) {
  const Questions& q = search.questions();
  const Domain& domain = q.space->problem().model().domain();
  const auto evidence = search.evidenceAt(found);
  const GroupColumns make(*q.space);
  std::size_t profile = 0;
  for (std::size_t j = 0; j < found.members.size() && profile < out.profiles.size(); ++j) {
    if (!q.groups.groups[found.members[j].group].profile) continue;
    const ProfileResult& p = out.profiles[profile++];
    std::vector<Member> others = found.members;
    others.erase(others.begin() + static_cast<long>(j));
    const Evidence::Given given = evidence->given(others);
    const double own = evidence->gainOf(given, *found.members[j].columns).value;
    Asked best;
    best.gain.value = -1e300;
    const auto ask = [&](const std::string& text, double price) {
      Asked a;
      a.spec = EffectSpec("formula");
      a.spec.set("direction", p.direction).set("formula", text);
      try {
        a.effect = createEffect(a.spec, domain);
      } catch (const InputError&) {
        return -1e300;  // a form that cannot be worked out with these variables
      }
      if (!a.effect->linear()) return -1e300;
      a.columns = make(a.effect, {});
      if (a.columns.cols() == 0) return -1e300;
      a.gain = evidence->gainOf(given, a.columns);
      a.gain.value -= price;
      const double value = a.gain.value;
      if (value > best.gain.value) best = std::move(a);
      return value;
    };
    if (p.variables.size() == 2) {
      for (const char* form : kOfTwo) {
        ask(filled(form, p.variables), std::log(static_cast<double>(std::size(kOfTwo))));
      }
    } else {
      const double forms = std::log(static_cast<double>(std::size(kOfOne)) + 1.0);
      for (const char* form : kOfOne) ask(filled(form, p.variables), forms);
      if (p.curve.size() > 2) {  // a wave: periods of which one length to ten were seen
        constexpr int kPeriods = 60;
        const double range = p.curve.back()[0] - p.curve.front()[0];
        double at = 0.0, most = -1e300;
        for (int k = 0; k < kPeriods; ++k) {
          const double period = range / (1.0 + 9.0 * k / (kPeriods - 1.0));
          const double value =
              ask(waveOf(p.variables[0], period), forms + std::log(static_cast<double>(kPeriods)));
          if (value > most) most = value, at = period;
        }
        for (const double step : {0.01, 0.003, 0.001})
          for (const double sign : {1.0, -1.0})
            for (int again = 0; again < 6; ++again) {
              const double value = ask(waveOf(p.variables[0], at * (1.0 + sign * step)),
                                       forms + std::log(static_cast<double>(kPeriods)));
              if (!(value > most)) break;
              most = value;
              at *= 1.0 + sign * step;
            }
      }
    }
    if (!best.effect || !(best.gain.value >= own - kIndistinct)) continue;
    Member member = found.members[j];
    member.columns = std::make_shared<RowMatrix>(best.columns);
    member.size = std::max(kSmallestSize, best.gain.size);
    std::vector<Member> members = others;
    members.push_back(member);
    out.formulas.push_back(
        {best.effect->spec(), p.effect, p.heldOutBefore, held.withMembers(members) * unit});
  }
}

}  // namespace mm
