#include "verification/trend_of_series.h"

#include <algorithm>
#include <cmath>

#include "base/median.h"
#include "estimation/residual_space.h"

namespace mm {
namespace {

constexpr double kAnyWeight = 1e-9, kLeastWeight = 1e-12;  // of the largest value; in the unit of the values
constexpr std::size_t kFewestForLine = 3, kFewestForStep = 5;
// d: every day a machine goes through a cycle of temperature; less of it does not tell a drift from its hour.
constexpr double kShortestLine = 1.0;
constexpr std::size_t kLongSeries =
    8;  // from here on a segment has three points: two bad sessions are no change
constexpr double kNever = std::numeric_limits<double>::infinity();

/// Sums over some points: their weighted mean, and what they scatter about it.
struct WeightedSums {
  double weight, wy, wyy;  // weights, and weighted values and squares from the origin
  double origin;
  double level() const { return origin + wy / weight; }
  double chi2() const { return std::max(0.0, wyy - wy * wy / weight); }
};

/// Running sums: those of any segment in constant time.
class SegmentSums {
 public:
  /// @param scatter variance between sessions.
  SegmentSums(const std::vector<TrendPoint>& points, double scatter, double origin) : origin_(origin) {
    w_.push_back(0.0);
    wy_.push_back(0.0);
    wyy_.push_back(0.0);
    for (const TrendPoint& p : points) {
      const double weight = 1.0 / (p.std * p.std + scatter), y = p.value - origin;
      w_.push_back(w_.back() + weight);
      wy_.push_back(wy_.back() + weight * y);
      wyy_.push_back(wyy_.back() + weight * y * y);
    }
  }
  /// Of [a, b).
  WeightedSums of(std::size_t a, std::size_t b) const {
    return {w_[b] - w_[a], wy_[b] - wy_[a], wyy_[b] - wyy_[a], origin_};
  }
  WeightedSums all() const { return of(0, w_.size() - 1); }
  /// Of all but [i, j), with one level.
  WeightedSums around(std::size_t i, std::size_t j) const {
    const std::size_t end = w_.size() - 1;
    return {j == end ? w_[i] : w_[end] - (w_[j] - w_[i]), wy_[end] - wy_[j] + wy_[i],
            wyy_[end] - wyy_[j] + wyy_[i], origin_};
  }

 private:
  std::vector<double> w_, wy_, wyy_;
  double origin_;
};

/// What a hypothesis says of points: the size of what happened against a level, and what is left.
struct Contrast {
  double size = 0.0, variance = 0.0;  // by the weights alone
  double chi2 = 0.0;
  double squared() const { return variance > 0.0 ? size * size / variance : 0.0; }
};

/// A straight line.
struct TrendLine : Contrast {        // size: its slope, a day
  double middle = 0.0, level = 0.0;  // it goes through here
};

TrendLine lineThrough(const std::vector<TrendPoint>& points, double scatter) {
  double w = 0, wx = 0, wy = 0;
  const auto weightOf = [&](const TrendPoint& p) { return 1.0 / (p.std * p.std + scatter); };
  for (const TrendPoint& p : points) {
    const double weight = weightOf(p);
    w += weight;
    wx += weight * p.day;
    wy += weight * p.value;
  }
  TrendLine line;
  line.middle = wx / w;
  line.level = wy / w;
  double xx = 0, xy = 0;
  for (const TrendPoint& p : points) {
    const double weight = weightOf(p), x = p.day - line.middle;
    xx += weight * x * x;
    xy += weight * x * (p.value - line.level);
  }
  if (!(xx > 0.0)) return line;  // all on one day
  line.size = xy / xx;
  line.variance = 1.0 / xx;
  for (const TrendPoint& p : points) {
    const double r = p.value - line.level - line.size * (p.day - line.middle);
    line.chi2 += weightOf(p) * r * r;
  }
  return line;
}

/// None is taken to be better known than the median: few that are would have all the weight, and the scatter
/// of few sessions tells too late that they do not deserve it.
std::vector<TrendPoint> knownNoBetterThanUsual(std::vector<TrendPoint> points) {
  std::vector<double> stds;
  for (const TrendPoint& p : points) stds.push_back(p.std);
  const double usual = median(std::move(stds));
  for (TrendPoint& p : points) p.std = std::max(p.std, usual);
  return points;
}

/// Whether the time between tells a rate.
bool longEnough(const std::vector<TrendPoint>& points) {
  return points.back().day - points.front().day >= kShortestLine;
}

/// Whether every uncertainty is stated.
bool allStated(const std::vector<TrendPoint>& points) {
  return std::all_of(points.begin(), points.end(), [](const TrendPoint& p) { return p.std > 0.0; });
}

/// The smallest variance of a point that is told from none.
double leastVariance(const std::vector<TrendPoint>& points) {
  double largest = 0.0;
  for (const TrendPoint& p : points) largest = std::max(largest, std::abs(p.value));
  const double least = std::max(kAnyWeight * largest, kLeastWeight);
  return least * least;
}

/// Variance between sessions with which chi2 is the number of degrees of freedom (Paule and Mandel 1982); 0
/// where it is less without any. chi2 falls with it more slowly than in proportion, so that each step stays
/// on the side from which it comes; of equal uncertainties the first one arrives.
/// @param chi2 of the variance between sessions.
template <class Chi2>
double varianceBetween(const std::vector<TrendPoint>& points, double dof, const Chi2& chi2) {
  double least = kNever, mean = 0.0;
  for (const TrendPoint& p : points) {
    least = std::min(least, p.std * p.std);
    mean += p.std * p.std / points.size();
  }
  const double lowest = allStated(points) ? 0.0 : leastVariance(points);
  if (!(dof > 0.0) || chi2(lowest) <= dof) return lowest;
  double total = least + std::max(mean, lowest);  // of the best known point
  constexpr int kSteps = 100;
  constexpr double kNear = 1e-9;
  for (int i = 0; i < kSteps; ++i) {
    const double ratio = chi2(std::max(lowest, total - least)) / dof;
    total = std::max(least + lowest, total * ratio);
    if (std::abs(ratio - 1.0) < kNear) break;
  }
  return std::max(lowest, total - least);
}

double twoSided(double squaredT, double dof) {
  if (!std::isfinite(squaredT)) return std::isnan(squaredT) ? 1.0 : 0.0;
  return std::exp(logPValueF(squaredT, 1.0, dof));
}

/// Student's t, the residuals as they are but at least as stated.
double plainP(const Contrast& c, double dof) {
  return twoSided(c.squared() / std::max(1.0, c.chi2 / dof), dof);
}

/// See trendOf. @param c by variances that are larger than stated by the factor `excess`, at least 1: the
/// variance of the residuals in units of the stated one.
double moderatedP(const Contrast& c, double excess, double dof, double usual) {
  constexpr double kMore = 6.0;         // degrees of freedom that the stated uncertainties count for
  constexpr double kTimesStated = 9.0;  // variance
  constexpr double kFewest = 4.0;       // of its own, to contradict the stated ones
  constexpr double kContradiction = 2.0, kSteepness = 4.0;  // excess from which on they count less
  if (dof < kFewest) return 1.0;
  const double more = kMore * std::min(1.0, std::pow(kContradiction * usual / excess, kSteepness));
  return twoSided(c.squared() * (dof + more) / (c.chi2 + more * kTimesStated * usual / excess), dof + more);
}

/// A hypothesis that was fitted.
struct Candidate {
  double p = 1.0, criterion = kNever;
  double scatter = 0.0;          // variance between sessions about it
  std::size_t at = 0, back = 0;  // of a step: first point after it; of one that is taken back: after that
};

class TrendSearch {
 public:
  TrendSearch(const std::vector<TrendPoint>& points, double alpha, double usual)
      : points_(points), alpha_(alpha), usual_(std::max(1.0, usual)) {}

  /// @param first where `part` begins in the whole series. @param scatter of the step that made the part.
  void look(const std::vector<TrendPoint>& part, std::size_t first, double scatter, Trend& trend) const {
    const bool whole = part.size() == points_.size();
    const double families = (whole && asksLine(part) ? 2.0 : 1.0) * (asksBump(part) ? 2.0 : 1.0);
    const double ofDrift = whole && asksLine(part) && part.size() >= kFewestForStep ? 2.0 : 1.0;
    const Candidate step = bestStep(part, families), bump = bestBump(part, families);
    const Candidate drift = whole ? driftOf(part, ofDrift) : Candidate();
    trend.p = std::min({trend.p, step.p, bump.p, drift.p});
    const auto worth = [&](const Candidate& c) { return c.p < alpha_ ? c.criterion : kNever; };
    const double best = std::min({worth(drift), worth(step), worth(bump)});
    if (!std::isfinite(best)) {
      if (whole) trend.scatter = scatter = levelScatter(part);
      trend.segments.push_back(segmentOf(part, first, scatter));
    } else if (best == worth(drift)) {
      trend.kind = Trend::Kind::kDrift;
      trend.scatter = drift.scatter;
      trend.segments.push_back({first, first + part.size(), lineThrough(part, drift.scatter).level,
                                std::sqrt(1.0 / sumsOf(part, drift.scatter).all().weight)});
    } else {
      trend.kind = Trend::Kind::kSteps;
      const bool single = best == worth(step);
      const Candidate& found = single ? step : bump;
      if (whole) trend.scatter = found.scatter;
      const auto cut = [&](std::size_t a, std::size_t b) {
        look({part.begin() + a, part.begin() + b}, first + a, found.scatter, trend);
      };
      cut(0, found.at);
      trend.stepP.push_back(found.p);
      if (!single) {
        cut(found.at, found.back);
        trend.stepP.push_back(found.p);
      }
      cut(single ? found.at : found.back, part.size());
    }
  }

 private:
  using Points = std::vector<TrendPoint>;

  static SegmentSums sumsOf(const Points& part, double scatter) {
    return SegmentSums(part, scatter, part.front().value);
  }
  static std::size_t shortest(const Points& part) { return part.size() >= kLongSeries ? 3 : 2; }
  static bool asksLine(const Points& part) { return part.size() >= kFewestForLine && longEnough(part); }
  static bool asksBump(const Points& part) {
    return part.size() >= kFewestForStep && part.size() >= 3 * shortest(part);
  }
  static double levelScatter(const Points& part) {
    return varianceBetween(part, part.size() - 1.0,
                           [&](double scatter) { return sumsOf(part, scatter).all().chi2(); });
  }
  static TrendSegment segmentOf(const Points& part, std::size_t first, double scatter) {
    const WeightedSums sums = sumsOf(part, scatter).all();
    const double dof = part.size() - 1.0;
    const double scale = dof > 0.0 ? std::max(1.0, sums.chi2() / dof) : 1.0;
    return {first, first + part.size(), sums.level(), std::sqrt(scale / sums.weight)};
  }
  /// Twice the negative logarithm of the likelihood, and half the logarithm of the points twice an unknown.
  static double criterionOf(const Points& part, double scatter, double chi2, double unknowns) {
    double sum = chi2;
    for (const TrendPoint& p : part) sum += std::log(p.std * p.std + scatter);
    return sum + unknowns * std::log(part.size());
  }
  /// The points [i, j) against all others: a step where they are the last ones.
  static Contrast contrast(const SegmentSums& sums, std::size_t i, std::size_t j) {
    const WeightedSums these = sums.of(i, j), others = sums.around(i, j);
    return {these.level() - others.level(), 1.0 / these.weight + 1.0 / others.weight,
            these.chi2() + others.chi2()};
  }

  /// The place where the hypothesis stands out most, with the scatter about it: in turns until neither moves.
  /// @param places calls its argument with each (at, back).
  template <class Places>
  Candidate bestPlace(const Points& part, double families, double unknowns, const Places& places) const {
    Candidate best;
    const double dof = part.size() - 2.0;
    best.scatter = allStated(part) ? 0.0 : levelScatter(part);
    constexpr int kTurns = 8;
    double count = 0.0;
    for (int turn = 0; turn < kTurns; ++turn) {
      const SegmentSums sums = sumsOf(part, best.scatter);
      double largest = -1.0;
      std::size_t at = 0, back = 0;
      count = 0.0;
      places([&](std::size_t i, std::size_t j) {
        ++count;
        const Contrast c = contrast(sums, i, j);
        const double squaredT = c.squared() / std::max(1.0, c.chi2 / dof);
        if (!(squaredT > largest)) return;
        largest = squaredT;
        at = i;
        back = j;
      });
      if (!(largest > 0.0)) return best;  // nothing moved, or there is no place
      if (turn > 0 && at == best.at && back == best.back) break;
      best.at = at;
      best.back = back;
      best.scatter = varianceBetween(
          part, dof, [&](double scatter) { return contrast(sumsOf(part, scatter), at, back).chi2; });
    }
    const Contrast c = contrast(sumsOf(part, best.scatter), best.at, best.back);
    best.p = std::min(1.0, families * count * plainP(c, dof));
    best.criterion = criterionOf(part, best.scatter, c.chi2, unknowns);
    return best;
  }

  Candidate bestStep(const Points& part, double families) const {
    if (part.size() < kFewestForStep) return {};
    const std::size_t end = part.size(), least = shortest(part);
    constexpr double kUnknowns = 3.0;  // two levels and the place
    return bestPlace(part, families, kUnknowns, [&](const auto& visit) {
      for (std::size_t k = least; k + least <= end; ++k) visit(k, end);
    });
  }

  /// Two steps of which the second takes the first back: neither of them alone may show.
  Candidate bestBump(const Points& part, double families) const {
    if (!asksBump(part)) return {};
    const std::size_t end = part.size(), least = shortest(part);
    constexpr double kUnknowns = 4.0;  // two levels and two places
    return bestPlace(part, families, kUnknowns, [&](const auto& visit) {
      for (std::size_t i = least; i + 2 * least <= end; ++i)
        for (std::size_t j = i + least; j + least <= end; ++j) visit(i, j);
    });
  }

  Candidate driftOf(const Points& part, double families) const {
    Candidate drift;
    if (!asksLine(part)) return drift;
    const double dof = part.size() - 2.0;
    drift.scatter =
        varianceBetween(part, dof, [&](double scatter) { return lineThrough(part, scatter).chi2; });
    const TrendLine line = lineThrough(part, drift.scatter);
    if (!(line.variance > 0.0)) return drift;
    double p = plainP(line, dof);
    if (allStated(part))
      p = std::min(p, moderatedP(line, std::max(1.0, lineThrough(part, 0.0).chi2 / dof), dof, usual_));
    drift.p = std::min(1.0, families * p);
    drift.criterion = criterionOf(part, drift.scatter, line.chi2, 2.0);
    return drift;
  }

  const Points& points_;
  double alpha_, usual_;
};

}  // namespace

Trend trendOf(const std::vector<TrendPoint>& series, double alpha, double usual) {
  Trend trend;
  if (series.empty()) return trend;
  const std::vector<TrendPoint> points = knownNoBetterThanUsual(series);
  TrendSearch(points, alpha, usual).look(points, 0, 0.0, trend);
  trend.scatter =
      std::sqrt(trend.scatter <= leastVariance(points) && !allStated(points) ? 0.0 : trend.scatter);
  trend.start = trend.end = trend.segments.front().level;
  if (!longEnough(points)) return trend;
  const double dof = points.size() - 2.0;
  const double scatter = varianceBetween(points, dof, [&](double s) { return lineThrough(points, s).chi2; });
  const TrendLine line = lineThrough(points, scatter);
  trend.slope = line.size;
  trend.slopeStd = std::sqrt(line.variance * (dof > 0.0 ? std::max(1.0, line.chi2 / dof) : 1.0));
  trend.start = line.level + line.size * (points.front().day - line.middle);
  trend.end = line.level + line.size * (points.back().day - line.middle);
  return trend;
}

double residualVariance(const std::vector<TrendPoint>& series) {
  if (series.size() < kFewestForLine || !allStated(series) || !longEnough(series)) return std::nan("");
  const std::vector<TrendPoint> points = knownNoBetterThanUsual(series);
  return lineThrough(points, 0.0).chi2 / (points.size() - 2.0);
}

}  // namespace mm
