#include "report/blind_page.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <sstream>

#include "base/format.h"
#include "base/quantity_words.h"
#include "report/json_parts.h"
#include "report/report_page.h"
#include "report/web_files.h"

namespace mm {
namespace {

std::string inUnit(const BlindReport& r, double value) {
  return shortNumber(value / unitOf(r.blocks.angular));
}

/// What the RMS is taken about.
std::string rmsName(const BlindReport& r) {
  return r.blocks.fittedPose ? "RMS about the fitted pose" : "RMS of the residuals";
}

Json intervalJson(const TrialFigure& f, double unit) {
  return {{"value", f.value / unit}, {"lower", f.lower / unit}, {"upper", f.upper / unit}};
}

std::string badgeOf(TrialVerdict verdict) {
  static constexpr const char* kBadges[] = {"It helped",      "It helped in part", "It corrects too much",
                                            "It did nothing", "Wrong sign",        "It made it worse",
                                            "Cannot tell"};
  return kBadges[static_cast<std::size_t>(verdict)];
}

std::string testText(const BlindReport& r) {
  return format(
      "%d blocks with and %d without the correction; 99 %% intervals; randomisation test p = %.2g "
      "(gain), %.2g (RMS), the smallest possible %.2g",
      r.on == 'A' ? r.labelled.blocksA : r.labelled.blocksB,
      r.on == 'A' ? r.labelled.blocksB : r.labelled.blocksA, r.opened.gainP, r.opened.rmsP,
      r.labelled.smallestP);
}

/// How often such an answer is wrong; nothing where so few blocks cannot say.
std::string chanceText(const BlindReport& r) {
  if (r.labelled.smallestP > kFalseAnswers) return {};
  return " At most 1 % of the trials say by chance that a correction helped, and as few that it has the "
         "wrong sign.";
}

/// A quantity of the blocks over their running number: SVG. @param levels those in its range are marked.
std::string blocksSvg(const BlindReport& report, const std::string& label, const std::vector<double>& levels,
                      const std::function<double(const TrialBlockFigures&)>& value) {
  constexpr double kWidth = 400, kHeight = 170, kLeft = 34, kRight = 8, kTop = 10, kBottom = 32;
  constexpr double kMargin = 0.08;  // of the range
  const std::vector<TrialBlockFigures>& blocks = report.blocks.blocks;
  double low = 0.0, high = 0.0;
  for (const TrialBlockFigures& block : blocks) {
    low = std::min(low, value(block));
    high = std::max(high, value(block));
  }
  if (!(high > low)) high = low + 1.0;
  high += kMargin * (high - low);
  if (low < 0.0) low -= kMargin * (high - low);
  const auto y = [&](double at) {
    return kHeight - kBottom - (kHeight - kTop - kBottom) * (at - low) / (high - low);
  };
  std::string svg = format("<svg viewBox=\"0 0 %.0f %.0f\" role=\"img\" aria-label=\"", kWidth, kHeight) +
                    escapedHtml(label) + "\">";
  for (const double level : levels) {
    if (level < low || level > high) continue;
    svg += format(
        "<path class=\"zero\" d=\"M%.1f %.1fH%.1f\"/><text x=\"%.1f\" y=\"%.1f\" "
        "text-anchor=\"end\">%s</text>",
        kLeft, y(level), kWidth - kRight, kLeft - 4, y(level) + 3.5, shortNumber(level).c_str());
  }
  double past = 0.5;  // blocks to the left of the middle of this one
  for (const TrialBlockFigures& block : blocks) {
    const double x = kLeft + past / static_cast<double>(blocks.size()) * (kWidth - kLeft - kRight);
    const double top = y(value(block));
    svg += format("<path class=\"bar\" d=\"M%.1f %.1fV%.1f\"/>", x, y(std::max(0.0, low)), top);
    svg += block.state == report.on
               ? format("<circle class=\"on\" cx=\"%.1f\" cy=\"%.1f\" r=\"5\"/>", x, top)
               : format("<rect class=\"off\" x=\"%.1f\" y=\"%.1f\" width=\"9\" height=\"9\"/>", x - 4.5,
                        top - 4.5);
    svg += format("<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\">%d</text>", x, kHeight - kBottom + 13,
                  block.number);
    past += 1.0;
  }
  return svg +
         format("<text x=\"%.0f\" y=\"%.1f\" text-anchor=\"middle\">block, in the order of time</text></svg>",
                0.5 * (kLeft + kWidth), kHeight - 2.0);
}

/// Round levels up to the largest RMS, in its unit.
std::vector<double> roundLevels(double largest) {
  if (!positive(largest)) return {0.0};
  const double decade = std::pow(10.0, std::floor(std::log10(largest)));
  const double step = largest / decade < 2.0 ? 0.5 * decade : largest / decade < 5.0 ? decade : 2.0 * decade;
  std::vector<double> levels;
  for (int k = 0; k * step <= 1.1 * largest; ++k) levels.push_back(k * step);
  return levels;
}

std::string figureHtml(const std::string& title, const std::string& svg) {
  return "<figure><figcaption><b>" + escapedHtml(title) +
         "</b><span class=\"key\"><i class=\"on\"></i> on <i class=\"off\"></i> off</span></figcaption>" +
         svg + "</figure>\n";
}

std::string rowHtml(const std::string& what, const TrialFigure& f, double unit, const std::string& name) {
  const auto number = [&](double value) { return shortNumber(value / unit); };
  const bool interval = std::isfinite(f.lower) && std::isfinite(f.upper);
  return "<tr><td>" + what + "</td><td class=\"n\">" +
         (std::isfinite(f.value) ? number(f.value) + name : "–") + "</td><td class=\"n\">" +
         (interval ? number(f.lower) + " to " + number(f.upper) + name : "–") + "</td></tr>";
}

std::string figuresTable(const BlindReport& r) {
  const double unit = unitOf(r.blocks.angular);
  const std::string name = " " + escapedHtml(nameOfUnit(r.blocks.angular));
  std::string axes;
  for (const AxisGain& axis : r.opened.axes)
    axes += rowHtml("gain of " + escapedHtml(axis.axis), axis.gain, 1.0, "");
  return "<div class=\"wide\"><table><tr><th>figure</th><th class=\"n\">value</th><th class=\"n\">99 % "
         "interval</th></tr>" +
         rowHtml(rmsName(r) + " without the correction", r.opened.without, unit, name) +
         rowHtml(rmsName(r) + " with it", r.opened.with, unit, name) +
         rowHtml("with / without", r.opened.ratio, 1.0, "") +
         rowHtml("gain: share of the correction that arrives", r.opened.gain, 1.0, "") + axes +
         "</table></div>\n";
}

std::string blocksTable(const BlindReport& r) {
  std::string html =
      "<div class=\"wide\"><table><tr><th class=\"n\">block</th><th>state</th><th>on</th><th class=\"n\">RMS "
      "/ " +
      escapedHtml(nameOfUnit(r.blocks.angular)) +
      "</th><th class=\"n\">error left</th><th class=\"n\">points</th></tr>";
  for (const TrialBlockFigures& b : r.blocks.blocks)
    html += format(
        "<tr><td class=\"n\">%d</td><td>%c</td><td>%s</td><td class=\"n\">%s</td><td class=\"n\">%.2f</td>"
        "<td class=\"n\">%d</td></tr>",
        b.number, b.state, b.state == r.on ? "on" : "off", inUnit(r, b.rms).c_str(), b.remaining,
        b.measurements);
  return html + "</table></div>\n";
}

/// What a sentence says behind the verdict.
std::string behindVerdict(const std::string& sentence) {
  const std::size_t colon = sentence.find(": ");
  return colon == std::string::npos ? sentence : sentence.substr(colon + 2);
}

}  // namespace

std::string blindJson(const BlindReport& r) {
  const bool angular = r.blocks.angular;
  const double unit = unitOf(angular);
  const std::string rms = "rms_" + nameOfUnit(angular);
  const auto block = [&](const TrialBlockFigures& b) -> Json {
    return {{"block", b.number},     {"state", std::string(1, b.state)}, {"correction", b.state == r.on},
            {rms, b.rms / unit},     {"remaining", b.remaining},         {"measurements", b.measurements},
            {"outliers", b.outliers}};
  };
  return jsonText({{"verdict", nameOf(r.opened.verdict)},
                   {"in_words", r.opened.inWords},
                   {"trial", r.blocks.trial},
                   {"gain", intervalJson(r.opened.gain, 1.0)},
                   {"axes", jsonList(r.opened.axes,
                                     [](const AxisGain& a) -> Json {
                                       return {{"axis", a.axis}, {"gain", intervalJson(a.gain, 1.0)}};
                                     })},
                   {rms + "_without", intervalJson(r.opened.without, unit)},
                   {rms + "_with", intervalJson(r.opened.with, unit)},
                   {"ratio", intervalJson(r.opened.ratio, 1.0)},
                   {"p_gain", r.opened.gainP},
                   {"p_rms", r.opened.rmsP},
                   {"smallest_p", r.labelled.smallestP},
                   {"predicted_" + nameOfUnit(angular), r.blocks.predicted / unit},
                   {"blocks_planned", r.blocks.planned},
                   {"blocks_wanted", orNull(r.opened.blocksWanted > 0, r.opened.blocksWanted)},
                   {"blocks", jsonList(r.blocks.blocks, block)},
                   {"not_judged", r.blocks.notJudged},
                   {"remarks", r.blocks.remarks}});
}

std::string blindText(const BlindReport& r) {
  std::ostringstream out;
  out << r.opened.inWords << "\n" << testText(r) << "\n";
  if (!r.blocks.notJudged.empty()) out << r.blocks.notJudged << "\n";
  for (const std::string& remark : r.blocks.remarks) out << "note: " << remark << "\n";
  const std::string unit = nameOfUnit(r.blocks.angular);
  out << format("\n  block  correction  %10s  error left  measurements\n", ("RMS / " + unit).c_str());
  for (const TrialBlockFigures& b : r.blocks.blocks)
    out << format("  %5d  %-10s  %10s  %10.2f  %12d\n", b.number, b.state == r.on ? "on" : "off",
                  inUnit(r, b.rms).c_str(), b.remaining, b.measurements);
  return out.str();
}

std::string blindPage(const BlindReport& r) {
  const std::string unit = nameOfUnit(r.blocks.angular);
  const double size = unitOf(r.blocks.angular);
  double largest = 0.0;
  for (const TrialBlockFigures& b : r.blocks.blocks) largest = std::max(largest, b.rms / size);
  const std::string rms = blocksSvg(r, "RMS of each block", roundLevels(largest),
                                    [size](const TrialBlockFigures& b) { return b.rms / size; });
  const std::string left = blocksSvg(r, "Share of the predicted error in each block", {-1.0, 0.0, 1.0, 2.0},
                                     [](const TrialBlockFigures& b) { return b.remaining; });
  std::string html =
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">"
      "<title>Blind trial: measuring machine report</title><style>\n" +
      webFile("page.css") + webFile("fleet.css") + "\n" + webFile("blind.css") +
      "</style></head><body><main>\n<h1>Blind trial of a correction</h1><p class=\"soft\">" +
      escapedHtml(r.session) + "; calibration " + escapedHtml(r.calibration) + "; trial " +
      escapedHtml(r.blocks.trial) + "</p>\n<div class=\"verdict " + nameOf(r.opened.verdict) + "\"><b>" +
      badgeOf(r.opened.verdict) + "</b>" + escapedHtml(behindVerdict(r.opened.inWords)) +
      ".</div>\n<p class=\"soft\">" + escapedHtml(testText(r)) + ".</p>\n";
  if (!r.blocks.remarks.empty()) {
    html += "<ul class=\"findings\">";
    for (const std::string& remark : r.blocks.remarks) html += "<li>" + escapedHtml(remark) + "</li>";
    html += "</ul>\n";
  }
  html += "<h2>Blocks</h2>" + figureHtml(rmsName(r) + " / " + unit, rms) +
          figureHtml("Share of the predicted error that is there", left) + "<h2>Figures</h2>" +
          figuresTable(r) + blocksTable(r) +
          "<p class=\"soft\">The correction was switched at random, and the states were compared as A and B "
          "before the key was opened. " +
          (r.blocks.notJudged.empty() ? "" : escapedHtml(r.blocks.notJudged) + ". ") +
          "A linear trend over the trial is taken out." + chanceText(r) + "</p>\n";
  return html + "</main></body></html>\n";
}

}  // namespace mm
