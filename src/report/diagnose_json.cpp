#include "base/quantity_words.h"
#include "diagnosis/noise_words.h"
#include "diagnosis/wording.h"
#include "report/json.h"
#include "report/json_parts.h"
#include "report/symbols_of.h"

namespace mm {
namespace {

Json confusableJson(const Confusable& c, const Diagnosis& d) {
  return jsonObject({effectInWords(c.effect, symbolsOf(d)),
                     {{"owner", ownerOf(c.effect, d)}, {"delta", c.delta}},
                     oddsJson(c.odds),
                     {{"same", c.same}, {"not_recorded", c.notRecorded}, {"moves", c.moves}}});
}

Json candidateJson(const CandidateResult& c, const Diagnosis& d) {
  const auto parameter = [](const NamedValue& v) { return parameterJson(v.name, v.value, v.std, v.unit); };
  const auto confusable = [&](const Confusable& other) { return confusableJson(other, d); };
  return jsonObject({effectInWords(c.effect, symbolsOf(d)),
                     {{"owner", ownerOf(c.effect, d)}, {"parameters", jsonList(c.parameters, parameter)}},
                     entryIf(hasOpenRivals(c), "one_of_several", true),
                     figureOf(d.angular, "size", c.size),
                     {{"p_value", c.pValue}, {"gain", c.gain}},
                     oddsJson(c.odds),
                     beforeAndAfter(d.angular, "held_out_rms", c.heldOutBefore, c.heldOutAfter),
                     {{"confusable_with", jsonList(c.confusableWith, confusable)}},
                     entryIf(!c.looksTheSame.empty(), "looks_the_same", c.looksTheSame),
                     {{"cause", c.cause}, {"remedy", c.remedy}}});
}

Json possibleJson(const PossibleCause& p, const Diagnosis& d) {
  return jsonObject({effectInWords(p.effect, symbolsOf(d)), oddsJson(p.odds), {{"shown_by", p.shownBy}}});
}

Json profileJson(const ProfileResult& p, const Diagnosis& d) {
  return jsonObject({effectInWords(p.effect, symbolsOf(d)),
                     {{"direction", p.direction},
                      {"variables", p.variables},
                      {"units", p.units},
                      {"unit", nameOfUnit(isAngular(d, p.direction))},
                      {"gain", p.gain}},
                     oddsJson(p.odds),
                     beforeAndAfter(d.angular, "held_out_rms", p.heldOutBefore, p.heldOutAfter),
                     {{"curve", p.curve}}});
}

/// Its keys, without the type that all of them have.
Json formulaJson(const FormulaResult& f, const Diagnosis& d) {
  Json keys = effectJson(f.effect);
  keys.erase("type");
  return jsonObject({keys,
                     {{"in_words", inWords(f.effect)}},
                     beforeAndAfter(d.angular, "held_out_rms", f.heldOutBefore, f.heldOutAfter)});
}

Json driftJson(const DriftResult& drift, const Diagnosis& d) {
  const auto perhaps = [&](const DriftResult::Perhaps& other) {
    return jsonObject(
        {effectInWords(other.effect, symbolsOf(d)), oddsJson(other.odds), {{"share", other.share}}});
  };
  return jsonObject({{{"direction", drift.direction}},
                     figureOf(isAngular(d, drift.direction), "std", drift.std),
                     {{"time_constant_s", drift.timeConstant},
                      {"perhaps", jsonList(drift.perhaps, perhaps)},
                      {"in_words", driftInWords(d, drift)},
                      {"to_do", drift.inWords.empty() ? driftAdvice(drift) : drift.inWords}}});
}

Json scatterJson(const ArtifactScatter& a) {
  return jsonObject({{{"what", a.what}}, figureOf(a.angular, "std", a.std), {{"in_words", a.inWords}}});
}

Json variationJson(const Variation& v, const Diagnosis& d) {
  const ErrorSymbols symbols = symbolsOf(d);
  const auto instead = [&](const Alternative& a) {
    return jsonObject({{{"effect", a.effect.yaml()}, {"in_words", inWords(a.effect)}},
                       symbolJson(a.effect, symbols),
                       oddsJson(a.probability)});
  };
  const bool formula = !v.formula.type.empty();
  return jsonObject({effectInWords(v.effect, symbols),
                     {{"along", v.along}},
                     figureOf(d.angular, "rms", v.rms),
                     figureOf(d.angular, "rms_std", v.std),
                     {{"formula", formula ? Json(v.formula.yaml()) : Json()},
                      {"or_instead", jsonList(v.instead, instead)}}});
}

Json inputJson(const MissingInput& input) {
  return {{"input", input.input},
          {"assumed", input.assumed},
          {"effects", jsonList(input.effects, effectJson)},
          {"in_words", listInWords(input.effects)}};
}

Json hiddenJson(const CannotShow& c, const Diagnosis& d) {
  return jsonObject({effectInWords(c.effect, symbolsOf(d)), {{"why", c.why}, {"moves", c.moves}}});
}

Json moveJson(const Move& move) {
  Json one = Json::object();
  for (const auto& [name, value] : move.values) one[name] = value;
  for (const auto& [name, word] : move.words) one[name] = word;
  for (const auto& [joint, side] : move.from) one["from"][joint] = side;
  if (!move.approach.empty()) one["approach"] = move.approach;
  return one;
}

Json notJudgedJson(const NotJudged& n) {
  return {{"joint", n.joint}, {"observations", n.observations}, {"direction_known", n.directionKnown}};
}

}  // namespace

Json diagnosisJson(const Diagnosis& d) {
  const bool fitted = d.base.problem != nullptr;
  const double repeatability = fitted ? d.base.repeatability : kNotMeasured;
  const auto found = [](double value) { return value > 0.0 ? value : kNotMeasured; };
  const auto each = [&d](const auto& list, auto entry) {
    return jsonList(list, [&](const auto& one) { return entry(one, d); });
  };
  const Json tests =
      testsJson(fitted ? standardTests(d.base.problem->session()) : std::vector<StandardTest>());
  return jsonObject(
      {{{"observations", fitted ? Json(d.base.problem->session().observations.size()) : Json()}},
       {{"tests", tests}},
       underUnit(d.angular, "repeatability", repeatability / unitOf(d.angular)),
       {{"repeatability_from", d.base.repeatabilityFrom}},
       figuresJson(d.base.figures, true),
       figureOf(d.angular, "held_out_rms_without_found", found(d.heldOutBefore)),
       figureOf(d.angular, "held_out_rms_with_found", found(d.heldOut)),
       figureOf(d.angular, "noise", found(d.noise)),
       figureOf(d.angular, "noise_std", found(d.noiseStd)),
       d.resolution > 0.0 ? figureOf(d.angular, "resolution", d.resolution) : Json(),
       entryIf(!d.notJudged.empty(), "not_judged", jsonList(d.notJudged, notJudgedJson)),
       entryIf(d.outliers.readings > 0, "outliers", d.outliers.readings),
       entryIf(d.outliers.readings > 0, "outliers_in_words", outliersInWords(d)),
       entryIf(d.asked < d.residuals, "residuals_asked", d.asked),
       {{"chains_differ", d.chainsDiffer},
        {"tail_dof", found(d.tailDof)},
        {"chi2_per_dof", orNull(fitted, d.base.figures.chi2PerDof)},
        {"verdict", nameOf(d.verdict)},
        {"sentence", d.sentence},
        {"where", whereJson(d.where)},
        {"missing", each(d.missing, candidateJson)},
        {"possible", each(d.possible, possibleJson)},
        {"candidates", each(d.candidates, candidateJson)},
        {"profiles", each(d.profiles, profileJson)},
        {"formulas", each(d.formulas, formulaJson)},
        {"drift", each(d.drift, driftJson)},
        {"artifact_scatter", jsonList(d.artifactScatter, scatterJson)},
        {"variations", each(d.variations, variationJson)},
        {"missing_inputs", jsonList(d.missingInputs, inputJson)},
        {"cannot_show", each(d.cannotShow, hiddenJson)},
        {"next_measurement", jsonList(d.nextMeasurement, moveJson)}},
       entryIf(!d.moveChange.empty(), "next_measurement_change", d.moveChange)});
}

std::string diagnoseJson(const Diagnosis& d) { return jsonText(diagnosisJson(d)); }

}  // namespace mm
