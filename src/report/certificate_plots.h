#pragma once
#include <string>
#include <vector>

#include "report/certificate_figures.h"

namespace mm {

// Pictures of the certificate, as inline SVG: for the screen and for paper.

/// A curve of a plot, with a band about it.
struct PlotSeries {
  std::string name, colour;
  std::vector<double> x, y, band;        // band: half width at each point; empty: none
  bool points = false;                   // marks instead of a line
  std::vector<std::string> titles = {};  // of the marks
};

/// @param x, y labels of the axes with their units. @param fromZero both axes show zero. @param counted
/// x is marked at whole numbers. @return empty:
/// nothing to draw.
std::string svgPlot(const std::string& x, const std::string& y, const std::vector<PlotSeries>& series,
                    bool fromZero = false, bool counted = false);

/// Correction over one axis: three components with their expanded uncertainty.
std::string correctionPlot(const CorrectionCurve& curve);
/// |E| + U of each length of a test over its length, the line A + L/K that none exceeds, and the expected
/// largest |E| of the whole test. Each mark is titled with its figure in the table.
std::string lengthsPlot(const LengthTable& lengths);
/// RMS after each step of the calibration.
std::string historyPlot(const std::vector<LedgerEntry>& ledger, bool angular);

}  // namespace mm
