#include "diagnosis/harmonics.h"

#include <algorithm>
#include <cstdio>

#include "diagnosis/round.h"
#include "effects/registry.h"
#include "machine/units.h"

namespace mm {
namespace {

const char* const kScrew = "lead_screw_periodic";

/// @param period m or rad.
std::vector<EffectSpec> harmonicsOf(const EffectSpec& screw, double period, const Domain& domain) {
  constexpr double kTurns = 5.0;
  const int joint = domain.findJoint(screw.text("axis"));
  if (joint < 0 || domain.upper[joint] - domain.lower[joint] < kTurns * period) return {};
  const char* key = screw.find("period_deg") != nullptr ? "period_deg" : "period_mm";
  const double unit = key == std::string("period_deg") ? kDegree : kMillimetre;
  std::vector<EffectSpec> specs;
  for (const int harmonic : {2, 3}) {
    char text[32];
    std::snprintf(text, sizeof text, "%.6g", period / harmonic / unit);
    specs.push_back(EffectSpec(screw.type).set("axis", screw.text("axis")).set(key, std::string(text)));
  }
  return specs;
}

}  // namespace

std::vector<EffectSpec> harmonicsInModel(const ResidualSpace& space) {
  const Model& model = space.problem().model();
  std::vector<EffectSpec> specs;
  for (std::size_t e = 0; e < model.effects().size(); ++e) {
    const Effect& effect = *model.effects()[e];
    if (effect.spec().type != kScrew || effect.nonlinearParameters().empty()) continue;
    const double period =
        space.fitted().x[model.offset(static_cast<int>(e)) + effect.nonlinearParameters()[0]];
    for (EffectSpec& spec : harmonicsOf(effect.spec(), period, model.domain()))
      specs.push_back(std::move(spec));
  }
  return specs;
}

std::vector<EffectSpec> harmonicsBeside(const Round& round, const Subset& found) {
  std::vector<EffectSpec> specs;
  for (const Chosen& c : found.chosen) {
    const EffectSpec& screw = round.set.candidates[c.candidate].spec;
    if (screw.type != kScrew || c.nonlinear.empty()) continue;
    const Domain& domain = round.space.problem().model().domain();
    for (const EffectSpec& spec : harmonicsOf(screw, c.nonlinear[0], domain)) {
      const EffectPtr effect = createEffect(spec, domain);
      std::vector<double> p;
      for (const Parameter& q : effect->parameters()) p.push_back(q.start);
      Eigen::MatrixXd columns = round.space.columns(*effect, p);
      round.space.project(columns);
      if (round.search.beyond(found, columns, round.set.logTried)) specs.push_back(spec);
    }
  }
  return specs;
}

bool keepsCauses(const Round& before, const Subset& was, const Round& after, const Subset& is) {
  return std::all_of(was.chosen.begin(), was.chosen.end(), [&](const Chosen& c) {
    const EffectSpec& cause = before.set.candidates[c.candidate].spec;
    return std::any_of(is.chosen.begin(), is.chosen.end(), [&](const Chosen& other) {
      return sameCause(after.set.candidates[other.candidate].spec, cause);
    });
  });
}

}  // namespace mm
