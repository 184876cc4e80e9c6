#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "base/format.h"
#include "base/json_number.h"
#include "base/number_text.h"
#include "fleet/fleet.h"

namespace mm {
namespace {

using OrderedJson = nlohmann::ordered_json;

const char* kindOf(const Trend& trend) {
  return trend.kind == Trend::Kind::kDrift ? "drift" : trend.kind == Trend::Kind::kSteps ? "steps" : "quiet";
}

OrderedJson seriesJson(const FleetSeries& s, bool everything) {
  OrderedJson segments = OrderedJson::array(), points = OrderedJson::array();
  for (const TrendSegment& part : s.trend.segments)
    segments.push_back({{"from", s.dates[part.first]},
                        {"to", s.dates[part.end - 1]},
                        {"level", number(part.level)},
                        {"std", number(part.std)}});
  OrderedJson json = {{"machine", s.machine},
                      {"quantity", s.quantity},
                      {"unit", s.unit},
                      {"sessions", s.points.size()},
                      {"trend", kindOf(s.trend)},
                      {"p_value", number(s.trend.p)},
                      {"scatter", number(s.trend.scatter)},
                      {"slope_a_year", number(365.25 * s.trend.slope)},
                      {"slope_std_a_year", number(365.25 * s.trend.slopeStd)},
                      {"segments", segments}};
  if (!everything) return json;
  for (std::size_t i = 0; i < s.points.size(); ++i)
    points.push_back({s.dates[i], number(s.points[i].value), number(s.points[i].std)});
  json["points"] = points;
  return json;
}

/// A cell of a CSV: in quotes where it holds a comma, a quote or a line break.
std::string cell(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

std::string numberCell(double value) { return std::isfinite(value) ? numberText(value) : std::string(); }

}  // namespace

std::string fleetText(const Fleet& fleet) {
  std::string text = format("%zu machines, %ld sessions", fleet.machines.size(), fleet.done);
  if (fleet.failed > 0) text += format(", %ld jobs failed", fleet.failed);
  if (fleet.waiting > 0) text += format(", %ld jobs wait", fleet.waiting);
  if (fleet.open > 0) text += format(", %ld fits did not converge and are not used", fleet.open);
  text += "\n";
  if (!fleet.model.empty()) text += "model         " + fleet.model + "\n";
  for (const std::string& other : fleet.otherModels) text += "also there    " + other + "; --model chooses\n";
  for (const FleetRecord& r : fleet.failures)
    text +=
        "failed        " + r.machine + ", " + r.session + ": " + r.result.failed + ": " + r.result.why + "\n";
  text += "\n";
  if (fleet.findings.empty())
    text +=
        "Nothing stands out: no machine changed, drifts or differs from its sisters by more than chance "
        "gives.\n";
  for (const Finding& f : fleet.findings) text += f.inWords + "\n";
  text += format("\n%.0f questions were asked; the chance that a quiet fleet gives any finding is %.3g.\n",
                 fleet.questions, fleet.alarm);
  return text;
}

std::string fleetJson(const Fleet& fleet, bool everything) {
  OrderedJson json = {
      {"folder", fleet.source},      {"model", fleet.model},       {"other_models", fleet.otherModels},
      {"done", fleet.done},          {"failed", fleet.failed},     {"waiting", fleet.waiting},
      {"not_converged", fleet.open}, {"machines", fleet.machines}, {"questions", fleet.questions},
      {"alarm", fleet.alarm}};
  json["findings"] = OrderedJson::array();
  for (const Finding& f : fleet.findings)
    json["findings"].push_back({{"kind", f.kind},
                                {"machine", f.machine},
                                {"quantity", f.quantity},
                                {"unit", f.unit},
                                {"date", f.date},
                                {"before", number(f.before)},
                                {"after", number(f.after)},
                                {"p_value", number(f.p)},
                                {"in_words", f.inWords}});
  json["failures"] = OrderedJson::array();
  for (const FleetRecord& r : fleet.failures)
    json["failures"].push_back(
        {{"machine", r.machine}, {"session", r.session}, {"step", r.result.failed}, {"why", r.result.why}});
  json["series"] = OrderedJson::array();
  for (const FleetSeries& s : fleet.series) json["series"].push_back(seriesJson(s, everything));
  return json.dump(2, ' ', false, OrderedJson::error_handler_t::replace);
}

std::string fleetCsv(const Fleet& fleet) {
  std::string text =
      "machine,serial,date,session,model,verdict,rms_um,held_out_rms_um,chi2_per_dof,verified,software,"
      "effect,"
      "parameter,unit,value,std,fixed\n";
  for (const FleetRecord& r : fleet.records) {
    const JobResult& j = r.result;
    const std::string head = cell(r.machine) + "," + cell(j.serial) + "," + r.date + "," + cell(r.session) +
                             "," + cell(r.model) + "," + j.verdict + "," + numberCell(j.rms) + "," +
                             numberCell(j.heldOutRms) + "," + numberCell(j.chi2PerDof) + "," + j.verified +
                             "," + j.software + ",";
    if (j.parameters.empty()) text += head + ",,,,,\n";
    for (const FleetParameter& p : j.parameters)
      text += head + cell(p.effect) + "," + cell(p.name) + "," + cell(p.unit) + "," + numberCell(p.value) +
              "," + numberCell(p.std) + "," + (p.fixed ? "1" : "0") + "\n";
  }
  return text;
}

}  // namespace mm
