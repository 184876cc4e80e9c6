#pragma once
#include <string>
#include <vector>

#include "fleet/fleet.h"

namespace mm {

/// What sister machines say of a parameter of the next one of their make: mean and standard deviation, in the
/// unit of people.
struct PopulationPrior {
  std::string effect, name, unit;  // effect: `{type: backlash, axis: x}`
  double mean = 0.0, std = 0.0;
  std::size_t machines = 0;
};

/// Sisters below which nothing is said: their spread is then hardly known.
inline constexpr std::size_t kFewestForPrior = 5;

/// The predictive distribution of a new machine under the normal random-effects model: value of a machine =
/// mean + what machines differ by + its uncertainty, with flat priors on the mean and on the standard
/// deviation between machines (Gelman, Bayesian Analysis 1 (2006) 515), integrated numerically over the
/// latter. Each machine counts once, with its present value; a worn one widens the prior, and is not left
/// out.
PopulationPrior predictiveOf(const std::vector<Sister>& sisters);

/// For every parameter that enough machines have; of converged fits. @param except machine that is left out:
/// the new one itself. @throw InputError: no parameter of enough machines.
std::vector<PopulationPrior> populationPriors(const Fleet& fleet, const std::string& except);

/// Chance that a machine of the population has what the session says: the prior predictive p-value of the
/// smallest sum of squares, which grows by `chi2` when the `count` priors are added (Box, J. R. Statist. Soc.
/// A 143 (1980) 383). Small: the machine is no sister of these.
double conflictOf(double chi2, double count);

}  // namespace mm
