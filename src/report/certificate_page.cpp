// The certificate as HTML: a page of paper first of all.
#include <algorithm>
#include <boost/algorithm/string/replace.hpp>
#include <cctype>
#include <cmath>

#include "base/format.h"
#include "base/text.h"
#include "base/units.h"
#include "effects/effect_words.h"
#include "export/compensation_statement.h"
#include "report/certificate.h"
#include "report/certificate_facts.h"
#include "report/certificate_figures.h"
#include "report/certificate_plots.h"
#include "report/report_page.h"
#include "report/symbols_of.h"
#include "report/text_parts.h"
#include "report/uncertainty_output.h"
#include "report/web_files.h"

namespace mm {
namespace {

std::string nicely(std::string text) {  // units as they are printed
  for (const auto& [plain, nice] : {std::pair{"+-", "±"}, {" um", " µm"}, {"um/m", "µm/m"}, {"degC", "°C"}})
    boost::replace_all(text, plain, nice);
  return text;
}

std::string shown(const std::string& text) { return escapedHtml(nicely(text)); }

std::string rowOf(const std::string& name, const std::string& html) {
  return "<tr><th>" + escapedHtml(name) + "</th><td>" + (html.empty() ? "not stated" : html) + "</td></tr>\n";
}

std::string factRow(const std::string& name, const std::string& value) { return rowOf(name, shown(value)); }

/// Of what somebody typed: it is printed as it is.
std::string typedRow(const std::string& name, const std::string& value) {
  return rowOf(name, escapedHtml(value));
}

/// What stands at the foot of every printed page; the id may come from a foreign file.
std::string footOfPage(const std::string& title, const std::string& id) {
  std::string plain;
  for (const char c : id)
    if (std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-') plain += c;
  return "@page { @bottom-left { content: \"" + title + " " + plain +
         "\"; font: 8pt sans-serif; color: #444c56; } }\n";
}

std::string sectionHead(const std::string& text) { return "<h2>" + escapedHtml(text) + "</h2>\n"; }

std::string itemSection(const Certificate& c) {
  const Calibration& k = c.calibration;
  std::string html = "<table class=\"facts\">" + typedRow("Machine", k.machineName) +
                     typedRow("Serial number", c.facts.serial) + typedRow("Laboratory", c.facts.laboratory);
  if (!c.facts.customer.empty()) html += typedRow("Customer", c.facts.customer);
  if (!c.facts.place.empty()) html += typedRow("Place", c.facts.place);
  const std::string measured = dateOfMeasurement(k);
  html += typedRow("Operator", c.facts.operatorName) +
          factRow("Date of measurement", measured.empty() ? "not recorded" : measured) +
          factRow("Date of evaluation", k.created) + factRow("Date of issue", c.facts.issued) +
          (c.replaces.empty() ? std::string() : typedRow("Replaces", "certificate No. " + c.replaces)) +
          typedRow("Calibration", k.id) +
          typedRow("Measured as", k.sessionSource + " (" + std::to_string(k.observations) +
                                      " observations, hash " + k.sessionHash + ")") +
          factRow("Method", "parameters of " + std::to_string(k.effects.size()) +
                                (k.effects.size() == 1 ? " effect by " : " effects by ") + k.method +
                                ", measuring_machine " + k.software);
  if (!c.facts.remark.empty()) html += typedRow("Remark", c.facts.remark);
  return html + "</table>\n";
}

std::string referenceSection(const Certificate& c) {
  std::string html = sectionHead("Reference standard and its traceability") + "<table class=\"facts\">";
  if (const auto& a = c.calibration.artifact) {
    html += typedRow("Artifact", a->features > 0 ? a->name + ", " + std::to_string(a->features) + " features"
                                                 : std::string("independent instrument")) +
            typedRow("Serial number of the artifact", a->serial);
    const auto stated = [](double std) {
      return std > 0.0 ? format("U = %.2g um (k = 2), in the results", 2.0 * std / kMicrometre)
                       : std::string("taken as exact, not included in the results");
    };
    if (a->features > 0) {
      if (a->span > 0.0) html += factRow("Largest distance", format("%.5g mm", a->span / kMillimetre));
      html += factRow("Uncertainty of places", stated(a->centreStd)) +
              factRow("Uncertainty of radii", stated(a->radiusStd));
      html += factRow("Pose", a->poseKnown ? "known in the machine" : "found with the parameters");
    }
  } else {
    html += factRow("Artifact", "not recorded in the calibration file");
  }
  if (c.conditions.artifactScale > 0.0)
    html += factRow(
        "Uncertainty of the scale",
        format("U = %.2g um/m (k = 2), stated for the predicted results", 2e6 * c.conditions.artifactScale));
  if (c.conditions.artifactRadius > 0.0)
    html += factRow("Uncertainty of the reference ball's radius",
                    format("U = %.2g um (k = 2), stated for the predicted results",
                           2.0 * c.conditions.artifactRadius / kMicrometre));
  return html + typedRow("Traceability", c.facts.traceability) + "</table>\n";
}

std::string environmentSection(const Calibration& c) {
  const Domain& d = c.domain;
  std::string html = sectionHead("Conditions and range of validity") + "<table class=\"facts\">";
  for (const StatedFact& range : axisRanges(d)) html += factRow("Axis " + range.name, range.text);
  for (std::size_t s = 0; s < d.sensors.size(); ++s)
    html += factRow("Temperature " + d.sensors[s], rangeText(d.sensorLower[s], d.sensorUpper[s], "degC"));
  for (const StatedFact& range : covariateRanges(d)) html += factRow(range.name, range.text);
  if (d.sensors.empty()) html += factRow("Temperature", "not recorded");
  html += factRow("Duration", timesRecorded(d) ? format("%.3g h", d.duration / 3600.0) : "not recorded");
  for (const Wandering& w : c.drift)
    html += factRow(timesRecorded(d) ? "Drift seen" : "Variation seen", driftText(d, w));
  return html + "</table>\n<p class=\"small\">" + shown(scopeOfResults(c)) + "</p>\n";
}

std::string unitShown(const std::string& unit) { return unit == "um" ? std::string("µm") : shown(unit); }

/// U as it is printed beside a value: of a length in mm in µm, with the same digits.
std::string expandedShown(const StatedFigure& f) {
  if (f.held) return "held";
  if (!f.interval.empty()) return "95 %: " + f.interval;
  if (f.expanded.empty()) return f.note;
  if (f.unit != "mm") return f.expanded;
  const std::size_t point = f.expanded.find('.');
  const int decimals = point == std::string::npos ? 0 : static_cast<int>(f.expanded.size() - point) - 1;
  return format("%.*f µm", std::max(0, decimals - 3), std::stod(f.expanded) * kMillimetre / kMicrometre);
}

/// Figures of one origin, which stands above them.
std::string figureTable(const StatedGroup& group) {
  bool grouped = false;
  for (const StatedFigure& f : group.figures) grouped = grouped || !f.of.empty();
  std::string html = std::string("<div class=\"wide\"><table><thead><tr>") +
                     (grouped ? "<th>Effect</th>" : "") + "<th>" + (grouped ? "Parameter" : "Quantity") +
                     "</th><th class=\"n\">Value, " + nameOf(group.origin) + "</th><th class=\"u\">" +
                     group.uncertainty + "</th><th>Unit</th></tr></thead><tbody>\n";
  for (const StatedFigure& f : group.figures)
    html += "<tr>" + (grouped ? "<td>" + shown(f.of) + "</td>" : std::string()) + "<td>" + shown(f.name) +
            "</td><td class=\"n\">" + f.value + "</td><td class=\"n\">" + expandedShown(f) + "</td><td>" +
            unitShown(f.unit) + "</td></tr>\n";
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

/// The lengths of a test, in two columns, and their plot.
std::string lengthSection(const LengthTable& table) {
  const std::size_t half = (table.rows.size() + 1) / 2;
  std::string html =
      "<p>Error E of each length, predicted, in µm:</p>\n<div class=\"wide tests\"><table><thead><tr>";
  for (int column = 0; column < 2; ++column)
    html += "<th>Length</th><th class=\"n\">E</th><th class=\"n\">U (k = 2)</th><th class=\"n\">|E| + U</th>";
  html += "</tr></thead><tbody>\n";
  const auto cells = [&](std::size_t row) {
    if (row >= table.rows.size()) return std::string("<td></td><td></td><td></td><td></td>");
    const LengthRow& r = table.rows[row];
    const std::string mark = row == table.largest ? "b" : "span";
    return "<td>" + escapedHtml(r.error.name) + "</td><td class=\"n\">" + r.error.value +
           "</td><td class=\"n\">" + r.error.expanded + "</td><td class=\"n\"><" + mark + ">" + r.sumText +
           "</" + mark + "></td>";
  };
  for (std::size_t row = 0; row < half; ++row) html += "<tr>" + cells(row) + cells(row + half) + "</tr>\n";
  const LengthRow& largest = table.rows[table.largest];
  return html + "</tbody></table></div>\n<figure>" + lengthsPlot(table) +
         "<figcaption>Largest |E| + U of a length: " + largest.sumText + " µm (" +
         escapedHtml(largest.error.name) + "). Each length, for itself, keeps |E| + U within " +
         shown(table.least.inWords()) +
         " (L in mm). The largest |E| of a whole test is the largest of all its measurements; it is expected "
         "above the |E| of any one of them.</figcaption></figure>\n";
}

/// The statement of conformity, or why there is none.
std::string conformitySection(const CertifiedTask& task) {
  std::string html;
  if (task.asked && task.verdicts.empty()) {
    html = "<p class=\"verdict open\">No statement of conformity: " + shown(joined(task.noConformity, "; ")) +
           ".</p>\n";
  }
  for (const TaskVerdict& v : task.verdicts)
    html += std::string("<p class=\"verdict ") +
            (v.conformity == Conformity::kUndecided        ? "open"
             : v.conformity == Conformity::kDoesNotConform ? "fails"
             : v.measured                                  ? "conforms"
                                                           : "") +
            "\">" + headOf(task, v) + ": " + shown(v.inWords) + ".</p>\n";
  return html;
}

std::string taskSection(const CertifiedTask& task) {
  const TaskUncertainty& r = task.result;
  const QuantityUncertainty& headline = r.quantities[r.headline];
  std::string html =
      "<div class=\"task\"><h3>" + escapedHtml(r.task) + "</h3>\n" + figureTable(taskFigures(task));
  if (const LengthTable lengths = lengthTable(r); !lengths.rows.empty()) html += lengthSection(lengths);
  html += "<p>Uncertainty budget of the first figure:</p>\n" + budgetTable(headline);
  for (const std::string& why : r.outside)
    html += "<p class=\"verdict fails\">The calibration does not hold " + shown(why) + ".</p>\n";
  return html + conformitySection(task) +
         format("<p class=\"small\">%zu trials, seed %llu%s</p></div>\n", r.trials,
                static_cast<unsigned long long>(r.seed), r.stable ? "" : "; last digit not stable");
}

std::string conditionsSection(const Certificate& c) {
  std::string html = "<h3>Conditions of the prediction</h3>\n<table class=\"facts\">";
  for (const StatedFact& fact : conditionsOfPrediction(c)) html += factRow(fact.name, fact.text);
  return html + "</table>\n";
}

std::string sessionSection(const CertifiedSession& s, const std::vector<StatedGroup>& groups) {
  std::string html = sectionHead("Comparison with a session") + "<p>" + escapedHtml(s.path) + ": " +
                     std::to_string(s.observations) + " observations, " +
                     (s.sameSession ? "those of the calibration itself" : "not used for the calibration") +
                     "." + (s.positioning.empty() ? "" : " Figures of axes by ISO 230-2:2014.") + "</p>\n";
  for (const StatedGroup& group : groups)
    if (group.origin == FigureOrigin::kMeasured || group.origin == FigureOrigin::kCalculated)
      html += "<h3>" + shown(group.title) + "</h3>\n" + figureTable(group);
  return html;
}

const char* residualUnit(const Calibration& c) { return angularOnly(c) ? "arcsec" : "µm"; }

/// In the unit of its residuals.
std::string residualText(const Calibration& c, double v) {
  return std::isfinite(v) ? format("%.3g", v / (angularOnly(c) ? kArcsecond : kMicrometre))
                          : std::string("–");
}

/// What ISO/TR 16907 asks to be told of a numerical compensation.
std::string compensationSection(const Calibration& c) {
  const bool angular = angularOnly(c);
  std::string html =
      sectionHead("Numerical compensation, by ISO/TR 16907") + "<table class=\"facts\">" +
      factRow("Compensation", "model of the whole calibrated volume, for readings and targets");
  for (const CompensationFact& fact : compensationFacts(c, c.effects)) html += factRow(fact.name, fact.text);
  const double before = c.ledger.empty() ? kNotMeasured : c.ledger.front().rmsBefore;
  return html +
         factRow("Before and after",
                 "RMS of the residuals of the calibration's session: " + residualText(c, before) + " " +
                     residualUnit(c) + " of the machine as it reads (measured), " +
                     residualText(c, angular ? c.rmsAngular : c.rms) + " " + residualUnit(c) +
                     " compensated (calculated), " +
                     residualText(c, angular ? c.heldOutRmsAngular : c.heldOutRms) + " " + residualUnit(c) +
                     " at measurements that the fit did not use") +
         "</table>\n";
}

std::string historySection(const Calibration& c) {
  const std::string unit = residualUnit(c);
  std::string html =
      sectionHead("History of this calibration") +
      "<p>Residuals of the calibration's session under the model before and after each step, in " + unit +
      "; held out: at measurements that the fit did not use.</p>"
      "<table><thead><tr><th>Time</th><th>Step</th><th>Effect</th><th class=\"n\">RMS before</th>"
      "<th class=\"n\">RMS after</th><th class=\"n\">held out before</th><th class=\"n\">held out "
      "after</th></tr></thead><tbody>\n";
  const auto um = [&](double v) { return residualText(c, v); };
  const ErrorSymbols symbols = symbolsOf(c);
  for (const LedgerEntry& e : c.ledger)
    html += "<tr><td>" + shown(e.time) + "</td><td class=\"when\">" + shown(e.action) + "</td><td>" +
            (e.effect.type.empty() ? std::string("all") : shown(inWords(e.effect, symbols))) +
            "</td><td class=\"n\">" + um(e.rmsBefore) + "</td><td class=\"n\">" + um(e.rmsAfter) +
            "</td><td class=\"n\">" + um(e.heldOutBefore) + "</td><td class=\"n\">" + um(e.heldOutAfter) +
            "</td></tr>\n";
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
           "<p>This calibration is not in a named store of calibrations: its active periods and "
           "comparisons with fresh points are not recorded.</p>\n";
  const std::vector<StoreEvent>& events = c.store->events;
  html += "<p>In the store " + escapedHtml(c.store->folder) + ". At the time of issue this calibration is " +
          (c.store->active ? "<b>active</b>" : "<b>not active</b>") + ".</p>\n";
  if (events.empty())
    return html + "<p>It has not been active there, and no comparison with fresh points is recorded.</p>\n";
  const std::size_t first = events.size() > kMostEvents ? events.size() - kMostEvents : 0;
  if (first > 0) html += format("<p class=\"small\">%zu earlier entries are not listed.</p>\n", first);
  html +=
      "<table><thead><tr><th>Time</th><th class=\"which\">Calibration</th><th>What</th><th "
      "class=\"when\">Active until</th></tr></thead><tbody>\n";
  for (std::size_t i = first; i < events.size(); ++i) {
    const StoreEvent& e = events[i];
    const bool own = e.id == c.calibration.id, use = startsWith(e.what, "made active");
    html += "<tr" + std::string(own ? " class=\"own\"" : "") + "><td class=\"when\">" + shown(e.time) +
            "</td><td class=\"which\">" + (own ? "this one" : shown(e.id)) + "</td><td>" +
            escapedHtml(e.what) + "</td><td class=\"when\">" +
            (use && e.until.empty() ? "today" : shown(e.until)) + "</td></tr>\n";
  }
  return html + "</tbody></table>\n";
}

std::string decisionSection(const Certificate& c) {
  return sectionHead("Uncertainty and decision rule") +
         "<p>U is the standard uncertainty multiplied by the coverage factor k = 2, which for a normal "
         "distribution corresponds to a coverage probability of about 95 %" +
         (c.calibration.degreesOfFreedom > 0.0 && c.calibration.degreesOfFreedom < 30.0
              ? format(" (here less: the parameters have %.0f degrees of freedom)",
                       c.calibration.degreesOfFreedom)
              : std::string()) +
         ". It was found by propagating the distributions of all causes named through the measurement (JCGM "
         "101:2008; the method of ISO/TS "
         "15530-4).</p><p>" +
         decisionRule(c) + "</p>\n";
}

}  // namespace

std::string certificatePage(const Certificate& c) {
  const Calibration& k = c.calibration;
  const std::string title = titleOf(c);
  std::string html =
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" "
      "content=\"width=device-width, initial-scale=1\">\n<meta http-equiv=\"Content-Security-Policy\" "
      "content=\"default-src 'none'; style-src 'unsafe-inline'; img-src data:; base-uri 'none'; form-action "
      "'none'\">\n<link rel=\"icon\" href=\"data:,\">\n<title>" +
      title + " " + escapedHtml(c.number) + " – measuring machine certificate</title>\n<style>\n" +
      webFile("certificate.css") +
      footOfPage(isSimulated(k) ? title + ", " + kSimulatedNotice : title, c.number) +
      "</style>\n</head>\n<body>\n<main>\n<h1>" + title + "</h1>\n" +
      (isSimulated(k) ? std::string("<p class=\"verdict fails\">") + kSimulatedNotice + ".</p>\n"
                      : std::string()) +
      "<p class=\"number\">No. " + escapedHtml(c.number) + "</p>\n";
  html += itemSection(c) + referenceSection(c) + environmentSection(k);
  const std::vector<StatedGroup> groups = statedGroups(c);
  html += sectionHead("Results: parameters of the machine, estimated from the measurements") + "<p>" +
          modelLeaves(k) + ".</p>\n";
  for (const StatedGroup& group : groups)
    if (group.origin == FigureOrigin::kEstimated) html += figureTable(group);
  if (c.session) html += sessionSection(*c.session, groups);
  if (!c.tasks.empty()) {
    html += sectionHead("Predicted: uncertainty of measurements with the corrected machine") +
            "<p>Each task was simulated on the machine that the calibration describes. None was measured, "
            "and these figures are no results of an acceptance test.</p>\n";
    html += conditionsSection(c);
    for (const CertifiedTask& task : c.tasks) html += taskSection(task);
  }
  html += decisionSection(c);
  if (!c.curves.empty()) {
    html += sectionHead("Calculated: correction over the axes");
    for (const CorrectionCurve& curve : c.curves)
      html +=
          "<figure>" + correctionPlot(curve) + "<figcaption>Axis " + escapedHtml(curve.axis) +
          ", the others in the middle of their ranges, travelling upwards; band: " + parameterUncertainty(k) +
          ".</figcaption></figure>\n";
  }
  html += compensationSection(k) + historySection(k) + storeSection(c);
  html +=
      "<section class=\"together\">" + sectionHead("Authenticity") + "<p>Calibration file: CRC-64 " +
      escapedHtml(c.checksum) +
      ". The last line of this file holds it, the number of this issue, the hash of the session, and the "
      "SHA-256 of everything before it; <code>mm certificate --check</code> compares the content with this "
      "checksum, and calibration and session, where they are available, with what it names. The checksum "
      "has no key: it shows an accidental change, not who made one. A digital certificate (<code>-o "
      "certificate.xml --sign</code>) is protected by a signature.</p>\n<div class=\"sign\"><div>Date"
      "</div><div>" +
      (c.facts.authorisedBy.empty() ? std::string("Authorised by: not stated")
                                    : "Authorised by: " + escapedHtml(c.facts.authorisedBy)) +
      "</div></div>\n</section>\n</main>\n</body>\n</html>\n";
  return html;
}

}  // namespace mm
