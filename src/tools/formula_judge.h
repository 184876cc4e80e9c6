#pragma once
#include <set>
#include <string>

#include "simulation/uncatalogued.h"

namespace mm {

/// Names of the variables in the text of a `formula`: no functions, constants or unknowns (k1, k2 …).
std::set<std::string> variablesOfFormula(const std::string& formula);

/// Whether a formula is made of just the variables on which an error truly depends. Speed and direction of
/// travel of a joint are its velocity; the tip's speed and the approach are made of velocities of any joints.
bool justTheVariables(const std::set<std::string>& variables, const UncataloguedTruth& truth);

}  // namespace mm
