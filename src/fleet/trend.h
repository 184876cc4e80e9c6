#pragma once
#include <string>
#include <vector>

namespace mm {

/// One value of a quantity at one time, with its standard uncertainty (0: not known).
struct TrendPoint {
  double day = 0.0;  // from any zero
  double value = 0.0, std = 0.0;
};

/// Points [first, end) that share a level.
struct TrendSegment {
  std::size_t first = 0, end = 0;
  double level = 0.0, std = 0.0;  // weighted mean and its standard uncertainty
};

/// How a quantity went over time.
struct Trend {
  enum class Kind { kQuiet, kDrift, kSteps };
  Kind kind = Kind::kQuiet;
  double p = 1.0;        // of the strongest evidence against quiet, corrected for where it was sought
  double scatter = 0.0;  // beyond the stated uncertainties, from one session to the next
  double slope = 0.0, slopeStd = 0.0;  // a day, over all points
  double start = 0.0, end = 0.0;       // kDrift: values of the line at the first and the last point
  std::vector<TrendSegment> segments;  // kSteps: two or more; else one
  std::vector<double> stepP;           // of the step between segment i and i + 1
};

/// Tests a series for a drift and for steps at unknown times. A point varies by its stated uncertainty and by
/// a scatter from session to session, which is found from differences of neighbours (steps and outliers
/// hardly change their median). Each place of a step is a t-test of the two means, with the scale of the
/// residuals where that is larger than stated; the p-value is multiplied by the number of places and of
/// hypotheses (Bonferroni), so that it errs on the quiet side. Where both a step and a drift would do, the
/// one with the smaller BIC is taken. Found steps are sought again in both parts (binary segmentation; Scott
/// and Knott, Biometrics 30 (1974) 507).
/// @param points ascending in time. @param alpha chance of a false alarm that is accepted for this series.
Trend trendOf(const std::vector<TrendPoint>& points, double alpha);

/// Scatter beyond the stated uncertainties that makes the median of |value| / sqrt(std^2 + scatter^2) that of
/// normal numbers; 0 where they scatter less than stated.
double excessScatter(const std::vector<double>& value, const std::vector<double>& variance);

}  // namespace mm
