#include "report/uncertainty_output.h"

#include <algorithm>
#include <cmath>

#include "base/units.h"
#include "report/json_parts.h"
#include "report/text_parts.h"

namespace mm {
namespace {

using ResultJson = nlohmann::ordered_json;

ResultJson pairJson(double lower, double upper) {
  return ResultJson::array({number(lower / kMillimetre), number(upper / kMillimetre)});
}

ResultJson budgetJson(const std::vector<UncertaintyShare>& budget) {
  ResultJson out = ResultJson::array();
  for (const UncertaintyShare& s : budget)
    out.push_back(
        {{"source", s.source}, {"share", number(s.share)}, {"std_um", number(s.std / kMicrometre)}});
  return out;
}

void addFigures(const QuantityUncertainty& q, ResultJson& out) {
  out["nominal_mm"] = number(q.quantity.nominal / kMillimetre);
  out["mean_mm"] = number(q.mean / kMillimetre);
  out["std_um"] = number(q.std / kMicrometre);
  out["k2_um"] = number(2.0 * q.std / kMicrometre);
  out["interval_mm"] = pairJson(q.lower, q.upper);
  out["budget"] = budgetJson(q.budget);
}

ResultJson verdictJson(const TaskVerdict& v) {
  std::string word = nameOf(v.conformity);
  std::replace(word.begin(), word.end(), ' ', '_');
  return {{"of", v.of},
          {"verdict", word},
          {"value_mm", number(v.value / kMillimetre)},
          {"std_um", number(v.std / kMicrometre)},
          {"limits_mm", pairJson(v.limits.lower, v.limits.upper)},
          {"acceptance_mm",
           v.acceptance.exists ? pairJson(v.acceptance.lower, v.acceptance.upper) : ResultJson()},
          {"probability", number(v.probability)},
          {"rule", "ISO 14253-1:2017, 95 %"},
          {"in_words", v.inWords}};
}

std::string figureLine(const QuantityUncertainty& q) {
  return figureOf(q) + ", U = " + twoDigits(2.0 * q.std / kMicrometre) + " um (k = 2)";
}

std::string budgetText(const QuantityUncertainty& q) {
  std::string text;
  if (q.budget.empty()) return "Nothing that the calibration knows makes it uncertain.\n";
  text += "Variance by cause:\n";
  for (const UncertaintyShare& s : q.budget)
    if (s.share >= 0.0005)
      text += format("  %5.1f %%  ", 100.0 * s.share) + s.source +
              " (alone: u = " + twoDigits(s.std / kMicrometre) + " um)\n";
  return text;
}

}  // namespace

std::string millimetres(double value, double std) {
  const double in = std / kMillimetre;
  const int digits = in > 0.0 ? std::clamp(1 - static_cast<int>(std::floor(std::log10(in))), 0, 9) : 6;
  const std::string text = format("%.*f", digits, value / kMillimetre);
  return text.find_first_of("123456789") == std::string::npos && text[0] == '-' ? text.substr(1) : text;
}

std::string twoDigits(double value) {
  if (!(value > 0.0) || !std::isfinite(value)) return format("%g", value);
  return format("%.*f", std::clamp(1 - static_cast<int>(std::floor(std::log10(value))), 0, 9), value);
}

std::string figureOf(const QuantityUncertainty& q) {
  return q.quantity.oneSided ? format("%.3g um", q.mean / kMicrometre) : millimetres(q.mean, q.std) + " mm";
}

std::string uncertaintyJson(const TaskUncertainty& result, const std::vector<TaskVerdict>& verdicts,
                            const Calibration& calibration) {
  ResultJson out;
  const QuantityUncertainty& headline = result.quantities[result.headline];
  out["task"] = result.task;
  out["quantity"] = headline.quantity.name;
  addFigures(headline, out);
  out["calibration_id"] = calibration.id;
  out["seed"] = result.seed;
  out["trials"] = result.trials;
  out["digits"] = result.digits > 0 ? ResultJson(result.digits) : ResultJson();
  out["stable"] = result.stable;
  out["valid"] = result.outside.empty();
  out["reasons"] = result.outside;
  out["notes"] = result.notes;
  out["quantities"] = ResultJson::array();
  for (const QuantityUncertainty& q : result.quantities) {
    ResultJson one;
    one["name"] = q.quantity.name;
    addFigures(q, one);
    out["quantities"].push_back(std::move(one));
  }
  if (const std::vector<TestLength> lengths = testLengthsOf(result); lengths.size() > 1) {
    const PermissibleError least = permissibleFor(lengths);
    out["permissible"] = {{"a_um", number(least.a)}, {"k", number(least.k)}, {"in_words", least.inWords()}};
  }
  out["decisions"] = ResultJson::array();
  for (const TaskVerdict& v : verdicts) out["decisions"].push_back(verdictJson(v));
  return out.dump(2, ' ', false, nlohmann::json::error_handler_t::replace);
}

std::string uncertaintyText(const TaskUncertainty& result, const std::vector<TaskVerdict>& verdicts) {
  const QuantityUncertainty& headline = result.quantities[result.headline];
  std::string text = result.task + "\n" + headline.quantity.name + ": " + figureLine(headline) + "\n";
  text += "Standard uncertainty " + twoDigits(headline.std / kMicrometre) + " um; 95 % between " +
          millimetres(headline.lower, headline.std) + " and " + millimetres(headline.upper, headline.std) +
          " mm; " + std::to_string(result.trials) + " trials, seed " + std::to_string(result.seed) + "\n";
  if (!result.stable)
    text += wrapped("", "The last digit is not stable yet: state more --trials, or --digits 1.");
  text += budgetText(headline);
  const std::vector<TestLength> lengths = testLengthsOf(result);
  if (lengths.size() > 1) {
    text += wrapped("", "Each length, for itself, keeps |E| + U within " + permissibleFor(lengths).inWords() +
                            " (L in mm).");
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
