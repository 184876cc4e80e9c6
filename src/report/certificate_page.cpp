// The certificate as HTML: a page of paper first of all.
#include <algorithm>
#include <cctype>
#include <cmath>

#include "base/format.h"
#include "base/text.h"
#include "base/units.h"
#include "base/utc_now.h"
#include "effects/effect_words.h"
#include "report/certificate.h"
#include "report/certificate_plots.h"
#include "report/certificate_seal.h"
#include "report/report_page.h"
#include "report/text_parts.h"
#include "report/uncertainty_output.h"

namespace mm {
namespace {

/// What stands at the foot of every printed page; the id may come from a foreign file.
std::string footOfPage(const std::string& id) {
  std::string plain;
  for (const char c : id)
    if (std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-') plain += c;
  return "@page { @bottom-left { content: \"Calibration certificate " + plain +
         "\"; font: 8pt sans-serif; color: #444c56; } }\n";
}

constexpr const char* kStyle = R"(
@page { size: A4; margin: 17mm 16mm 18mm; @bottom-right { content: "page " counter(page) " of " counter(pages); font: 8pt sans-serif; color: #444c56; } }
* { box-sizing: border-box; }
html { color-scheme: light; }
body { font: 10.5pt/1.42 "DejaVu Sans", "Liberation Sans", Arial, sans-serif; color: #1b1f24; background: #e9ecef; margin: 0; }
main { background: #fff; max-width: 210mm; margin: 8mm auto; padding: 15mm 16mm; box-shadow: 0 1px 8px #0002; }
h1 { font-size: 19pt; margin: 0; letter-spacing: .01em; }
h2 { font-size: 12pt; margin: 7mm 0 2mm; padding-bottom: 1mm; border-bottom: .4mm solid #1f5fa8; break-after: avoid; }
.number { color: #444c56; margin: 1mm 0 5mm; overflow-wrap: anywhere; }
table { border-collapse: collapse; width: 100%; font-size: 9.5pt; font-variant-numeric: tabular-nums; }
th { text-align: left; font-weight: 600; vertical-align: top; }
td, th { padding: .9mm 2mm .9mm 0; border-bottom: .2mm solid #d5dae0; vertical-align: top; overflow-wrap: anywhere; }
thead th { border-bottom: .3mm solid #6b7683; }
table.facts th { width: 46mm; color: #444c56; }
tr.own td.which { font-weight: 600; } .when { white-space: nowrap; } th.which, td.which { min-width: 32mm; }
td.n, th.n { text-align: right; white-space: nowrap; padding-left: 3mm; }
tr, figure, .task, .together { break-inside: avoid; }
thead { display: table-header-group; }
figure { margin: 3mm 0; }
figcaption { font-size: 9pt; color: #444c56; }
svg { width: 100%; max-width: 150mm; height: auto; display: block; }
.result { font-size: 11.5pt; margin: 1mm 0; } .result b { white-space: nowrap; }
.bar { display: inline-block; height: 2.6mm; background: #1f5fa8; vertical-align: middle; min-width: .3mm; }
td.share { width: 52mm; white-space: nowrap; }
.verdict { border-left: 1.2mm solid #6b7683; padding: 1mm 0 1mm 3mm; margin: 2mm 0; }
.conforms { border-color: #2d7d46; } .fails { border-color: #b3261e; } .open { border-color: #b07d00; }
.task { margin-bottom: 5mm; } .task h3 { font-size: 10.5pt; margin: 4mm 0 1mm; }
p { margin: 1.5mm 0; } .small { font-size: 9pt; color: #444c56; }
.sign { display: flex; margin-top: 14mm; break-inside: avoid; } .sign div + div { margin-left: 12mm; } .sign div { flex: 1; border-top: .3mm solid #444c56; padding-top: 1mm; font-size: 9pt; }
@media print { body { background: #fff; } main { margin: 0; padding: 0; max-width: none; box-shadow: none; } * { print-color-adjust: exact; -webkit-print-color-adjust: exact; } }
@media (max-width: 720px) { main { margin: 0; padding: 6mm 4mm; } .wide { overflow-x: auto; } table.facts th { width: 30%; } }
)";

std::string nicely(std::string text) {  // units as they are printed
  for (const auto& [plain, nice] :
       {std::pair<std::string, std::string>{"+-", "±"}, {" um", " µm"}, {"um/m", "µm/m"}, {"degC", "°C"}})
    for (std::size_t at = text.find(plain); at != std::string::npos; at = text.find(plain, at + nice.size()))
      text.replace(at, plain.size(), nice);
  return text;
}

std::string shown(const std::string& text) { return escapedHtml(nicely(text)); }

std::string factRow(const std::string& name, const std::string& value) {
  return "<tr><th>" + escapedHtml(name) + "</th><td>" + (value.empty() ? "not stated" : shown(value)) +
         "</td></tr>\n";
}

std::string sectionHead(const std::string& text) { return "<h2>" + escapedHtml(text) + "</h2>\n"; }

std::string rangeText(double lower, double upper, const char* unit) {
  if (!std::isfinite(lower) || !std::isfinite(upper)) return "not recorded";
  return format("%.4g to %.4g ", lower, upper) + unit;
}

std::string itemSection(const Certificate& c) {
  const Calibration& k = c.calibration;
  std::string html =
      "<table class=\"facts\">" + factRow("Machine", k.machineName) + factRow("Serial number", c.serial);
  if (!c.facts.customer.empty()) html += factRow("Customer", c.facts.customer);
  if (!c.facts.place.empty()) html += factRow("Place", c.facts.place);
  html += factRow("Operator", c.facts.operatorName) + factRow("Date of calibration", k.created) +
          factRow("Date of issue", c.facts.issued.empty() ? utcNow() : c.facts.issued) +
          factRow("Measured as", k.sessionSource + " (" + std::to_string(k.observations) +
                                     " observations, hash " + k.sessionHash + ")") +
          factRow("Method", "parameters of " + std::to_string(k.effects.size()) + " effects by " + k.method +
                                ", measuring_machine " + k.software);
  if (!c.facts.remark.empty()) html += factRow("Remark", c.facts.remark);
  return html + "</table>\n";
}

std::string referenceSection(const Certificate& c) {
  std::string html = sectionHead("Reference standard and its traceability") + "<table class=\"facts\">";
  if (const auto& a = c.calibration.artifact) {
    html += factRow("Artifact", a->features > 0 ? a->name + ", " + std::to_string(a->features) + " features"
                                                : std::string("independent instrument"));
    const auto stated = [](double std) {
      return std > 0.0 ? format("U = %.2g um (k = 2), in the results", 2.0 * std / kMicrometre)
                       : std::string("taken as exact: not in the results");
    };
    if (a->features > 0) {
      if (a->span > 0.0) html += factRow("Largest distance", format("%.5g mm", a->span / kMillimetre));
      html += factRow("Uncertainty of places", stated(a->centreStd)) +
              factRow("Uncertainty of radii", stated(a->radiusStd));
      html += factRow("Pose", a->poseKnown ? "known in the machine" : "found with the parameters");
    }
  } else {
    html += factRow("Artifact", "the calibration's file does not tell");
  }
  return html + factRow("Traceability", c.facts.traceability) + "</table>\n";
}

std::string environmentSection(const Calibration& c) {
  const Domain& d = c.domain;
  std::string html = sectionHead("Conditions and range of validity") + "<table class=\"facts\">";
  for (std::size_t j = 0; j < d.joints.size(); ++j) {
    const bool rotary = d.joints[j].kind == JointKind::kRotary;
    const double unit = rotary ? kDegree : kMillimetre;
    html += factRow("Axis " + d.joints[j].name,
                    rangeText(d.lower[j] / unit, d.upper[j] / unit, rotary ? "deg" : "mm"));
  }
  for (std::size_t s = 0; s < d.sensors.size(); ++s)
    html += factRow("Temperature " + d.sensors[s], rangeText(d.sensorLower[s], d.sensorUpper[s], "degC"));
  for (std::size_t v = 0; v < d.covariates.size(); ++v)
    html += factRow(d.covariates[v], rangeText(d.covariateLower[v], d.covariateUpper[v], ""));
  html += factRow("Duration", format("%.3g h", d.duration / 3600.0));
  for (const Wandering& w : c.drift) {
    const int j = d.findJoint(w.direction);
    const bool rotary = j >= 0 && d.joints[static_cast<std::size_t>(j)].kind == JointKind::kRotary;
    html += factRow("Drift seen, " + w.direction, format("standard deviation %.2g %s, over %.3g min",
                                                         w.std / (rotary ? kArcsecond : kMicrometre),
                                                         rotary ? "arcsec" : "µm", w.timeConstant / 60.0));
  }
  return html +
         "</table>\n<p class=\"small\">The results hold within these ranges; what the machine does after the "
         "calibration is not covered.</p>\n";
}

std::string parameterSection(const Calibration& c) {
  if (c.values.empty()) return {};
  std::string html =
      sectionHead("Results: parameters of the machine") +
      "<div class=\"wide\"><table><thead><tr><th>Effect</th><th>Parameter</th><th class=\"n\">Value</th>"
      "<th class=\"n\">U (k = 2)</th><th>Unit</th></tr></thead><tbody>\n";
  for (const Calibration::Value& v : c.values) {
    const double value = v.value * v.toUnit, expanded = 2.0 * v.std * std::abs(v.toUnit);
    const int digits = expanded > 0.0 && std::isfinite(expanded)
                           ? std::clamp(1 - static_cast<int>(std::floor(std::log10(expanded))), 0, 9)
                           : 3;
    html += "<tr><td>" + shown(inWords(c.effects[static_cast<std::size_t>(v.effect)])) + "</td><td>" +
            shown(v.name) + "</td><td class=\"n\">" + format("%.*f", digits, value) +
            "</td><td class=\"n\">" + (v.fixed ? std::string("held") : format("%.*f", digits, expanded)) +
            "</td><td>" + (v.unit == "um" ? std::string("µm") : shown(v.unit)) + "</td></tr>\n";
  }
  return html + "</tbody></table></div>\n";
}

std::string budgetTable(const QuantityUncertainty& q) {
  std::string html =
      "<table><thead><tr><th>Cause</th><th>Share of the variance</th><th class=\"n\">Standard uncertainty "
      "alone</th></tr></thead><tbody>\n";
  double rest = 0.0;
  std::size_t rows = 0;
  for (const UncertaintyShare& s : q.budget) {
    if (rows == 6 || s.share < 0.005) {
      rest += s.share;
      continue;
    }
    ++rows;
    html += "<tr><td>" + shown(s.source) +
            format(
                "</td><td class=\"share\"><span class=\"bar\" style=\"width:%.1fmm\"></span> %.0f %%</td>"
                "<td class=\"n\">%s µm</td></tr>\n",
                34.0 * s.share, 100.0 * s.share, twoDigits(s.std / kMicrometre).c_str());
  }
  if (rest >= 0.005)
    html += format("<tr><td>others</td><td class=\"share\">%.0f %%</td><td></td></tr>\n", 100.0 * rest);
  return html + "</tbody></table>\n";
}

std::string figureText(const QuantityUncertainty& q) {
  return "<b>" + nicely(figureOf(q)) + "</b>, U = <b>" + twoDigits(2.0 * q.std / kMicrometre) +
         " µm</b> (k = 2)";
}

std::string taskSection(const CertifiedTask& task) {
  const TaskUncertainty& r = task.result;
  const QuantityUncertainty& headline = r.quantities[r.headline];
  std::string html = "<div class=\"task\"><h3>" + shown(r.task) + "</h3>\n<p class=\"result\">" +
                     shown(headline.quantity.name) + ": " + figureText(headline) + "</p>\n";
  const std::vector<TestLength> lengths = testLengthsOf(r);
  if (lengths.size() > 1) {
    html += "<p class=\"result\">Each of the " + std::to_string(lengths.size()) +
            " lengths, for itself, keeps |E| + U within <b>" + shown(permissibleFor(lengths).inWords()) +
            "</b> (L in mm)" +
            (probingOf(r) ? "; probing form: " + figureText(*probingOf(r)) : std::string()) +
            "</p>\n<figure>" + lengthsPlot(r) + "</figure>\n";
  } else if (r.quantities.size() > 1) {
    html += "<p>";
    for (std::size_t q = 0; q < r.quantities.size(); ++q)
      if (q != r.headline)
        html += shown(r.quantities[q].quantity.name) + ": " + figureText(r.quantities[q]) + "<br>";
    html += "</p>\n";
  }
  html += budgetTable(headline);
  for (const std::string& why : r.outside)
    html += "<p class=\"verdict fails\">The calibration does not hold " + shown(why) + ".</p>\n";
  for (const TaskVerdict& v : task.verdicts)
    html += std::string("<p class=\"verdict ") +
            (v.conformity == Conformity::kConforms    ? "conforms"
             : v.conformity == Conformity::kUndecided ? "open"
                                                      : "fails") +
            "\">" + shown(v.inWords) + ".</p>\n";
  return html + format("<p class=\"small\">%zu trials, seed %llu%s</p></div>\n", r.trials,
                       static_cast<unsigned long long>(r.seed),
                       r.stable ? "" : "; not stable in its last digit");
}

std::string sessionSection(const CertifiedSession& s) {
  const double unit = s.angular ? kArcsecond : kMicrometre;
  const char* name = s.angular ? "arcsec" : "µm";
  std::string html = sectionHead("Held against a session") + "<p>" + shown(s.path) + ": " +
                     std::to_string(s.observations) + " observations, " +
                     (s.sameSession ? "those of the calibration itself" : "not used for the calibration") +
                     format(". RMS <b>%.3g %s</b> as the machine is, <b>%.3g %s</b> corrected.</p>\n",
                            s.uncorrected / unit, name, s.corrected / unit, name);
  if (s.positioning.empty()) return html;
  html +=
      "<p>Accuracy and repeatability of positioning, ISO 230-2:2014, as the machine is → corrected, in µm "
      "(arcsec):</p>"
      "<table><thead><tr><th>Axis</th><th class=\"n\">A</th><th class=\"n\">R</th><th class=\"n\">E</th>"
      "<th class=\"n\">B</th><th class=\"n\">M</th></tr></thead><tbody>\n";
  for (const AxisPositioning& a : s.positioning) {
    html += "<tr><td>" + shown(a.name) + "</td>";
    const PositioningFigures &was = a.measured.figures, &is = a.calibrated.figures;
    for (const auto& [before, after] :
         {std::pair(was.accuracy, is.accuracy), std::pair(was.repeatability, is.repeatability),
          std::pair(was.systematic, is.systematic), std::pair(was.reversal, is.reversal),
          std::pair(was.meanRange, is.meanRange)})
      html += "<td class=\"n\">" +
              (std::isfinite(before) && std::isfinite(after) ? format("%.3g → %.3g", before, after)
                                                             : std::string("–")) +
              "</td>";
    html += "</tr>\n";
  }
  return html + "</tbody></table>\n";
}

const char* residualUnit(const Calibration& c) { return angularOnly(c) ? "arcsec" : "µm"; }

/// In the unit of its residuals.
std::string residualText(const Calibration& c, double v) {
  return std::isfinite(v) ? format("%.3g", v / (angularOnly(c) ? kArcsecond : kMicrometre))
                          : std::string("–");
}

std::string historySection(const Calibration& c) {
  const std::string unit = residualUnit(c);
  std::string html = sectionHead("History of this calibration") +
                     "<table><thead><tr><th>Time</th><th>Step</th><th>Effect</th><th class=\"n\">RMS, " +
                     unit + "</th><th class=\"n\">held out, " + unit + "</th></tr></thead><tbody>\n";
  const auto um = [&](double v) { return residualText(c, v); };
  for (const LedgerEntry& e : c.ledger)
    html += "<tr><td>" + shown(e.time) + "</td><td>" + shown(e.action) + "</td><td>" +
            (e.effect.type.empty() ? std::string("all") : shown(inWords(e.effect))) +
            "</td><td class=\"n\">" + um(e.rmsBefore) + " → " + um(e.rmsAfter) + "</td><td class=\"n\">" +
            um(e.heldOutBefore) + " → " + um(e.heldOutAfter) + "</td></tr>\n";
  html += "</tbody></table>\n";
  if (const std::string plot = historyPlot(c.ledger, angularOnly(c)); !plot.empty())
    html += "<figure>" + plot + "</figure>\n";
  return html;
}

constexpr std::size_t kMostEvents = 24;  // of the store, the last ones

/// What the store knows: which calibration was active when, and what fresh points said.
std::string storeSection(const Certificate& c) {
  std::string html = sectionHead("History of use");
  if (!c.store)
    return html +
           "<p>This calibration is in no store of calibrations that was named: when it was active, and "
           "how it was verified, is not recorded.</p>\n";
  const std::vector<StoreEvent>& events = c.store->events;
  html += "<p>In the store " + shown(c.store->folder) + ". At the time of issue this calibration is " +
          (c.store->active ? "<b>active</b>" : "<b>not active</b>") + ".</p>\n";
  if (events.empty())
    return html + "<p>It was not made active there yet, and no verification was recorded.</p>\n";
  const std::size_t first = events.size() > kMostEvents ? events.size() - kMostEvents : 0;
  if (first > 0) html += format("<p class=\"small\">%zu earlier entries are not listed.</p>\n", first);
  html +=
      "<table><thead><tr><th>Time</th><th class=\"which\">Calibration</th><th>What</th><th "
      "class=\"when\">Active until</th></tr></thead>"
      "<tbody>\n";
  for (std::size_t i = first; i < events.size(); ++i) {
    const StoreEvent& e = events[i];
    const bool own = e.id == c.calibration.id, use = startsWith(e.what, "made active");
    html += "<tr" + std::string(own ? " class=\"own\"" : "") + "><td class=\"when\">" + shown(e.time) +
            "</td><td class=\"which\">" + (own ? "this one" : shown(e.id)) + "</td><td>" + shown(e.what) +
            "</td><td class=\"when\">" + (use && e.until.empty() ? "today" : shown(e.until)) + "</td></tr>\n";
  }
  return html + "</tbody></table>\n";
}

std::string decisionSection(const Certificate& c) {
  bool asked = false;
  for (const CertifiedTask& t : c.tasks) asked = asked || !t.verdicts.empty();
  return sectionHead("Uncertainty and decision rule") +
         "<p>U is the standard uncertainty multiplied by the coverage factor k = 2, which for a normal "
         "distribution "
         "corresponds to a coverage probability of about 95 %. It was found by propagating the distributions "
         "of all "
         "causes named through the measurement (JCGM 101:2008; the method of ISO/TS 15530-4).</p><p>" +
         (asked ? "Conformity is stated by ISO 14253-1:2017: a value conforms, or does not conform, where "
                  "that has a "
                  "probability of 95 % or more in view of its uncertainty; between these nothing is proven."
                : "No specification was stated; no statement of conformity is made.") +
         "</p>\n";
}

}  // namespace

std::string certificatePage(const Certificate& c) {
  const Calibration& k = c.calibration;
  std::string html =
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" "
      "content=\"width=device-width, initial-scale=1\">\n<meta http-equiv=\"Content-Security-Policy\" "
      "content=\"default-src "
      "'none'; style-src 'unsafe-inline'; img-src data:; base-uri 'none'; form-action 'none'\">\n<link "
      "rel=\"icon\" "
      "href=\"data:,\">\n<title>Calibration certificate " +
      escapedHtml(k.id) + " – measuring machine certificate</title>\n<style>" + kStyle + footOfPage(k.id) +
      "</style>\n</head>\n<body>\n<main>\n<h1>Calibration certificate</h1>\n<p class=\"number\">No. " +
      escapedHtml(k.id) + "</p>\n";
  html += itemSection(c) + referenceSection(c) + environmentSection(k);
  if (!c.tasks.empty()) {
    html += sectionHead("Results: uncertainty of measurements with the corrected machine");
    for (const CertifiedTask& task : c.tasks) html += taskSection(task);
  }
  html += decisionSection(c);
  if (c.session) html += sessionSection(*c.session);
  html += parameterSection(k);
  const bool angular = angularOnly(k);
  const auto fixedFigure = [&](double v) { return residualText(k, v) + " " + residualUnit(k); };
  html += "<p>Residuals: RMS " + fixedFigure(angular ? k.rmsAngular : k.rms) +
          ", at measurements that the fit did not use " +
          fixedFigure(angular ? k.heldOutRmsAngular : k.heldOutRms) +
          format("; χ²/ν %.3g; repeatability ", k.chi2PerDof) + fixedFigure(k.repeatability) + " (" +
          escapedHtml(k.repeatabilityFrom) + ").</p>\n";
  if (!c.curves.empty()) {
    html += sectionHead("Correction over the axes");
    for (const CorrectionCurve& curve : c.curves)
      html += "<figure>" + correctionPlot(curve) + "<figcaption>Axis " + shown(curve.axis) +
              ", the others in the middle of their ranges, travelling upwards; band: U (k = "
              "2).</figcaption></figure>\n";
  }
  html += historySection(k) + storeSection(c);
  html += "<section class=\"together\">" + sectionHead("Authenticity") + "<p>Calibration file: CRC-64 " +
          escapedHtml(c.checksum.empty() ? checksumOf(k) : c.checksum) +
          ". The last line of this file holds it, the hash of the session, and the SHA-256 of everything "
          "before it; <code>mm certificate --check</code> refuses a certificate that was changed, and one "
          "whose calibration or session, where they are at hand, are others.</p>\n<div "
          "class=\"sign\"><div>Date</div><div>" +
          (c.facts.operatorName.empty() ? std::string("Signature")
                                        : "Signature, " + shown(c.facts.operatorName)) +
          "</div></div>\n</section>\n</main>\n</body>\n</html>\n";
  return html;
}

}  // namespace mm
