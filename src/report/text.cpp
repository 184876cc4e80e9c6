#include "report/text.h"

#include <algorithm>
#include <cmath>

#include "base/units.h"
#include "design/weak_directions.h"
#include "effects/linearity.h"
#include "report/certificate_figures.h"
#include "report/found_features.h"
#include "report/symbols_of.h"
#include "report/text_parts.h"
#include "session/session_summary.h"

namespace mm {
namespace {

/// One line a kind of residual: RMS, held out.
std::string figuresText(const CalibrationResult& r) {
  std::string text;
  for (const bool angular : {false, true}) {
    const double before = angular ? r.before.rmsAngular : r.before.rms,
                 after = angular ? r.figures.rmsAngular : r.figures.rms;
    const double heldBefore = angular ? r.before.heldOutRmsAngular : r.before.heldOutRms;
    const double heldAfter = angular ? r.figures.heldOutRmsAngular : r.figures.heldOutRms;
    if (!std::isfinite(after)) continue;
    text +=
        "  RMS            " + padded(length(before, angular), 16) + " -> " + length(after, angular) + "\n";
    text += "  RMS held out   " + padded(length(heldBefore, angular), 16) + " -> " +
            length(heldAfter, angular) + "\n";
  }
  return text;
}

std::string parametersText(const CalibrationResult& r) {
  const Model& model = r.problem->model();
  const ErrorSymbols symbols = symbolsOf(r);
  std::string text;
  for (std::size_t e = 0; e < model.effects().size(); ++e) {
    const Effect& effect = *model.effects()[e];
    text += "  " + inWords(effect.spec(), symbols) + "\n";
    if (const LearnedNetwork* learned = effect.network()) text += "    " + learned->summary + "\n";
    for (int k = 0; k < effect.parameterCount(); ++k) {
      const int i = model.offset(static_cast<int>(e)) + k;
      const Parameter& p = model.parameter(i);
      const bool fixed = r.identifiability.fixed[static_cast<std::size_t>(i)] != 0;
      text += "    " + padded(p.name, 18) +
              (fixed ? sixDigits(r.x[i] * p.toUnit) + (p.unit == "1" ? "" : " " + p.unit) + "  (held)"
                     : withUncertainty(r.x[i] * p.toUnit, r.std(i) * p.toUnit, p.unit)) +
              "\n";
    }
  }
  return text.empty() ? "  none: the machine as its scales indicate\n" : text;
}

std::string lostText(const CalibrationResult& r) {
  std::string text;
  for (const LostDirection& l : r.identifiability.lost) {
    if (!l.ofTheModel) continue;
    const Unknown& fixed = r.problem->unknowns()[static_cast<std::size_t>(l.fixedUnknown)];
    text += "  " + l.inWords + "\n    held: " + displayName(*r.problem, l.fixedUnknown) + " = " +
            sixDigits(r.x[l.fixedUnknown] * fixed.toUnit) +
            (l.byConvention  ? ", by convention"
             : l.noInfluence ? ", because no measurement here depends on it"
                             : "") +
            "; " + l.wouldShow + "\n";
  }
  return text.empty() ? text : "Not determined by this session\n" + text;
}

std::string outliersText(const CalibrationResult& r) {
  if (r.outliers.empty()) return {};
  constexpr std::size_t kShown = 12;
  std::string text = format("Outliers, set aside: %zu\n", r.outliers.size());
  for (std::size_t i = 0; i < std::min(kShown, r.outliers.size()); ++i) {
    const ResidualRow& row = r.problem->rows()[static_cast<std::size_t>(r.outliers[i].row)];
    const Session& session = r.problem->session();
    const Observation& at = session.observations[static_cast<std::size_t>(row.observation)];
    text += "  " + session.rowText(at.row, at.recording) + "   residual " +
            length(r.outliers[i].residual, row.angular) + "\n";
  }
  if (r.outliers.size() > kShown)
    text += format("  and %zu more (--json lists them)\n", r.outliers.size() - kShown);
  return text;
}

/// Zeros of instruments that are clearly not zero: who expects an offset among the errors finds it here.
std::string zerosText(const CalibrationResult& r) {
  constexpr double kClearly = 3.0;  // standard deviations
  constexpr int kShown = 6;
  std::string text;
  int found = 0;
  for (int i = 0; i < r.problem->unknownCount(); ++i) {
    const Unknown& u = r.problem->unknowns()[static_cast<std::size_t>(i)];
    if (u.kind != UnknownKind::kSetup || r.identifiability.fixed[static_cast<std::size_t>(i)] != 0 ||
        !(std::abs(r.x[i]) > kClearly * r.std(i)))
      continue;
    if (++found > kShown) continue;
    text +=
        "  " + padded(u.name, 36) + withUncertainty(r.x[i] * u.toUnit, r.std(i) * u.toUnit, u.unit) + "\n";
  }
  if (found > kShown) text += format("  and %d more\n", found - kShown);
  return text.empty() ? text
                      : "Zeros of the instrument, fitted with the model: deviations count from them\n" + text;
}

std::string repeatabilityText(const CalibrationResult& r) {
  const std::string from = r.repeatabilityFrom == "declared"   ? "declared"
                           : r.repeatabilityFrom == "repeated" ? r.repeated.inWords
                                                               : "estimated from the residuals";
  const bool exact = r.repeatabilityFrom == "estimated" && r.figures.degreesOfFreedom == 0;
  return exact ? "not known: degrees of freedom 0" : length(r.repeatability, angularOnly(r)) + ", " + from;
}

std::string noiseText(const CalibrationResult& r) {
  std::string text = "  Repeatability  " + repeatabilityText(r) + "\n";
  if (r.repeatabilityFrom != "estimated")
    text += format("  chi2 / dof     %.4g (1: only noise is left)\n", r.figures.chi2PerDof);
  if (r.centresStd > 0.0 || r.radiiStd > 0.0) {
    const auto by = [](double std, const char* what) {
      return std > 0.0 ? std::string(what) + " by " + length(std, false) : std::string();
    };
    text += "  Artifact       its " + std::to_string(r.problem->session().artifact.features.size()) +
            " balls scatter about their values in the file, " +
            by(r.centresStd, "each coordinate of a centre") +
            (r.centresStd > 0.0 && r.radiiStd > 0.0 ? ", " : "") + by(r.radiiStd, "radii") +
            " (standard deviation); the uncertainties allow for it\n";
  }
  for (const Drift& d : r.drift)
    text +=
        "  In time        residuals are autocorrelated, by drift or by an effect that the model lacks, "
        "of this axis or another; the uncertainties allow for a drift " +
        driftText(r.problem->model().domain(), {d.direction, d.std, d.timeConstant, d.smooth}) + "\n";
  return text;
}

std::string featuresText(const CalibrationResult& r) {
  constexpr int kShown = 12;
  std::string text;
  int found = 0;
  for (const FoundFeature& f : foundFeatures(r)) {
    if (!(f.std.maxCoeff() > 0.0) || ++found > kShown) continue;
    text += "  " + padded(f.name, 12) +
            format("%11.5f %11.5f %11.5f mm   ± %.2g %.2g %.2g um\n", f.position.x() / kMillimetre,
                   f.position.y() / kMillimetre, f.position.z() / kMillimetre, 2.0 * f.std.x() / kMicrometre,
                   2.0 * f.std.y() / kMicrometre, 2.0 * f.std.z() / kMicrometre);
  }
  if (text.empty()) return {};
  if (found > kShown) text += format("  and %d more (--json lists them)\n", found - kShown);
  return "Found in workpiece (centres of balls, points)\n" + text;
}

/// A genetic algorithm has nothing to search where least squares has one minimum.
std::string withoutSearch(const CalibrationResult& r) {
  const auto& effects = r.problem->model().effects();
  const bool linear = std::all_of(effects.begin(), effects.end(), [](const EffectPtr& e) {
    return static_cast<int>(linearParameters(*e).size()) == e->parameterCount();
  });
  return linear ? "                  (every parameter is linear: --method least_squares finds the same "
                  "without a search)\n"
                : "";
}

/// Why a genetic algorithm may be better than what was refined: it fits every ball's centre for itself.
std::string freerCentres(const CalibrationResult& r) {
  const double refined = angularOnly(r) ? r.figures.rmsAngular : r.figures.rms;
  const auto& features = r.problem->session().artifact.features;
  const bool held = std::any_of(features.begin(), features.end(),
                                [](const Feature& f) { return f.kind == FeatureKind::kBall && f.known; });
  if (!held || !(r.genetic->rms < refined)) return {};
  return "                  (lower: each ball centre was free; the refinement holds them at the artifact's "
         "values)\n";
}

}  // namespace

std::string calibrateText(const CalibrationResult& r) {
  const bool angular = angularOnly(r);
  std::string text = format("%zu observations, %d residuals, %d of %d parameters determined\n",
                            r.problem->session().observations.size(), r.problem->rowCount(),
                            r.identifiability.rank, r.identifiability.parameters);
  if (!r.problem->leftOut().empty())
    text += format("%zu observations lack an input of the model and were left out\n",
                   r.problem->leftOut().size());
  const std::string assumed = assumedText(r.problem->session());
  if (!assumed.empty()) text += assumed + "\n";
  text += "\nError                nominal machine     calibrated\n" + figuresText(r) + noiseText(r);
  const std::string parameters = parametersText(r);
  text += "\nParameters\n" + parameters;
  const std::string lost = lostText(r), features = featuresText(r), outliers = outliersText(r),
                    zeros = zerosText(r);
  if (!lost.empty()) text += "\n" + lost;
  for (const WeakDirection& w : weakDirections(r)) text += "Weak: " + w.inWords + "\n";
  if (!features.empty()) text += "\n" + features;
  if (!zeros.empty()) text += "\n" + zeros;
  if (parameters.find("±") != std::string::npos || features.find("±") != std::string::npos || !zeros.empty())
    text += "\n± is the expanded uncertainty, k = 2\n";
  if (!outliers.empty()) text += "\n" + outliers;
  text += "\nSearch\n";
  if (r.genetic)
    text += "  " + padded(r.genetic->method, 16) +
            (r.genetic->evaluations == 0
                 ? r.genetic->stop
                 : "RMS " + length(r.genetic->rms, angular) +
                       format(", %zu generations, %zu evaluations in %.2f s, seed %llu, stopped by %s",
                              r.genetic->generations, r.genetic->evaluations, r.genetic->seconds,
                              static_cast<unsigned long long>(r.genetic->seed), r.genetic->stop.c_str())) +
            "\n";
  else
    text += "  least squares   from the start values of the model, no search\n";
  if (r.genetic && r.genetic->evaluations > 0) text += freerCentres(r) + withoutSearch(r);
  text += "  refined         RMS " + length(angular ? r.figures.rmsAngular : r.figures.rms, angular) +
          format(", %d iterations, %s\n", r.iterations, r.stop.c_str());
  if (r.cancelled) text += "Stopped early: these are the best values found so far.\n";
  return text;
}

std::string nextText(const CalibrationResult& r, const std::string& session, const std::string& calibration) {
  const bool angular = angularOnly(r);
  const double rms = angular ? r.figures.rmsAngular : r.figures.rms;
  const double held = angular ? r.figures.heldOutRmsAngular : r.figures.heldOutRms;
  const double left = timesRepeatability(r.repeatabilityFrom, r.figures.chi2PerDof);
  std::string why;
  if (left > kLeavesMore)
    why = format("The model leaves %.*f times the repeatability", left < 10.0 ? 1 : 0, left);
  else if (held > kLeavesMore * rms)
    why = format("Held out, the model leaves %.1f times what it leaves where it was fitted", held / rms);
  const std::string typed = diagnoseCommand(session, calibration.empty() ? "c.yaml" : calibration) +
                            (calibration.empty() ? ", once it is written with -o c.yaml," : "");
  return (why.empty() ? "Next: " + typed + " says whether the model lacks anything"
                      : why + ": " + typed + " says what it lacks") +
         "\n";
}

std::string errorText(const CalibrationResult& r, double before) {
  const bool angular = angularOnly(r);
  const ResidualFigures& f = r.figures;
  return "RMS " + length(before, angular) + " -> " + length(angular ? f.rmsAngular : f.rms, angular) +
         ", held out " + length(angular ? f.heldOutRmsAngular : f.heldOutRms, angular) + "; repeatability " +
         repeatabilityText(r);
}

std::string compareText(const CalibrationResult& c, const std::vector<WhereItFails>& where) {
  std::string text = format("%zu observations, %d residuals; the calibration's values are held\n",
                            c.problem->session().observations.size(), c.problem->rowCount());
  text +=
      "\nError                nominal machine     with this calibration\n" + figuresText(c) + noiseText(c);
  for (const bool angular : {false, true}) {
    const SizeOfResiduals size = sizeOfResiduals(c, angular);
    if (size.count == 0) continue;
    text += "  Quantiles      ";
    for (const auto& [percent, value] : size.quantiles)
      text += format("%d %%: ", percent) + length(value, angular) + "   ";
    text += "\n  Largest        " + length(size.max, angular) + "\n";
  }
  text += "\n" + whereText(where);
  const std::string outliers = outliersText(c);
  if (!outliers.empty()) text += "\n" + outliers;
  return text;
}

std::string ledgerText(const Calibration& calibration, bool angular) {
  const std::vector<LedgerEntry>& ledger = calibration.ledger;
  if (ledger.empty()) return "The ledger is empty.\n";
  double largest = 0.0;
  for (const LedgerEntry& e : ledger)
    for (const double v : {e.rmsBefore, e.rmsAfter})
      if (std::isfinite(v)) largest = std::max(largest, v);
  const auto bar = [&](double value) {
    constexpr int kWidth = 16;
    const double share = std::isfinite(value) && largest > 0.0 ? value / largest : 0.0;
    return std::string(static_cast<std::size_t>(std::lround(kWidth * share)), '#');
  };
  std::string text = padded("Ledger", 70) + padded("RMS", 13) + "held out\n";
  text += "  " + padded("nominal machine", 68) + padded(length(ledger.front().rmsBefore, angular), 13) +
          padded(length(ledger.front().heldOutBefore, angular), 13) + bar(ledger.front().rmsBefore) + "\n";
  const ErrorSymbols symbols = symbolsOf(calibration);
  for (const LedgerEntry& e : ledger) {
    const std::string symbol = symbols.of(e.effect);
    const std::string what = e.action + (e.effect.type.empty() ? "" : " " + e.effect.yaml()) +
                             (symbol.empty() ? "" : " (" + symbol + ")");
    text += "  " + padded(what, 67) + " " + padded(length(e.rmsAfter, angular), 13) +
            padded(length(e.heldOutAfter, angular), 13) + bar(e.rmsAfter) + "\n";
  }
  return text;
}

std::string curveCsv(const GeneticSummary& genetic, bool angular) {
  std::string text = angular ? "generation,rms_arcsec\n" : "generation,rms_um\n";
  for (std::size_t i = 0; i < genetic.curve.size(); ++i)
    text += format("%zu,%.9g\n", i, genetic.curve[i] / (angular ? kArcsecond : kMicrometre));
  return text;
}

}  // namespace mm
