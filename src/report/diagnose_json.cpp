#include "base/units.h"
#include "diagnosis/noise_words.h"
#include "diagnosis/wording.h"
#include "report/json.h"
#include "report/json_parts.h"

namespace mm {
namespace {

using Json = nlohmann::ordered_json;

void setEffect(Json& object, const EffectSpec& effect) {
  object["effect"] = effectJson(effect);
  object["in_words"] = inWords(effect);
}

void setOdds(Json& object, double probability) {
  object["odds"] = number(probability);
  object["odds_in_words"] = oddsInWords(probability);
}

Json candidateJson(const CandidateResult& c, const Diagnosis& d) {
  const bool angular = d.angular;
  Json one;
  setEffect(one, c.effect);
  one["owner"] = ownerOf(c.effect, d);
  one["parameters"] = Json::array();
  for (const NamedValue& v : c.parameters) {
    Json p;
    p["name"] = v.name;
    p["value"] = number(v.value);
    p["std"] = number(v.std);
    p["unit"] = v.unit;
    one["parameters"].push_back(std::move(p));
  }
  setEither(one, "size", c.size, angular);
  one["p_value"] = number(c.pValue);
  one["gain"] = number(c.gain);
  setOdds(one, c.odds);
  setPair(one, "held_out_rms", c.heldOutBefore, c.heldOutAfter, angular);
  one["confusable_with"] = Json::array();
  for (const Confusable& other : c.confusableWith) {
    Json o;
    setEffect(o, other.effect);
    o["owner"] = ownerOf(other.effect, d);
    o["delta"] = number(other.delta);
    setOdds(o, other.odds);
    o["same"] = other.same;
    o["not_recorded"] = other.notRecorded;
    o["moves"] = other.moves;
    one["confusable_with"].push_back(std::move(o));
  }
  if (!c.looksTheSame.empty()) one["looks_the_same"] = c.looksTheSame;
  one["cause"] = c.cause;
  one["remedy"] = c.remedy;
  return one;
}

Json profileJson(const ProfileResult& p, const Diagnosis& d) {
  Json one;
  setEffect(one, p.effect);
  one["direction"] = p.direction;
  one["variables"] = p.variables;
  one["units"] = p.units;
  one["unit"] = isAngular(d, p.direction) ? "arcsec" : "um";
  one["gain"] = number(p.gain);
  setOdds(one, p.odds);
  setPair(one, "held_out_rms", p.heldOutBefore, p.heldOutAfter, d.angular);
  one["curve"] = Json::array();
  for (const std::vector<double>& point : p.curve) {
    Json values = Json::array();
    for (const double v : point) values.push_back(number(v));
    one["curve"].push_back(std::move(values));
  }
  return one;
}

Json driftJson(const DriftResult& drift, const Diagnosis& d) {
  Json one;
  one["direction"] = drift.direction;
  setEither(one, "std", drift.std, isAngular(d, drift.direction));
  one["time_constant_s"] = number(drift.timeConstant);
  one["perhaps"] = Json::array();
  for (const DriftResult::Perhaps& other : drift.perhaps) {
    Json o;
    setEffect(o, other.effect);
    setOdds(o, other.odds);
    o["share"] = number(other.share);
    one["perhaps"].push_back(std::move(o));
  }
  one["in_words"] = driftInWords(d, drift);
  one["to_do"] = drift.inWords.empty() ? driftAdvice(drift) : drift.inWords;
  return one;
}

Json inputJson(const MissingInput& input) {
  Json one;
  one["input"] = input.input;
  one["assumed"] = input.assumed;
  one["effects"] = Json::array();
  for (const EffectSpec& effect : input.effects) one["effects"].push_back(effectJson(effect));
  one["in_words"] = listInWords(input.effects);
  return one;
}

Json moveJson(const Move& move) {
  Json one = Json::object();
  for (const auto& [name, value] : move.values) one[name] = number(value);
  for (const auto& [name, word] : move.words) one[name] = word;
  if (!move.from.empty()) {
    one["from"] = Json::object();
    for (const auto& [joint, side] : move.from) one["from"][joint] = number(side);
  }
  if (!move.approach.empty()) {
    one["approach"] = Json::array();
    for (double a : move.approach) one["approach"].push_back(number(a));
  }
  return one;
}

}  // namespace

std::string diagnoseJson(const Diagnosis& d) {
  const bool fitted = d.base.problem != nullptr;
  Json object;
  object["observations"] = fitted ? Json(d.base.problem->session().observations.size()) : Json(nullptr);
  const double repeatability = fitted ? d.base.repeatability : kNotMeasured;
  object["repeatability_um"] = d.angular ? Json(nullptr) : number(repeatability / kMicrometre);
  if (d.angular) object["repeatability_arcsec"] = number(repeatability / kArcsecond);
  object["repeatability_from"] = d.base.repeatabilityFrom;
  setFigures(object, d.base.figures, true);
  const auto found = [](double value) { return value > 0.0 ? value : kNotMeasured; };
  setEither(object, "held_out_rms_without_found", found(d.heldOutBefore), d.angular);
  setEither(object, "held_out_rms_with_found", found(d.heldOut), d.angular);
  setEither(object, "noise", found(d.noise), d.angular);
  setEither(object, "noise_std", found(d.noiseStd), d.angular);
  if (d.resolution > 0.0) setEither(object, "resolution", d.resolution, d.angular);
  for (const NotJudged& n : d.notJudged)
    object["not_judged"].push_back({{"joint", n.joint}, {"observations", n.observations}});
  if (d.asked < d.residuals) object["residuals_asked"] = d.asked;
  object["chains_differ"] = number(d.chainsDiffer);
  object["tail_dof"] = number(found(d.tailDof));
  object["chi2_per_dof"] = fitted ? number(d.base.figures.chi2PerDof) : Json(nullptr);
  object["verdict"] = nameOf(d.verdict);
  object["sentence"] = d.sentence;
  object["where"] = whereJson(d.where);
  object["missing"] = Json::array();
  for (const CandidateResult& c : d.missing) object["missing"].push_back(candidateJson(c, d));
  object["candidates"] = Json::array();
  for (const CandidateResult& c : d.candidates) object["candidates"].push_back(candidateJson(c, d));
  object["profiles"] = Json::array();
  for (const ProfileResult& p : d.profiles) object["profiles"].push_back(profileJson(p, d));
  object["formulas"] = Json::array();
  for (const FormulaResult& f : d.formulas) {
    Json one = effectJson(f.effect);
    one.erase("type");
    one["in_words"] = inWords(f.effect);
    setPair(one, "held_out_rms", f.heldOutBefore, f.heldOutAfter, d.angular);
    object["formulas"].push_back(std::move(one));
  }
  object["drift"] = Json::array();
  for (const DriftResult& drift : d.drift) object["drift"].push_back(driftJson(drift, d));
  object["artifact_scatter"] = Json::array();
  for (const ArtifactScatter& a : d.artifactScatter)
    object["artifact_scatter"].push_back(
        Json{{"what", a.what}, {"std_um", number(a.std / kMicrometre)}, {"in_words", a.inWords}});
  object["variations"] = Json::array();
  for (const Variation& v : d.variations) {
    Json one;
    setEffect(one, v.effect);
    one["in_words"] = inWords(v.effect);
    one["along"] = v.along;
    setEither(one, "rms", v.rms, d.angular);
    setEither(one, "rms_std", v.std, d.angular);
    one["formula"] = v.formula.type.empty() ? Json(nullptr) : Json(v.formula.yaml());
    one["or_instead"] = Json::array();
    for (const Alternative& a : v.instead)
      one["or_instead"].push_back(Json{{"effect", a.effect.yaml()},
                                       {"in_words", inWords(a.effect)},
                                       {"odds", number(a.probability)},
                                       {"odds_in_words", oddsInWords(a.probability)}});
    object["variations"].push_back(std::move(one));
  }
  object["missing_inputs"] = Json::array();
  for (const MissingInput& input : d.missingInputs) object["missing_inputs"].push_back(inputJson(input));
  object["cannot_show"] = Json::array();
  for (const CannotShow& c : d.cannotShow) {
    Json one;
    setEffect(one, c.effect);
    one["why"] = c.why;
    one["moves"] = c.moves;
    object["cannot_show"].push_back(std::move(one));
  }
  object["next_measurement"] = Json::array();
  for (const Move& m : d.nextMeasurement) object["next_measurement"].push_back(moveJson(m));
  if (!d.moveChange.empty()) object["next_measurement_change"] = d.moveChange;
  return dump(object);
}

}  // namespace mm
