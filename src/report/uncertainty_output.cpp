#include "report/uncertainty_output.h"

#include <algorithm>
#include <cmath>

#include "base/quantity_words.h"
#include "base/units.h"
#include "report/json_parts.h"
#include "report/text_parts.h"

namespace mm {
namespace {

Json intervalJson(double lower, double upper) { return {lower / kMillimetre, upper / kMillimetre}; }

Json quantityFigures(const QuantityUncertainty& q) {
  const auto share = [](const UncertaintyShare& s) -> Json {
    return {{"source", s.source}, {"share", s.share}, {"std_um", s.std / kMicrometre}};
  };
  return {{"nominal_mm", q.quantity.nominal / kMillimetre},
          {"mean_mm", q.mean / kMillimetre},
          {"std_um", q.std / kMicrometre},
          {"k2_um", 2.0 * q.std / kMicrometre},
          {"interval_mm", intervalJson(q.lower, q.upper)},
          {"budget", jsonList(q.budget, share)}};
}

Json verdictJson(const TaskVerdict& v) {
  std::string word = nameOf(v.conformity);
  std::replace(word.begin(), word.end(), ' ', '_');
  return {
      {"of", v.of},
      {"verdict", word},
      {"value_mm", v.value / kMillimetre},
      {"std_um", v.std / kMicrometre},
      {"limits_mm", intervalJson(v.limits.lower, v.limits.upper)},
      {"acceptance_mm", orNull(v.acceptance.exists, intervalJson(v.acceptance.lower, v.acceptance.upper))},
      {"probability", v.probability},
      {"rule", "ISO 14253-1:2017, 95 %"},
      {"in_words", v.inWords}};
}

std::string figureLine(const QuantityUncertainty& q) {
  return figureOf(q) + ", U = " + twoDigits(2.0 * q.std / kMicrometre) + " um (k = 2)";
}

std::string budgetText(const QuantityUncertainty& q) {
  if (q.budget.empty()) return "The calibration contains no source of uncertainty.\n";
  std::string text = "Variance by cause:\n";
  for (const UncertaintyShare& s : q.budget)
    if (s.share >= 0.0005)
      text += format("  %5.1f %%  ", 100.0 * s.share) + s.source +
              " (alone: u = " + twoDigits(s.std / kMicrometre) + " um)\n";
  return text;
}

}  // namespace

int decimalsOf(double expanded, int otherwise) {
  return positive(expanded) ? std::clamp(1 - static_cast<int>(std::floor(std::log10(expanded))), 0, 9)
                            : otherwise;
}

std::string decimalText(double value, int decimals) {
  const std::string text = format("%.*f", decimals, value);
  return text.find_first_of("123456789") == std::string::npos && text[0] == '-' ? text.substr(1) : text;
}

std::string millimetres(double value, double std) {
  return decimalText(value / kMillimetre, decimalsOf(std / kMillimetre, 6));
}

std::string twoDigits(double value) {
  return positive(value) ? decimalText(value, decimalsOf(value)) : format("%g", value);
}

std::string figureOf(const QuantityUncertainty& q) {
  return q.quantity.oneSided ? format("%.3g um", q.mean / kMicrometre) : millimetres(q.mean, q.std) + " mm";
}

std::string uncertaintyJson(const TaskUncertainty& result, const std::vector<TaskVerdict>& verdicts,
                            const Calibration& calibration) {
  const QuantityUncertainty& headline = result.quantities[result.headline];
  const auto quantity = [](const QuantityUncertainty& q) {
    return jsonObject({{{"name", q.quantity.name}}, quantityFigures(q)});
  };
  const std::vector<TestLength> lengths = testLengthsOf(result);
  Json permissible;
  if (lengths.size() > 1) {
    const PermissibleError least = permissibleFor(lengths);
    permissible = {{"permissible", {{"a_um", least.a}, {"k", least.k}, {"in_words", least.inWords()}}}};
  }
  return jsonText(jsonObject({{{"task", result.task}, {"quantity", headline.quantity.name}},
                              quantityFigures(headline),
                              {{"calibration_id", calibration.id},
                               {"seed", result.seed},
                               {"trials", result.trials},
                               {"digits", orNull(result.digits > 0, result.digits)},
                               {"stable", result.stable},
                               {"valid", result.outside.empty()},
                               {"reasons", result.outside},
                               {"notes", result.notes},
                               {"quantities", jsonList(result.quantities, quantity)}},
                              permissible,
                              {{"decisions", jsonList(verdicts, verdictJson)}}}));
}

std::string uncertaintyText(const TaskUncertainty& result, const std::vector<TaskVerdict>& verdicts) {
  const QuantityUncertainty& headline = result.quantities[result.headline];
  std::string text = result.task + "\n" + headline.quantity.name + ": " + figureLine(headline) + "\n";
  text += "Standard uncertainty " + twoDigits(headline.std / kMicrometre) + " um; 95 % between " +
          millimetres(headline.lower, headline.std) + " and " + millimetres(headline.upper, headline.std) +
          " mm; " + std::to_string(result.trials) + " trials, seed " + std::to_string(result.seed) + "\n";
  if (!result.stable)
    text += wrapped("", "The last digit is not stable yet: give more --trials, or --digits 1.");
  text += budgetText(headline);
  const std::vector<TestLength> lengths = testLengthsOf(result);
  if (lengths.size() > 1) {
    text += wrapped("", "Each length individually satisfies |E| + U within " +
                            permissibleFor(lengths).inWords() + " (L in mm).");
    if (const QuantityUncertainty* probing = probingOf(result))
      text += probing->quantity.name + ": " + figureLine(*probing) + "\n";
  } else {
    for (std::size_t q = 0; q < result.quantities.size(); ++q)
      if (q != result.headline)
        text += result.quantities[q].quantity.name + ": " + figureLine(result.quantities[q]) + "\n";
  }
  for (const TaskVerdict& v : verdicts) text += wrapped("ISO 14253-1: ", v.inWords);
  return text;
}

}  // namespace mm
