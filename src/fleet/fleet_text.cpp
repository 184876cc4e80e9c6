#include <cmath>

#include "base/format.h"
#include "base/json_text.h"
#include "base/number_text.h"
#include "fleet/fleet.h"

namespace mm {
namespace {

const char* kindOf(const Trend& trend) {
  return trend.kind == Trend::Kind::kDrift ? "drift" : trend.kind == Trend::Kind::kSteps ? "steps" : "quiet";
}

Json seriesJson(const FleetSeries& s, bool everything) {
  const auto segment = [&](const TrendSegment& part) -> Json {
    return {{"from", s.dates[part.first]},
            {"to", s.dates[part.end - 1]},
            {"level", part.level},
            {"std", part.std}};
  };
  Json json = {{"machine", s.machine},
               {"quantity", s.quantity},
               {"unit", s.unit},
               {"sessions", s.points.size()},
               {"trend", kindOf(s.trend)},
               {"p_value", s.trend.p},
               {"scatter", s.trend.scatter},
               {"slope_a_year", 365.25 * s.trend.slope},
               {"slope_std_a_year", 365.25 * s.trend.slopeStd},
               {"segments", jsonList(s.trend.segments, segment)}};
  if (!everything) return json;
  json["points"] = Json::array();
  for (std::size_t i = 0; i < s.points.size(); ++i)
    json["points"].push_back({s.dates[i], s.points[i].value, s.points[i].std});
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
        "No findings: no machine changed, drifts or differs from the others by more than chance would "
        "produce.\n";
  for (const Finding& f : fleet.findings) text += f.inWords + "\n";
  text += format("\n%.0f tests were made; the false alarm probability of the whole fleet is %.3g.\n",
                 fleet.questions, fleet.alarm);
  return text;
}

std::string fleetJson(const Fleet& fleet, bool everything) {
  const auto finding = [](const Finding& f) -> Json {
    return {{"kind", f.kind}, {"machine", f.machine}, {"quantity", f.quantity}, {"unit", f.unit},
            {"date", f.date}, {"before", f.before},   {"after", f.after},       {"k2", 2.0 * f.std},
            {"p_value", f.p}, {"in_words", f.inWords}};
  };
  const auto failure = [](const FleetRecord& r) -> Json {
    return {{"machine", r.machine}, {"session", r.session}, {"step", r.result.failed}, {"why", r.result.why}};
  };
  const auto series = [&](const FleetSeries& s) { return seriesJson(s, everything); };
  return jsonText({{"folder", fleet.source},
                   {"model", fleet.model},
                   {"other_models", fleet.otherModels},
                   {"done", fleet.done},
                   {"failed", fleet.failed},
                   {"waiting", fleet.waiting},
                   {"not_converged", fleet.open},
                   {"machines", fleet.machines},
                   {"questions", fleet.questions},
                   {"alarm", fleet.alarm},
                   {"findings", jsonList(fleet.findings, finding)},
                   {"failures", jsonList(fleet.failures, failure)},
                   {"series", jsonList(fleet.series, series)}});
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
