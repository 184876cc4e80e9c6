#pragma once
#include <string>
#include <vector>

namespace mm {

/// A quantity of one machine, with its standard uncertainty.
struct Sister {
  std::string machine;
  double value = 0.0, std = 0.0;
};

/// Machines of one make, taken together.
struct Sisterhood {
  double centre = 0.0, centreStd = 0.0;  // median, and its standard uncertainty
  double spread = 0.0;                   // standard deviation between machines, beyond their uncertainties
  std::vector<double> p;  // a machine: of being so far from the centre by chance; 1 where there are too few
};

/// Random effects: a machine's value is the common centre, what machines differ by, and the uncertainty of
/// its own value. Centre and spread are the median and the lower quartile of the distances of pairs
/// (`pairSpread`; of more than 200 machines the median deviation), so that up to half of the machines may be
/// wrong; their uncertainty is allowed for by Student's t with half as many degrees of freedom as there are
/// machines. Below four machines nothing is said.
Sisterhood sistersOf(const std::vector<Sister>& sisters);

}  // namespace mm
