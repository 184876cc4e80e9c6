#include <algorithm>
#include <cmath>

#include "base/units.h"
#include "report/symbols_of.h"
#include "report/text.h"
#include "report/text_parts.h"

namespace mm {

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

std::string curveText(const GeneticSummary& genetic, bool angular) {
  constexpr std::size_t kColumns = 60;
  constexpr int kRows = 8;
  const std::size_t count = genetic.curve.size(), columns = std::min(kColumns, count);
  std::vector<double> level;
  for (std::size_t c = 0; c < columns; ++c) {
    const std::size_t i = columns > 1 ? c * (count - 1) / (columns - 1) : 0;
    constexpr double kZero = 1e-300;  // of an RMS of zero there is no logarithm
    level.push_back(std::log10(std::max(genetic.curve[i], kZero)));
  }
  const auto range = std::minmax_element(level.begin(), level.end());
  constexpr double kLevel = 1e-9;  // decades: a curve that is level has a height all the same
  const double low = *range.first, high = std::max(*range.second, low + kLevel);
  std::string text =
      "  best RMS a generation (logarithmic), generation 0 to " + std::to_string(count - 1) + "\n";
  for (int row = kRows; row >= 0; --row) {
    const double at = low + (high - low) * row / kRows;
    std::string line(columns, ' ');
    for (std::size_t c = 0; c < columns; ++c)
      if (std::lround((level[c] - low) / (high - low) * kRows) == row) line[c] = '*';
    const bool labelled = row == kRows || row == 0 || row == kRows / 2;
    text += "  " + padded(labelled ? length(std::pow(10.0, at), angular) : "", 16) + "|" + line + "\n";
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
