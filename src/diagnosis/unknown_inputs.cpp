#include "diagnosis/unknown_inputs.h"

#include <cmath>
#include <functional>

#include "effects/inputs.h"

namespace mm {

std::string unknownInput(const Effect& effect, const Problem& problem) {
  const Domain& domain = problem.model().domain();
  const Inputs needed = inputsOf(effect, domain);
  const std::size_t all = problem.session().observations.size();
  std::string name;
  std::size_t most = 0;
  const auto ask = [&](const std::string& input, const std::function<bool(const State&)>& known) {
    std::size_t unknown = 0;
    for (std::size_t o = 0; o < all; ++o) unknown += !known(problem.state(static_cast<int>(o)));
    if (unknown <= most) return;
    most = unknown;
    name = input;
  };
  const auto each = [&](const std::vector<int>& indices, const auto& nameOf, const auto& valueOf) {
    for (const int i : indices) ask(nameOf(i), [&](const State& s) { return std::isfinite(valueOf(s, i)); });
  };
  // Of which joint is in the effect's name, and what several effects lack alike is one line.
  const auto as = [](const char* what) { return [what](int) { return std::string(what); }; };
  each(needed.positions, as("reading"), [](const State& s, int j) { return s.position[j]; });
  each(needed.velocities, as("speed"), [](const State& s, int j) { return s.velocity[j]; });
  each(needed.travels, as("direction of travel"),
       [](const State& s, int j) { return s.travel[j] != 0.0 ? s.travel[j] : std::nan(""); });
  each(needed.reversals, as("way since the last reversal"),
       [](const State& s, int j) { return s.sinceReversalOf(j) >= 0.0 ? 0.0 : std::nan(""); });
  each(
      needed.temperatures, [&](int i) { return "temperature '" + domain.sensors[i] + "'"; },
      [](const State& s, int i) { return s.temperature[i]; });
  each(
      needed.covariates, [&](int i) { return "'" + domain.covariates[i] + "'"; },
      [](const State& s, int i) { return s.covariate[i]; });
  if (needed.time || needed.history) ask("time", [](const State& s) { return std::isfinite(s.time); });
  if (needed.approach)
    ask("direction of approach",
        [](const State& s) { return s.approach.allFinite() && !s.approach.isZero(); });
  if (needed.reading) ask("laser reading", [](const State& s) { return std::isfinite(s.laserReading); });
  return most == 0 ? ""
                   : name + " is not known at " + std::to_string(most) + " of " + std::to_string(all) +
                         " observations";
}

}  // namespace mm
