#include "report/certificate_plots.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "base/format.h"
#include "base/range.h"
#include "base/tiny.h"
#include "base/units.h"
#include "report/report_page.h"

namespace mm {
namespace {

constexpr double kPlotWidth = 520.0, kPlotHeight = 210.0, kPlotLeft = 58.0, kPlotRight = 12.0,
                 kPlotTop = 24.0, kPlotBottom = 38.0;
constexpr const char* kColours[] = {"#1f5fa8", "#c1571a", "#2d7d46", "#7a3f98"};

// Stands within each plot: a printer may take no other style for it than its own.
constexpr const char* kPlotStyle =
    "<style>text { font-family: \"DejaVu Sans\", \"Liberation Sans\", Arial, sans-serif; font-size: 11px; "
    "fill: #333b44; } .grid { stroke: #e1e5ea; } .zero { stroke: #7d8894; }</style>";

/// A range with ends on round numbers, and the step between its marks.
struct PlotScale {
  double low = 0.0, high = 1.0, step = 0.5;
};

/// @param least smallest step between marks: 1 for what is counted.
PlotScale scaleOf(double low, double high, double least = 0.0) {
  PlotScale s;
  if (!(high > low)) {
    const double half = std::max(1e-3, 0.1 * std::abs(low));
    low -= half;
    high += half;
  }
  const double raw = std::max(least, (high - low) / 5.0), power = std::pow(10.0, std::floor(std::log10(raw)));
  s.step = power * (raw / power < 1.5 ? 1.0 : raw / power < 3.5 ? 2.0 : raw / power < 7.5 ? 5.0 : 10.0);
  s.low = s.step * std::floor(low / s.step + kOfAWhole);
  s.high = s.step * std::ceil(high / s.step - kOfAWhole);
  return s;
}

struct PlotFrame {
  PlotScale x, y;
  double px(double v) const {
    return kPlotLeft + (v - x.low) / (x.high - x.low) * (kPlotWidth - kPlotLeft - kPlotRight);
  }
  double py(double v) const {
    return kPlotHeight - kPlotBottom -
           (v - y.low) / (y.high - y.low) * (kPlotHeight - kPlotTop - kPlotBottom);
  }
};

std::string markText(double v, double step) {
  const int digits = std::clamp(static_cast<int>(std::ceil(-std::log10(step) - kOfAWhole)), 0, 6);
  return format("%.*f", digits, std::abs(v) < kOfAWhole * step ? 0.0 : v);
}

std::string grid(const PlotFrame& f) {
  std::string svg;
  for (double v = f.y.low; v <= f.y.high + 0.5 * f.y.step; v += f.y.step)
    svg += format("<line x1=\"%.1f\" x2=\"%.1f\" y1=\"%.1f\" y2=\"%.1f\" class=\"%s\"/>", kPlotLeft,
                  kPlotWidth - kPlotRight, f.py(v), f.py(v),
                  std::abs(v) < kOfAWhole * f.y.step ? "zero" : "grid") +
           format("<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"end\">", kPlotLeft - 6, f.py(v) + 4) +
           markText(v, f.y.step) + "</text>";
  for (double v = f.x.low; v <= f.x.high + 0.5 * f.x.step; v += f.x.step)
    svg += format("<line x1=\"%.1f\" x2=\"%.1f\" y1=\"%.1f\" y2=\"%.1f\" class=\"grid\"/>", f.px(v), f.px(v),
                  kPlotTop, kPlotHeight - kPlotBottom) +
           format("<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\">", f.px(v),
                  kPlotHeight - kPlotBottom + 15) +
           markText(v, f.x.step) + "</text>";
  return svg;
}

/// Indices of the points that a line is drawn by: of more than a plot can show the first, the lowest, the
/// highest and the last of each half unit of its width, so that short waves are a band of their height.
std::vector<std::size_t> drawnOf(const PlotFrame& f, const PlotSeries& s) {
  std::vector<std::size_t> drawn;
  for (std::size_t begin = 0, end = 0; begin < s.x.size(); begin = end) {
    const double column = std::floor(2.0 * f.px(s.x[begin]));
    for (end = begin; end < s.x.size() && std::floor(2.0 * f.px(s.x[end])) == column;) ++end;
    const auto [low, high] =
        std::minmax_element(s.y.begin() + static_cast<long>(begin), s.y.begin() + static_cast<long>(end));
    std::set<std::size_t> kept{begin, end - 1, static_cast<std::size_t>(low - s.y.begin()),
                               static_cast<std::size_t>(high - s.y.begin())};
    drawn.insert(drawn.end(), kept.begin(), kept.end());
  }
  return drawn;
}

std::string curveOf(const PlotFrame& f, const PlotSeries& s) {
  std::string svg;
  const std::vector<std::size_t> drawn = drawnOf(f, s);
  if (!s.band.empty()) {
    std::string outline;
    for (const std::size_t i : drawn) outline += format("%.1f,%.1f ", f.px(s.x[i]), f.py(s.y[i] + s.band[i]));
    for (std::size_t k = drawn.size(); k-- > 0;)
      outline += format("%.1f,%.1f ", f.px(s.x[drawn[k]]), f.py(s.y[drawn[k]] - s.band[drawn[k]]));
    svg += "<polygon points=\"" + outline + "\" fill=\"" + s.colour + "\" opacity=\"0.18\"/>";
  }
  if (s.points) {
    for (std::size_t i = 0; i < s.x.size(); ++i)
      svg += format("<circle cx=\"%.1f\" cy=\"%.1f\" r=\"2.6\" fill=\"%s\">", f.px(s.x[i]), f.py(s.y[i]),
                    s.colour.c_str()) +
             (i < s.titles.size() ? "<title>" + escapedHtml(s.titles[i]) + "</title>" : std::string()) +
             "</circle>";
    return svg;
  }
  std::string line;
  for (const std::size_t i : drawn) line += format("%.1f,%.1f ", f.px(s.x[i]), f.py(s.y[i]));
  return svg + "<polyline points=\"" + line + "\" fill=\"none\" stroke=\"" + s.colour +
         "\" stroke-width=\"1.8\"/>";
}

}  // namespace

std::string svgPlot(const std::string& x, const std::string& y, const std::vector<PlotSeries>& series,
                    bool fromZero, bool counted) {
  Range alongX, alongY;
  for (const PlotSeries& s : series)
    for (std::size_t i = 0; i < s.x.size(); ++i) {
      const double band = s.band.empty() ? 0.0 : s.band[i];
      alongX.add(s.x[i]);
      alongY.add(s.y[i] - band);
      alongY.add(s.y[i] + band);
    }
  if (!alongX.any() || !std::isfinite(alongY.size())) return {};
  for (Range* range : {&alongX, &alongY})
    if (fromZero) range->lower = std::min(range->lower, 0.0);
  const PlotFrame f{scaleOf(alongX.lower, alongX.upper, counted ? 1.0 : 0.0),
                    scaleOf(alongY.lower, alongY.upper)};
  std::string svg =
      format("<svg viewBox=\"0 0 %.0f %.0f\" role=\"img\">", kPlotWidth, kPlotHeight) + kPlotStyle + grid(f);
  double at = kPlotLeft;
  for (const PlotSeries& s : series) {
    svg += curveOf(f, s);
    if (series.size() < 2) continue;
    svg += format("<rect x=\"%.1f\" y=\"6\" width=\"14\" height=\"4\" fill=\"%s\"/>", at, s.colour.c_str()) +
           format("<text x=\"%.1f\" y=\"12\">", at + 19) + escapedHtml(s.name) + "</text>";
    at += 40.0 + 6.4 * static_cast<double>(s.name.size());
  }
  svg += format("<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\">",
                0.5 * (kPlotLeft + kPlotWidth - kPlotRight), kPlotHeight - 6.0) +
         escapedHtml(x) + "</text>";
  svg += format("<text transform=\"translate(13 %.1f) rotate(-90)\" text-anchor=\"middle\">",
                0.5 * (kPlotTop + kPlotHeight - kPlotBottom)) +
         escapedHtml(y) + "</text></svg>";
  return svg;
}

std::string correctionPlot(const CorrectionCurve& curve) {
  std::vector<PlotSeries> series;
  for (int k = 0; k < 3; ++k) {
    PlotSeries s;
    s.name = std::string("in ") + "xyz"[k];
    s.colour = kColours[k];
    s.x = curve.at;
    for (std::size_t i = 0; i < curve.at.size(); ++i) {
      s.y.push_back(curve.correction[i][k]);
      s.band.push_back(curve.expanded[i][k]);
    }
    series.push_back(std::move(s));
  }
  return svgPlot(curve.axis + ", " + curve.unit, "correction, µm", series);
}

std::string lengthsPlot(const LengthTable& lengths) {
  if (lengths.rows.empty()) return {};
  PlotSeries test{"|E| + U of a length", kColours[0], {}, {}, {}, true},
      line{"A + L/K", kColours[1], {0.0}, {}, {}, false},
      whole{"largest |E| of a whole test", kColours[3], {0.0}, {}, {}, false};
  for (const LengthRow& row : lengths.rows) {
    test.x.push_back(row.length);
    test.y.push_back(row.sum);
    test.titles.push_back(row.error.name + ": " + row.sumText + " µm");
  }
  line.x.push_back(*std::max_element(test.x.begin(), test.x.end()));
  whole.x.push_back(line.x.back());
  for (const double x : line.x) line.y.push_back(lengths.least.at(x));
  whole.y.assign(2, lengths.wholeTest);
  return svgPlot("length, mm", "µm", {test, line, whole}, true);
}

std::string historyPlot(const std::vector<LedgerEntry>& ledger, bool angular) {
  if (ledger.size() < 2) return {};  // the table says it
  PlotSeries held{"RMS at measurements not used by the fit", kColours[0], {}, {}, {}, false},
      fitted{"RMS of the fit", kColours[2], {}, {}, {}, false};
  const auto add = [angular](PlotSeries& s, double step, double value) {
    if (!std::isfinite(value)) return;
    s.x.push_back(step);
    s.y.push_back(value / (angular ? kArcsecond : kMicrometre));
  };
  for (std::size_t i = 0; i < ledger.size(); ++i) {
    if (i == 0) {
      add(held, 0.0, ledger[i].heldOutBefore);
      add(fitted, 0.0, ledger[i].rmsBefore);
    }
    add(held, static_cast<double>(i + 1), ledger[i].heldOutAfter);
    add(fitted, static_cast<double>(i + 1), ledger[i].rmsAfter);
  }
  if (held.x.size() < 2 && fitted.x.size() < 2) return {};
  std::vector<PlotSeries> series;
  for (PlotSeries* s : {&held, &fitted})
    if (s->x.size() >= 2) series.push_back(std::move(*s));
  return svgPlot("step of the calibration", angular ? "arcsec" : "µm", series, true, true);
}

}  // namespace mm
