#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "base/format.h"
#include "fleet/fleet.h"
#include "report/report_page.h"
#include "report/web_files.h"

namespace mm {
namespace {

constexpr double kNoHeight = 1e-9;  // of values that are all zero: a picture needs some height

constexpr double kWidth = 240, kHeight = 96, kLeft = 40, kRight = 6, kTop = 6, kBottom = 14;
constexpr std::size_t kQuietShown = 24;  // of one quantity: all that have a finding, and so many others

/// One scale for all machines of a quantity, so that they can be compared at a look.
struct Scale {
  double fromDay = std::numeric_limits<double>::infinity(), toDay = -fromDay, low = fromDay, high = -fromDay;
  std::string fromDate, toDate;

  explicit Scale(const std::vector<const FleetSeries*>& group) {
    for (const FleetSeries* s : group)
      for (std::size_t i = 0; i < s->points.size(); ++i) {
        const TrendPoint& p = s->points[i];
        if (p.day < fromDay) fromDate = s->dates[i];
        if (p.day > toDay) toDate = s->dates[i];
        fromDay = std::min(fromDay, p.day);
        toDay = std::max(toDay, p.day);
        low = std::min(low, p.value - p.std);
        high = std::max(high, p.value + p.std);
      }
    if (!(toDay > fromDay)) toDay = fromDay + 1.0;
    const double margin = high > low ? 0.04 * (high - low) : std::max(kNoHeight, 0.1 * std::abs(high));
    low -= margin;
    high += margin;
  }
  double x(double day) const {
    return kLeft + (kWidth - kLeft - kRight) * (day - fromDay) / (toDay - fromDay);
  }
  double y(double value) const {
    const double share = std::clamp((value - low) / (high - low), 0.0, 1.0);
    return kHeight - kBottom - (kHeight - kTop - kBottom) * share;
  }
};

std::string lineOf(const Scale& scale, double day1, double value1, double day2, double value2, bool found) {
  return format("<path class=\"level%s\" d=\"M%.1f %.1fL%.1f %.1f\"/>", found ? " found" : "", scale.x(day1),
                scale.y(value1), scale.x(day2), scale.y(value2));
}

/// Levels between which a series jumped, or the line along which it drifts.
std::string trendLines(const FleetSeries& s, const Scale& scale) {
  const std::vector<TrendPoint>& p = s.points;
  if (s.trend.kind == Trend::Kind::kDrift)
    return lineOf(scale, p.front().day, s.trend.start, p.back().day, s.trend.end, true);
  std::string svg;
  const bool found = s.trend.kind == Trend::Kind::kSteps;
  for (const TrendSegment& part : s.trend.segments)
    svg += lineOf(scale, p[part.first].day, part.level, p[part.end - 1].day, part.level, found);
  return svg;
}

std::string panel(const FleetSeries& s, const Scale& scale, const Sisterhood& sisters, bool found) {
  std::string svg = format("<figure class=\"%s\"><figcaption><b>", found ? "found" : "quiet-panel");
  svg += escapedHtml(s.machine) + "</b><span>" + format("%zu sessions", s.points.size()) +
         "</span></figcaption>";
  svg += format("<svg viewBox=\"0 0 %.0f %.0f\" role=\"img\" aria-label=\"", kWidth, kHeight);
  svg += escapedHtml(s.quantity + " of machine " + s.machine) + "\">";
  const double half = 2.0 * sisters.spread;
  if (half > 0.0 && sisters.p.size() > 3) {
    const double top = scale.y(sisters.centre + half), bottom = scale.y(sisters.centre - half);
    svg += format("<rect class=\"band\" x=\"%.1f\" y=\"%.1f\" width=\"%.1f\" height=\"%.1f\"/>", kLeft, top,
                  kWidth - kLeft - kRight, std::max(0.5, bottom - top));
  }
  if (scale.low < 0.0 && scale.high > 0.0)
    svg += format("<path class=\"zero\" d=\"M%.1f %.1fH%.1f\"/>", kLeft, scale.y(0.0), kWidth - kRight);
  std::string bars, dots;
  for (const TrendPoint& p : s.points) {
    const double x = scale.x(p.day);
    if (p.std > 0.0) bars += format("M%.1f %.1fV%.1f", x, scale.y(p.value - p.std), scale.y(p.value + p.std));
    dots += format("<circle class=\"dot\" cx=\"%.1f\" cy=\"%.1f\" r=\"1.8\"/>", x, scale.y(p.value));
  }
  if (!bars.empty()) svg += "<path class=\"bar\" d=\"" + bars + "\"/>";
  svg += dots + trendLines(s, scale);
  svg +=
      format("<text x=\"%.0f\" y=\"%.0f\" text-anchor=\"end\">%.3g</text>", kLeft - 3, kTop + 7, scale.high);
  svg += format("<text x=\"%.0f\" y=\"%.0f\" text-anchor=\"end\">%.3g</text>", kLeft - 3, kHeight - kBottom,
                scale.low);
  svg += format("<text x=\"%.0f\" y=\"%.0f\">%s</text>", kLeft, kHeight - 3,
                escapedHtml(scale.fromDate.substr(0, 10)).c_str());
  svg += format("<text x=\"%.0f\" y=\"%.0f\" text-anchor=\"end\">%s</text>", kWidth - kRight, kHeight - 3,
                escapedHtml(scale.toDate.substr(0, 10)).c_str());
  return svg + "</svg></figure>\n";
}

std::string multiples(const std::vector<const FleetSeries*>& group, const std::set<std::string>& found) {
  const Scale scale(group);
  std::vector<Sister> present;
  for (const FleetSeries* s : group) present.push_back(presentOf(*s));
  const Sisterhood sisters = sistersOf(present);
  std::string html, quiet;
  std::size_t shown = 0, left = 0;
  for (const FleetSeries* s : group) {
    if (found.count(s->machine) > 0)
      html += panel(*s, scale, sisters, true);
    else if (shown++ < kQuietShown)
      quiet += panel(*s, scale, sisters, false);
    else
      ++left;
  }
  html = "<div class=\"grid\">" + html + quiet + "</div>";
  if (left > 0)
    html += "<p class=\"soft\">" + std::to_string(left) + " machines without a finding are not drawn.</p>";
  return html;
}

std::string kindInWords(const std::string& kind) {
  static const std::map<std::string, std::string> words{
      {"apart", "differs from other machines"}, {"drifts_apart", "drifts apart"}, {"came_back", "came back"}};
  const auto at = words.find(kind);
  return at == words.end() ? kind : at->second;
}

std::string findingsHtml(const Fleet& fleet) {
  if (fleet.findings.empty())
    return "<p class=\"quiet\">No findings: no machine changed, drifts or differs from the others by more "
           "than chance would produce in one fleet of " +
           format("%.0f", 1.0 / fleet.alarm) + ".</p>";
  std::string html = "<ul class=\"findings\">";
  for (const Finding& f : fleet.findings)
    html += "<li><span class=\"kind\">" + escapedHtml(kindInWords(f.kind)) + "</span>" +
            escapedHtml(f.inWords) + "</li>";
  return html + "</ul><p class=\"soft\">" + format("%.0f", fleet.questions) +
         " tests were made; the false alarm probability of the whole fleet is " +
         format("%.3g", fleet.alarm) + ".</p>";
}

std::string failuresHtml(const Fleet& fleet) {
  if (fleet.failures.empty()) return {};
  std::string html =
      "<h2>Jobs that failed</h2><div class=\"wide\"><table><tr><th>machine</th><th>session</th>"
      "<th>step</th><th>why</th></tr>";
  for (const FleetRecord& r : fleet.failures)
    html += "<tr><td>" + escapedHtml(r.machine) + "</td><td>" + escapedHtml(r.session) + "</td><td>" +
            escapedHtml(r.result.failed) + "</td><td>" + escapedHtml(r.result.why) + "</td></tr>";
  return html + "</table></div>";
}

}  // namespace

std::string fleetPage(const Fleet& fleet) {
  std::map<std::string, std::vector<const FleetSeries*>> groups;
  std::map<std::string, std::set<std::string>> found;
  for (const FleetSeries& s : fleet.series) groups[s.quantity].push_back(&s);
  for (const Finding& f : fleet.findings) found[f.quantity].insert(f.machine);
  std::vector<std::string> order;
  for (const auto& [quantity, group] : groups) order.push_back(quantity);
  std::stable_sort(order.begin(), order.end(), [&](const std::string& a, const std::string& b) {
    return found[a].size() > found[b].size();
  });
  std::string html =
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">"
      "<title>Fleet: measuring machine report</title><style>\n" +
      webFile("page.css") + webFile("fleet.css") + "</style></head><body><main>\n<h1>" +
      format("%zu machines, %ld sessions", fleet.machines.size(), fleet.done) + "</h1>";
  html += "<p class=\"soft\">" + escapedHtml(fleet.source) +
          (fleet.model.empty() ? "" : "; model " + escapedHtml(fleet.model)) +
          (fleet.failed > 0 ? format("; %ld jobs failed", fleet.failed) : "") +
          (fleet.open > 0 ? format("; %ld fits did not converge and are not used", fleet.open) : "") +
          (fleet.waiting > 0 ? format("; %ld jobs wait", fleet.waiting) : "") + "</p>\n";
  html += "<h2>Findings</h2>" + findingsHtml(fleet) +
          "\n"
          "<h2>Every machine over time</h2><p class=\"soft\">One scale per quantity. Points are shown with "
          "their standard uncertainty; the line is the level, step or drift that was found; the band is the "
          "present range of the other machines, two standard deviations wide on either side.</p>\n";
  for (const std::string& quantity : order) {
    const std::vector<const FleetSeries*>& group = groups[quantity];
    html += "<h3>" + escapedHtml(quantity) + " <span class=\"soft\">/ " + escapedHtml(group.front()->unit) +
            "</span></h3>" + multiples(group, found[quantity]) + "\n";
  }
  return html + failuresHtml(fleet) + "</main></body></html>\n";
}

}  // namespace mm
