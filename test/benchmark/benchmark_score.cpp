#include "benchmark_score.h"

#include <algorithm>

namespace mm {
namespace {

std::string sensorPair(const EffectSpec& s) {
  std::vector<std::string> names;
  if (const auto* v = s.find("sensors")) names = v->items;
  for (const char* key : {"warm", "cold"})
    if (!s.text(key).empty()) names.push_back(s.text(key));
  std::sort(names.begin(), names.end());
  std::string text;
  for (const auto& n : names) text += n + " ";
  return text;
}

bool listedBesideDrift(const Diagnosis& d, const EffectSpec& hidden) {
  for (const DriftResult& drift : d.drift)
    for (const DriftResult::Perhaps& perhaps : drift.perhaps)
      if (sameCause(hidden, perhaps.effect)) return true;
  return false;
}

}  // namespace

bool sameCause(const EffectSpec& hidden, const EffectSpec& named) {
  if (hidden.type != named.type) return false;
  for (const char* key :
       {"axis", "of", "direction", "about", "sensor", "ball", "feature", "covariate", "joint", "with"}) {
    const std::string a = hidden.text(key), b = named.text(key);
    if (!a.empty() && !b.empty() && a != b &&
        !(hidden.type == "thermal_bending" && std::string(key) == "axis"))
      return false;
  }
  const std::string pa = sensorPair(hidden), pb = sensorPair(named);
  return pa.empty() || pb.empty() || pa == pb;
}

int Score::count(Hit hit) const { return static_cast<int>(std::count(hits.begin(), hits.end(), hit)); }

bool Score::exact() const {
  return count(Hit::kNamed) + count(Hit::kConfusable) == static_cast<int>(hits.size()) && wrong == 0 &&
         !profile && !formula;
}

Score scoreOf(const Diagnosis& d, const std::vector<EffectSpec>& hidden) {
  Score score;
  score.hits.assign(hidden.size(), Hit::kMissed);
  score.profile = !d.profiles.empty();
  score.formula = !d.formulas.empty();
  score.claimed = !d.missing.empty() || score.profile || score.formula;
  for (const DriftResult& drift : d.drift) score.perhaps += static_cast<int>(drift.perhaps.size());

  const auto isHidden = [&](const CandidateResult& m) {
    return std::any_of(hidden.begin(), hidden.end(),
                       [&](const EffectSpec& h) { return sameCause(h, m.effect); });
  };
  for (std::size_t h = 0; h < hidden.size(); ++h) {
    for (const CandidateResult& m : d.missing) {
      if (sameCause(hidden[h], m.effect)) score.hits[h] = Hit::kNamed;
    }
  }
  for (std::size_t i = 0; i < d.missing.size(); ++i) {
    const CandidateResult& m = d.missing[i];
    bool right = isHidden(m);
    // One named cause stands for one hidden one, and only for one that is not named itself.
    for (std::size_t h = 0; h < hidden.size() && !right && m.confusableWith.size() <= Score::kRivals; ++h) {
      if (score.hits[h] != Hit::kMissed) continue;
      right = std::any_of(m.confusableWith.begin(), m.confusableWith.end(),
                          [&](const Confusable& c) { return sameCause(hidden[h], c.effect); });
      if (right) score.hits[h] = Hit::kConfusable;
    }
    if (i == 0) score.firstRight = right;
    score.wrong += !right;
  }
  for (std::size_t h = 0; h < hidden.size(); ++h)
    if (score.hits[h] == Hit::kMissed && listedBesideDrift(d, hidden[h])) score.hits[h] = Hit::kBesideDrift;
  score.firstBesideDrift = d.missing.empty() && score.count(Hit::kBesideDrift) > 0;
  score.firstRight = score.firstRight || score.firstBesideDrift;
  return score;
}

}  // namespace mm
