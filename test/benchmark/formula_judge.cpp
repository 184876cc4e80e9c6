#include "formula_judge.h"

#include <algorithm>
#include <cctype>

#include "base/text.h"

namespace mm {
namespace {

bool isUnknown(const std::string& name) {
  return name.size() > 1 && name[0] == 'k' &&
         std::all_of(name.begin() + 1, name.end(), [](unsigned char c) { return std::isdigit(c) != 0; });
}

/// A variable as a formula calls it; empty for what is made of velocities of any joints.
std::string inFormulas(const std::string& variable) {
  for (const char* end : {" speed", " travel direction"})
    if (endsWith(variable, end)) {
      const std::string joint = variable.substr(0, variable.size() - std::string(end).size());
      return joint == "tip" ? "" : joint + "_velocity";
    }
  if (variable == "approach") return "";
  if (variable == "time") return "t";
  const std::string temperature = "temperature ";
  return variable.rfind(temperature, 0) == 0 ? variable.substr(temperature.size()) : variable;
}

}  // namespace

std::set<std::string> variablesOfFormula(const std::string& formula) {
  std::set<std::string> names;
  for (std::size_t i = 0; i < formula.size();) {
    const auto letter = [&](std::size_t at) {
      return at < formula.size() &&
             (std::isalnum(static_cast<unsigned char>(formula[at])) || formula[at] == '_');
    };
    if (!letter(i)) {
      ++i;
      continue;
    }
    std::size_t end = i;
    while (letter(end)) ++end;
    const std::string name = formula.substr(i, end - i);
    const bool number = std::isdigit(static_cast<unsigned char>(name[0])) != 0;
    // 1e-3: the sign and the digits after it are no names either
    if (number && (name.back() == 'e' || name.back() == 'E') && end < formula.size() &&
        (formula[end] == '-' || formula[end] == '+'))
      for (++end; letter(end);) ++end;
    std::size_t next = end;
    while (next < formula.size() && formula[next] == ' ') ++next;
    const bool function = next < formula.size() && formula[next] == '(';
    if (!number && !function && !isUnknown(name) && name != "pi" && name != "e") names.insert(name);
    i = end;
  }
  return names;
}

bool justTheVariables(const std::set<std::string>& variables, const UncataloguedTruth& truth) {
  std::set<std::string> needed;
  bool anyVelocity = false;
  for (const std::string& variable : truth.variables) {
    const std::string name = inFormulas(variable);
    anyVelocity = anyVelocity || name.empty();
    if (!name.empty()) needed.insert(name);
  }
  bool moves = false;
  for (const std::string& name : variables) {
    const bool velocity = endsWith(name, "_velocity");
    moves = moves || velocity;
    if (needed.count(name) == 0 && !(anyVelocity && velocity)) return false;
  }
  for (const std::string& name : needed)
    if (variables.count(name) == 0) return false;
  return !anyVelocity || moves;
}

UnknownJudgement judge(const Diagnosis& d, const UncataloguedTruth& truth, double noise) {
  UnknownJudgement judgement;
  judgement.truth = truth;
  if (!d.formulas.empty()) {
    judgement.formula = d.formulas[0].effect.text("formula");
    judgement.formulaRight = justTheVariables(variablesOfFormula(judgement.formula), truth);
  }
  // what follows the time and nothing that was recorded is drift: told rightly where the largest is along it
  if (d.profiles.empty() && d.missing.empty() && truth.variables == std::vector<std::string>{"time"}) {
    const auto largest =
        std::max_element(d.drift.begin(), d.drift.end(),
                         [](const DriftResult& a, const DriftResult& b) { return a.std < b.std; });
    judgement.byDrift = largest != d.drift.end() && largest->direction == truth.direction;
    judgement.justTheVariables = judgement.rightDirection = judgement.byDrift;
    judgement.heldOut = d.heldOut / noise;
    judgement.explained = judgement.byDrift && judgement.heldOut <= UnknownJudgement::kExplained;
  }
  if (d.profiles.empty()) return judgement;
  judgement.profile = true;
  const ProfileResult& first = d.profiles[0];
  std::set<std::string> together;
  for (const ProfileResult& profile : d.profiles)
    together.insert(profile.variables.begin(), profile.variables.end());
  judgement.justTheVariables = justTheVariables({first.variables.begin(), first.variables.end()}, truth) ||
                               justTheVariables(together, truth);
  judgement.rightDirection = first.direction == truth.direction;
  judgement.heldOut = d.profiles.back().heldOutAfter / noise;
  judgement.explained = judgement.heldOut <= UnknownJudgement::kExplained;
  return judgement;
}

}  // namespace mm
