#include "benchmark_counts.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <sstream>

#include "base/json_text.h"

namespace mm {
namespace {

std::string padded(const std::string& text, std::size_t width) {
  return text + std::string(text.size() < width ? width - text.size() : 1, ' ');
}

std::string line(const std::string& name, int right, int count) {
  return padded(name, 46) + wilson(right, count) + "\n";
}

const char* nameOf(Hit hit) {
  switch (hit) {
    case Hit::kMissed:
      return "missed";
    case Hit::kNamed:
      return "named";
    case Hit::kConfusable:
      return "confusable";
    case Hit::kBesideDrift:
      return "beside_drift";
  }
  return "";
}

nlohmann::ordered_json jsonOf(const Trial& r, bool uncatalogued) {
  nlohmann::ordered_json json = {
      {"seed", r.seed}, {"hidden", r.hiddenText}, {"verdict", nameOf(r.verdict)}, {"found", r.found}};
  nlohmann::ordered_json hits = nlohmann::ordered_json::array();
  for (const Hit hit : r.score.hits) hits.push_back(nameOf(hit));
  json["hits"] = hits;
  json["wrong"] = r.score.wrong;
  json["first_right"] = r.score.firstRight;
  json["said"] = r.said;
  json["held_out_rms"] = r.heldOutEnd;
  json["seconds"] = r.seconds;
  if (r.oracleGain) json["oracle_gain"] = *r.oracleGain;
  if (uncatalogued) {
    json["variables_right"] = r.unknown.justTheVariables;
    json["direction_right"] = r.unknown.rightDirection;
    json["profile_held_out_rms"] = orNull(r.unknown.profile, r.unknown.heldOut);
    json["formula"] = r.unknown.formula;
    json["formula_right"] = r.unknown.formulaRight;
  }
  return json;
}

bool unknownGood(const Trial& r) {
  return (r.verdict == Verdict::kUnknownEffect || r.unknown.byDrift) && r.unknown.justTheVariables &&
         r.unknown.explained;
}

}  // namespace

std::string wilson(int right, int count) {
  if (count == 0) return "-";
  const double z = 1.959964, n = count, p = right / n;
  const double centre = (p + z * z / (2 * n)) / (1 + z * z / n);
  const double half = z / (1 + z * z / n) * std::sqrt(p * (1 - p) / n + z * z / (4 * n * n));
  char text[80];
  std::snprintf(text, sizeof text, "%5.1f %% (%.1f-%.1f %%) %d/%d", 100 * p,
                100 * std::max(0.0, centre - half), 100 * std::min(1.0, centre + half), right, count);
  return text;
}

bool BenchmarkCounts::good(const Trial& r) const {
  if (uncatalogued_) return unknownGood(r);
  return effects_ > 0 ? r.score.exact() : !r.score.claimed;
}

void BenchmarkCounts::add(const Trial& r) {
  if (r.notShown) {
    ++notShown_;
    return;
  }
  ++sessions_;
  const Score& s = r.score;
  first_ += s.firstRight;
  firstBesideDrift_ += s.firstBesideDrift;
  exact_ += s.exact();
  byHand_ += effects_ > 0 && r.rightByCorrelation == effects_;
  atNoise_ += r.heldOutEnd < 1.05;
  claimed_ += s.claimed;
  wrong_ += s.wrong;
  withWrong_ += s.wrong > 0;
  profiles_ += s.profile;
  formulas_ += s.formula;
  perhaps_ += s.perhaps;
  seconds_ = std::max(seconds_, r.seconds);
  ++verdicts_[nameOf(r.verdict)];
  for (std::size_t h = 0; h < s.hits.size(); ++h)
    for (Hits* hits : {&hits_, &byType_[r.hidden[h].type]}) {
      ++hits->all;
      hits->named += s.hits[h] == Hit::kNamed;
      hits->confusable += s.hits[h] == Hit::kConfusable;
      hits->besideDrift += s.hits[h] == Hit::kBesideDrift;
    }
  oracle_ = oracle_ || r.oracleGain;
  const bool sure = r.oracleGain.value_or(0.0) > Oracle::sure();
  oracleSure_ += sure;
  oracleOnly_ += sure && !s.firstRight;
  if (uncatalogued_)
    for (Unknown* u : {&unknown_, &unknownByType_[r.hidden.empty() ? "" : r.hidden[0].type]}) {
      ++u->all;
      u->verdict += r.verdict == Verdict::kUnknownEffect || r.unknown.byDrift;
      u->variables += r.unknown.justTheVariables;
      u->direction += r.unknown.justTheVariables && r.unknown.rightDirection;
      u->heldOut += r.unknown.explained;
      u->everything += unknownGood(r);
      u->byCatalogue += r.byCatalogue;
      u->formula += !r.unknown.formula.empty();
      u->formulaRight += r.unknown.formulaRight;
    }
  trials_.push_back(jsonOf(r, uncatalogued_));
}

std::string BenchmarkCounts::unknownText() const {
  const Unknown& u = unknown_;
  std::ostringstream out;
  out << line("verdict unknown_effect, or told as drift", u.verdict, u.all)
      << line("just the right variables", u.variables, u.all)
      << line("  and in the right direction", u.direction, u.all)
      << line("held-out RMS within 15 % of the noise", u.heldOut, u.all)
      << line("verdict, variables and held-out RMS", u.everything, u.all)
      << line("explained by effects of the catalogue", u.byCatalogue, u.all)
      << line("formula over the right variables, where given", u.formulaRight, u.formula)
      << "by kind (all three | verdict, variables, direction too, held-out, by the catalogue of sessions):\n";
  for (const auto& [kind, c] : unknownByType_)
    out << "  " << padded(kind, 36) << wilson(c.everything, c.all) << " | " << c.verdict << " " << c.variables
        << " " << c.direction << " " << c.heldOut << " " << c.byCatalogue << " of " << c.all << "\n";
  return out.str();
}

std::string BenchmarkCounts::text() const {
  std::ostringstream out;
  if (notShown_ > 0)
    out << "not counted: " << notShown_ << " sessions, which show nothing of what was drawn\n";
  if (uncatalogued_) {
    out << unknownText();
  } else if (effects_ > 0) {
    const int missed = hits_.all - hits_.named - hits_.confusable - hits_.besideDrift;
    out << line("first named is one that was hidden", first_, sessions_)
        << line("  of these only listed beside drift", firstBesideDrift_, first_)
        << line("exactly the hidden ones", exact_, sessions_)
        << line("same by ranking correlations", byHand_, sessions_)
        << line("sessions with a wrong cause", withWrong_, sessions_)
        << line("sessions with a formula where none was hidden", formulas_, sessions_)
        << line("sessions with a profile where none was hidden", profiles_, sessions_);
    char wrong[80];
    std::snprintf(wrong, sizeof wrong, "%.3f", sessions_ > 0 ? static_cast<double>(wrong_) / sessions_ : 0.0);
    out << "wrong causes a session: " << wrong << "\nof " << hits_.all << " hidden: named " << hits_.named
        << ", one of at most two rivals " << hits_.confusable << ", listed beside drift " << hits_.besideDrift
        << ", missed " << missed << "\ncauses listed beside drift: " << perhaps_ << " in " << sessions_
        << " sessions\n";
  } else {
    out << line("sessions with anything claimed", claimed_, sessions_)
        << line("sessions with a wrong cause", withWrong_, sessions_)
        << line("sessions with a formula", formulas_, sessions_)
        << line("sessions with a profile", profiles_, sessions_);
  }
  if (oracle_)
    out << line("an oracle would be sure", oracleSure_, sessions_)
        << line("  of these the first named is not right", oracleOnly_, oracleSure_);
  if (!uncatalogued_) out << line("held-out RMS within 5 % of the noise", atNoise_, sessions_);
  char seconds[80];
  std::snprintf(seconds, sizeof seconds, "longest diagnosis %.2f s\n", seconds_);
  out << seconds;
  if (!uncatalogued_ && effects_ > 0) {
    out << "found, by effect:\n";
    for (const auto& [type, h] : byType_)
      out << "  " << padded(type, 26) << wilson(h.named + h.confusable + h.besideDrift, h.all) << "\n";
  }
  return out.str();
}

nlohmann::ordered_json BenchmarkCounts::json() const {
  const auto json = [](const Hits& h) {
    return nlohmann::ordered_json{{"hidden", h.all},
                                  {"named", h.named},
                                  {"confusable", h.confusable},
                                  {"beside_drift", h.besideDrift},
                                  {"missed", h.all - h.named - h.confusable - h.besideDrift}};
  };
  nlohmann::ordered_json out = {{"sessions", sessions_},
                                {"not_shown", notShown_},
                                {"first_right", first_},
                                {"first_beside_drift", firstBesideDrift_},
                                {"exact", exact_},
                                {"exact_by_correlation", byHand_},
                                {"sessions_claimed", claimed_},
                                {"sessions_wrong", withWrong_},
                                {"wrong", wrong_},
                                {"sessions_formula", formulas_},
                                {"sessions_profile", profiles_},
                                {"causes", json(hits_)},
                                {"listed_beside_drift", perhaps_},
                                {"at_noise", atNoise_},
                                {"longest_s", seconds_},
                                {"verdicts", verdicts_}};
  for (const auto& [type, hits] : byType_) out["by_effect"][type] = json(hits);
  if (oracle_) out["oracle"] = {{"sure", oracleSure_}, {"sure_but_not_first", oracleOnly_}};
  if (uncatalogued_) {
    const auto unknown = [](const Unknown& u) {
      return nlohmann::ordered_json{{"sessions", u.all},
                                    {"verdict", u.verdict},
                                    {"variables", u.variables},
                                    {"direction", u.direction},
                                    {"held_out", u.heldOut},
                                    {"everything", u.everything},
                                    {"by_catalogue", u.byCatalogue},
                                    {"formula", u.formula},
                                    {"formula_right", u.formulaRight}};
    };
    out["unknown"] = unknown(unknown_);
    for (const auto& [type, u] : unknownByType_) out["unknown"]["by_kind"][type] = unknown(u);
  }
  out["trials"] = trials_;
  return out;
}

}  // namespace mm
