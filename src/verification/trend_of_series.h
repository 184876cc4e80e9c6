#pragma once
#include <cstddef>
#include <limits>
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
  double p = 1.0;  // of the strongest evidence against quiet, corrected for where it was sought
  /// Standard deviation between sessions beyond the stated uncertainties, about the level (kQuiet), the line
  /// (kDrift) or the first step that was found (kSteps).
  double scatter = 0.0;
  /// A day: the weighted line through all points, with the scatter about it. NaN: they are of less than a
  /// day, in which a drift is not told from the daily cycle of temperature.
  double slope = std::numeric_limits<double>::quiet_NaN(), slopeStd = slope;
  double start = 0.0, end = 0.0;       // values of the line at the first and the last point
  std::vector<TrendSegment> segments;  // kSteps: two or more; else one
  std::vector<double> stepP;           // of the step between segment i and i + 1
};

/// Tests a series for a drift and for steps at unknown times.
///
/// A point varies by its stated uncertainty, none by less than the median of them, and by a scatter between
/// sessions, a random effect. Its variance is estimated about each hypothesis (a level; a step at k; two
/// steps of which the second takes the first back; a straight line) by the method of Paule and Mandel (J.
/// Res. NBS 87 (1982) 377), so that a drift is not in the scatter by which it is judged, and never below 0: a
/// residual counts at least as stated. The statistic is that of Hartung and Knapp (Statistics in Medicine 20
/// (2001) 3875), Student's t with two degrees of freedom fewer than there are points; for equal uncertainties
/// it is the exact F test of the hypothesis against a level, whatever the scatter.
///
/// From few sessions a scatter may seem small by chance, which the t test allows for whatever is stated. Of a
/// line through six points or more, a second, moderated t (Smyth, Stat. Appl. Genet. Mol. Biol. 3 (2004) 3)
/// takes the stated uncertainties as evidence of the scatter: three times as large, they count as six more
/// degrees of freedom, and less where the variance of the residuals exceeds twice the stated one. The smaller
/// p-value is taken. Of six points a false alarm at the level 1e-3 (1e-4) is then at most 1.1 (1.6) times as
/// frequent, at the worst scatter, 10 to 20 times the stated uncertainty; `usual` takes account of a scatter
/// that a whole fleet has.
///
/// The p-value is multiplied by the number of hypotheses and of places (Bonferroni), which far out is nearly
/// exact. Of several hypotheses below `alpha` the likeliest is taken, each unknown at the price of BIC. Where
/// a step is found, others are sought in both parts (binary segmentation; Scott and Knott, Biometrics 30
/// (1974) 507). A drift is asked for from three points and a day on, steps from
/// five points.
/// @param series ascending in time. @param alpha chance of a false alarm that is accepted for this series.
/// @param usual variance of residuals in units of the stated one that series of this kind have, as
/// `residualVariance` says of each; at least 1.
Trend trendOf(const std::vector<TrendPoint>& series, double alpha, double usual = 1.0);

/// Variance of the residuals about a line, in units of the stated variances. NaN: fewer than three points,
/// less than a day, or an uncertainty is not stated.
double residualVariance(const std::vector<TrendPoint>& series);

}  // namespace mm
