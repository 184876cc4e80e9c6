#include "report/trend_page.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "base/format.h"
#include "base/quantity_words.h"
#include "base/utc_now.h"
#include "effects/effect_words.h"
#include "report/json_parts.h"
#include "report/report_page.h"
#include "report/text_parts.h"
#include "report/web_files.h"

namespace mm {
namespace {

constexpr double kMonth = 30.0;  // days

Json trendObject(const ParameterTrend& t) {
  const auto point = [](const ParameterPoint& p) -> Json {
    return {{"id", p.id},       {"created", p.created}, {"measured", p.measured},
            {"value", p.value}, {"k2", 2.0 * p.std},    {"comparable", p.comparable}};
  };
  return {{"effect", effectJson(t.effect)},
          {"effect_in_words", inWords(t.effect)},
          {"name", t.name},
          {"unit", t.unit},
          {"points", jsonList(t.points, point)},
          {"change", t.change},
          {"change_k2", 2.0 * t.changeStd},
          {"per_30_days", kMonth * t.slope},
          {"per_30_days_k2", 2.0 * kMonth * t.slopeStd},
          {"p_value", t.pValue},
          {"significant", t.significant},
          {"in_words", t.inWords}};
}

Json trendObjects(const std::vector<ParameterTrend>& trends, const std::string& store,
                  const std::vector<std::string>& left) {
  return {{"store", store},
          {"in_words", trendSentence(trends)},
          {"trends", jsonList(trends, trendObject)},
          {"left_out", left}};
}

/// Significant ones first, the most certain at the top.
std::vector<ParameterTrend> sorted(std::vector<ParameterTrend> trends) {
  std::stable_sort(trends.begin(), trends.end(),
                   [](const ParameterTrend& a, const ParameterTrend& b) { return a.pValue < b.pValue; });
  return trends;
}

std::string figure(double value, double std, const std::string& unit) {
  return std::isfinite(value) ? expanded(value, std, unit) : "-";
}

}  // namespace

std::string trendSentence(const std::vector<ParameterTrend>& trends) {
  std::vector<std::string> said;
  std::size_t points = 0;
  for (const ParameterTrend& t : sorted(trends)) {
    points = std::max(points, t.points.size());
    if (t.significant) said.push_back(t.inWords);
  }
  if (trends.empty()) return "No calibration is stored, so there is no trend.";
  constexpr std::size_t kFewest = 3;
  if (points < kFewest)
    return points == 1 ? "One calibration is stored: a trend needs three."
                       : "Two calibrations are stored: a trend needs three; compare these with --compare.";
  if (std::none_of(trends.begin(), trends.end(),
                   [](const ParameterTrend& t) { return std::isfinite(t.slope); }))
    return format(
        "No trend can be determined: the %zu calibrations are of less than a day, or their ranges are not "
        "comparable; compare two with --compare.",
        points);
  if (said.empty())
    return format("None of %zu parameters has a significant trend over %zu calibrations.", trends.size(),
                  points);
  std::string text =
      format("%zu of %zu parameters have a significant trend over %zu calibrations: ", said.size(),
             trends.size(), points);
  for (std::size_t i = 0; i < said.size() && i < 3; ++i) text += (i > 0 ? "; " : "") + said[i];
  return text + (said.size() > 3 ? "; and others." : ".");
}

std::string trendJson(const std::vector<ParameterTrend>& trends, const std::string& store,
                      const std::vector<std::string>& left) {
  return jsonText(trendObjects(trends, store, left));
}

std::string trendText(const std::vector<ParameterTrend>& trends) {
  std::ostringstream out;
  out << trendSentence(trends) << "\n\n";
  out << format("  %-46s %5s  %-24s %s\n", "parameter", "times", "last", "in 30 days (k = 2)");
  for (const ParameterTrend& t : sorted(trends)) {
    const ParameterPoint& last = t.points.back();
    out << format("%s %-46s %5zu  %-24s %s\n", t.significant ? "*" : " ",
                  (inWords(t.effect) + ", " + t.name).c_str(), t.points.size(),
                  figure(last.value, last.std, t.unit).c_str(),
                  figure(kMonth * t.slope, kMonth * t.slopeStd, t.unit).c_str());
  }
  out << "  * significant: p < 1 % for all parameters together\n";
  return out.str();
}

std::string trendPage(const std::vector<ParameterTrend>& trends, const std::string& store,
                      const std::vector<std::string>& left, const std::string& machine,
                      const std::filesystem::path& plotly) {
  ReportFiles files = loadReportFiles(plotly);
  files.js = webFile("text_parts.js") + webFile("report_parts.js") + webFile("report_plots.js") +
             webFile("trend.js");
  Json data = trendObjects(sorted(trends), store, left);
  data["machine"] = machine;
  data["created"] = utcNow();
  return filledPage(files,
                    {"Trend of " + machine, trendSentence(trends), "mm history --trend", jsonText(data)});
}

std::string changesText(const CalibrationChanges& c) {
  std::ostringstream out;
  out << c.before << (c.beforeTime.empty() ? "" : " (" + c.beforeTime + ")") << " -> " << c.after
      << (c.afterTime.empty() ? "" : " (" + c.afterTime + ")") << "\n"
      << c.inWords << "\n\n";
  out << format("  %-42s %-22s %-22s %-22s %s\n", "parameter", "before", "after", "change (k = 2)", "chance");
  for (const ParameterChange& p : c.parameters)
    out << format("%s %-42s %-22s %-22s %-22s %s\n", p.significant ? "*" : " ",
                  (inWords(p.effect) + ", " + p.name).c_str(),
                  expanded(p.before, p.beforeStd, p.unit).c_str(),
                  expanded(p.after, p.afterStd, p.unit).c_str(),
                  !p.comparable          ? "other range"
                  : std::isfinite(p.std) ? expanded(p.change, p.std, p.unit).c_str()
                                         : (shortNumber(p.change) + " " + p.unit).c_str(),
                  p.comparable && std::isfinite(p.pValue) ? probabilityText(p.pValue).c_str() : "-");
  if (!c.sameSession) out << "  * significant: p < 1 % for all parameters together\n";
  return out.str();
}

}  // namespace mm
