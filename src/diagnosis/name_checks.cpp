#include "diagnosis/name_checks.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "diagnosis/held_out.h"
#include "diagnosis/search.h"
#include "effects/linearity.h"

namespace mm {
namespace {

constexpr double kLikely = 0.5;  // probability from which a cause must predict
constexpr double kNoSize = 0.5;  // that a cause acts of which a fit of everything finds no size

/// The noise beside what is left of what was found, and what comes with it.
void refitBesideParts(Look& look) {
  const std::size_t named = look.found.members.size();
  const Explanation all = withParts(look.questions, look.posterior, look.found);
  look.found = Search(look.questions).refitted(all.members, all);
  look.found.members.resize(named);
}

/// A group is doubted. @return whether something else is named in its place: then that is found, all anew.
bool doubt(Look& look, int group, double probability) {
  if (!look.posterior.doubt(group, probability)) return false;
  const Questions& q = look.questions;
  findNamed(q, problemOf(q, q.groups, statedFreedomsOf(*look.fitted)), look.posterior);
  look.found = look.posterior.found;
  return true;
}

/// The same of a member of what was found.
void doubtMember(Look& look, std::size_t member, double probability) {
  std::vector<Member>& members = look.found.members;
  if (doubt(look, members[member].group, probability)) return;
  members.erase(members.begin() + static_cast<long>(member));
  refitBesideParts(look);
}

}  // namespace

void dropWhatPredictsNothing(Look& look) {
  const Search search(look.questions);
  const auto whole = [&] { return withParts(look.questions, look.posterior, look.found); };
  const Questions rows = rowsOf(look.questions);
  const Search ofRows(rows);
  while (!look.found.members.empty()) {
    const HeldOut held(ofRows, look.found);
    const auto evidence = search.evidenceAt(look.found);
    std::size_t least = 0;
    double worth = std::numeric_limits<double>::infinity();
    const Explanation all = whole();
    for (std::size_t j = 0; j < look.found.members.size(); ++j) {
      const std::vector<Member> others = search.beside(*evidence, all.members, j);
      const double of = held.worthOf(look.found.members[j], others);
      if (of < worth) worth = of, least = j;
    }
    if (worth > kPredicts) break;
    doubtMember(look, least, 0.5 * std::erfc(-worth / std::sqrt(2.0)));
  }
  // what is likely and not sure enough to be named may rest on one reading just as well
  const HeldOut held(ofRows, look.found);
  const auto evidence = search.evidenceAt(look.found);
  const std::vector<Member> beside = whole().members;
  const std::vector<Slot> slots = look.posterior.slots;
  for (const Slot& slot : slots) {
    const bool comesWithOne = std::any_of(beside.begin(), beside.end(),
                                          [&](const Member& m) { return m.group == slot.causes.front(); });
    if (slot.named || slot.shares.front() < kLikely || comesWithOne) continue;
    const Gain gain = evidence->gainOf(evidence->given(beside), slot.causes.front());
    if (gain.group < 0) continue;
    const double worth = held.worthOf(search.memberOf(gain), beside);
    if (doubt(look, gain.group, 0.5 * std::erfc(-worth / std::sqrt(2.0))))
      return dropWhatPredictsNothing(look);
  }
}

bool dropWhatHasNoSize(Look& look, const Diagnosis& diagnosis) {
  const Search search(look.questions);
  std::vector<double> largest(look.found.members.size(), 0.0);  // of a member: |value| / U
  for (const Answer& a : answersOf(search, look.found)) {
    double& of = largest[static_cast<std::size_t>(a.member)];
    const auto result = std::find_if(diagnosis.missing.begin(), diagnosis.missing.end(),
                                     [&](const CandidateResult& r) { return r.effect == a.effect->spec(); });
    const std::vector<int> linear = linearParameters(*a.effect);
    if (result == diagnosis.missing.end() ||
        result->parameters.size() != static_cast<std::size_t>(a.effect->parameterCount())) {
      of = std::numeric_limits<double>::infinity();  // a curve, or not fitted by itself
      continue;
    }
    for (const int k : linear) {
      const NamedValue& p = result->parameters[static_cast<std::size_t>(k)];
      of = std::max(of, std::isfinite(p.std) ? std::abs(p.value) / (2.0 * p.std)
                                             : std::numeric_limits<double>::infinity());
    }
  }
  const auto least = std::min_element(largest.begin(), largest.end());
  if (least == largest.end() || !(*least < 1.0)) return false;
  const auto j = least - largest.begin();
  doubtMember(look, static_cast<std::size_t>(j), kNoSize);
  return true;
}

}  // namespace mm
