#include "machine/units.h"
#include "report/json.h"
#include "report/json_parts.h"

namespace mm {
namespace {

using Json = nlohmann::ordered_json;

Json candidateJson(const CandidateResult& c, bool angular) {
  Json one;
  one["effect"] = effectJson(c.effect);
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
  one["odds"] = number(c.odds);
  setPair(one, "held_out_rms", c.heldOutBefore, c.heldOutAfter, angular);
  one["confusable_with"] = Json::array();
  for (const Confusable& other : c.confusableWith) {
    Json o;
    o["effect"] = effectJson(other.effect);
    o["delta"] = number(other.delta);
    one["confusable_with"].push_back(std::move(o));
  }
  one["cause"] = c.cause;
  one["remedy"] = c.remedy;
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
  object["chi2_per_dof"] = fitted ? number(d.base.figures.chi2PerDof) : Json(nullptr);
  object["verdict"] = nameOf(d.verdict);
  object["sentence"] = d.sentence;
  object["where"] = whereJson(d.where);
  object["missing"] = Json::array();
  for (const CandidateResult& c : d.missing) object["missing"].push_back(candidateJson(c, d.angular));
  object["candidates"] = Json::array();
  for (const CandidateResult& c : d.candidates) object["candidates"].push_back(candidateJson(c, d.angular));
  object["formulas"] = Json::array();
  for (const FormulaResult& f : d.formulas) {
    Json one = effectJson(f.effect);
    one.erase("type");
    setPair(one, "held_out_rms", f.heldOutBefore, f.heldOutAfter, d.angular);
    object["formulas"].push_back(std::move(one));
  }
  object["cannot_show"] = Json::array();
  for (const CannotShow& c : d.cannotShow) {
    Json one;
    one["effect"] = effectJson(c.effect);
    one["why"] = c.why;
    one["moves"] = c.moves;
    object["cannot_show"].push_back(std::move(one));
  }
  object["next_measurement"] = Json::array();
  for (const Move& m : d.nextMeasurement) object["next_measurement"].push_back(moveJson(m));
  return dump(object);
}

}  // namespace mm
