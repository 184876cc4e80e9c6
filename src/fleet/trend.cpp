#include "fleet/trend.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/median.h"
#include "base/tiny.h"
#include "fleet/robust_numbers.h"

namespace mm {
namespace {

constexpr double kNoResidual = 1e-12;  // of the variance: a line through all points has a logarithm, too
constexpr double kAnyWeight = 1e-9, kLeastWeight = 1e-12;  // of the largest value; in the unit of the values

constexpr double kNormalMedian = 0.6744897501960817;  // of the size of a normal number
constexpr std::size_t kFewest = 5;                    // points that say anything about a trend
constexpr std::size_t kLongSeries =
    8;  // from here on a segment has three points: two bad sessions are no change

/// Running sums of weights, weighted values and squares: level and chi2 of any segment in constant time.
class Sums {
 public:
  Sums(const std::vector<TrendPoint>& points, double scatter, double origin) {
    w_.push_back(0.0);
    wy_.push_back(0.0);
    wyy_.push_back(0.0);
    for (const TrendPoint& p : points) {
      const double weight = 1.0 / (p.std * p.std + scatter * scatter), y = p.value - origin;
      w_.push_back(w_.back() + weight);
      wy_.push_back(wy_.back() + weight * y);
      wyy_.push_back(wyy_.back() + weight * y * y);
    }
    origin_ = origin;
  }
  double weight(std::size_t a, std::size_t b) const { return w_[b] - w_[a]; }
  double level(std::size_t a, std::size_t b) const { return origin_ + (wy_[b] - wy_[a]) / weight(a, b); }
  double chi2(std::size_t a, std::size_t b) const {
    const double sum = wy_[b] - wy_[a];
    return std::max(0.0, wyy_[b] - wyy_[a] - sum * sum / weight(a, b));
  }
  /// The same of [a, i) and [j, b) with one level.
  double weightAround(std::size_t a, std::size_t i, std::size_t j, std::size_t b) const {
    return weight(a, b) - weight(i, j);
  }
  double levelAround(std::size_t a, std::size_t i, std::size_t j, std::size_t b) const {
    return origin_ + (wy_[b] - wy_[a] - wy_[j] + wy_[i]) / weightAround(a, i, j, b);
  }
  double chi2Around(std::size_t a, std::size_t i, std::size_t j, std::size_t b) const {
    const double sum = wy_[b] - wy_[a] - wy_[j] + wy_[i];
    return std::max(0.0, wyy_[b] - wyy_[a] - wyy_[j] + wyy_[i] - sum * sum / weightAround(a, i, j, b));
  }

 private:
  std::vector<double> w_, wy_, wyy_;
  double origin_ = 0.0;
};

/// A straight line through the points [a, b).
struct Line {
  double slope = 0.0, std = 0.0, middle = 0.0, level = 0.0, chi2 = 0.0;
};

Line lineThrough(const std::vector<TrendPoint>& points, double scatter, std::size_t a, std::size_t b) {
  double w = 0, wx = 0, wy = 0;
  const auto weightOf = [&](const TrendPoint& p) { return 1.0 / (p.std * p.std + scatter * scatter); };
  for (std::size_t i = a; i < b; ++i) {
    const double weight = weightOf(points[i]);
    w += weight;
    wx += weight * points[i].day;
    wy += weight * points[i].value;
  }
  Line line;
  line.middle = wx / w;
  line.level = wy / w;
  double xx = 0, xy = 0;
  for (std::size_t i = a; i < b; ++i) {
    const double weight = weightOf(points[i]), x = points[i].day - line.middle;
    xx += weight * x * x;
    xy += weight * x * (points[i].value - line.level);
  }
  if (!(xx > 0.0)) return line;  // all on one day
  line.slope = xy / xx;
  for (std::size_t i = a; i < b; ++i) {
    const double r = points[i].value - line.level - line.slope * (points[i].day - line.middle);
    line.chi2 += weightOf(points[i]) * r * r;
  }
  line.std = 1.0 / std::sqrt(xx);
  return line;
}

/// Variance of the residuals over the stated one; never less than stated.
double scaleOf(double chi2, double dof) { return std::max(1.0, chi2 / dof); }

struct Candidate {
  double p = 1.0, bic = std::numeric_limits<double>::infinity();
  std::size_t at = 0, back = 0;  // of a step: first point after it; of one that is taken back: after that
};

class Search {
 public:
  Search(const std::vector<TrendPoint>& points, double scatter, double alpha)
      : points_(points), scatter_(scatter), alpha_(alpha), sums_(points, scatter, points.front().value) {}

  void look(std::size_t a, std::size_t b, Trend& trend) const {
    const Candidate step = bestStep(a, b), bump = bestBump(a, b), drift = driftOf(a, b);
    trend.p = std::min({trend.p, step.p, bump.p, drift.p});
    const bool whole = a == 0 && b == points_.size();
    const auto worth = [&](const Candidate& c) {
      return c.p < alpha_ ? c.bic : std::numeric_limits<double>::infinity();
    };
    const double ofDrift = whole ? worth(drift) : std::numeric_limits<double>::infinity();
    const double best = std::min({ofDrift, worth(step), worth(bump)});
    if (!std::isfinite(best)) {
      trend.segments.push_back({a, b, sums_.level(a, b), stdOf(a, b)});
    } else if (best == ofDrift) {
      trend.kind = Trend::Kind::kDrift;
      trend.segments.push_back({a, b, sums_.level(a, b), stdOf(a, b)});
    } else {
      trend.kind = Trend::Kind::kSteps;
      const bool single = best == worth(step);
      const Candidate& found = single ? step : bump;
      look(a, found.at, trend);
      trend.stepP.push_back(found.p);
      if (!single) {
        look(found.at, found.back, trend);
        trend.stepP.push_back(found.p);
      }
      look(single ? found.at : found.back, b, trend);
    }
  }

 private:
  double stdOf(std::size_t a, std::size_t b) const {
    const double dof = static_cast<double>(b - a) - 1.0;
    const double scale = dof > 0.0 ? scaleOf(sums_.chi2(a, b), dof) : 1.0;
    return std::sqrt(scale / sums_.weight(a, b));
  }
  static std::size_t shortest(std::size_t count) { return count >= kLongSeries ? 3 : 2; }

  static constexpr double kFamilies = 3.0;  // steps, steps that are taken back, drifts share the chance

  static double bicOf(double chi2, std::size_t count, double unknowns) {
    const auto n = static_cast<double>(count);
    return n * std::log(std::max(chi2, kNoResidual * n) / n) + unknowns * std::log(n);
  }

  Candidate bestStep(std::size_t a, std::size_t b) const {
    const std::size_t count = b - a, least = shortest(count);
    Candidate best;
    if (count < kFewest) return best;
    const double dof = static_cast<double>(count) - 2.0;
    double largest = -1.0;
    for (std::size_t k = a + least; k + least <= b; ++k) {
      const double chi2 = sums_.chi2(a, k) + sums_.chi2(k, b);
      const double variance = scaleOf(chi2, dof) * (1.0 / sums_.weight(a, k) + 1.0 / sums_.weight(k, b));
      const double t = std::abs(sums_.level(k, b) - sums_.level(a, k)) / std::sqrt(variance);
      if (t <= largest) continue;
      largest = t;
      best.at = k;
      best.bic = bicOf(chi2, count, 3.0);  // two levels and the place
    }
    const double places = static_cast<double>(count) - 2.0 * static_cast<double>(least) + 1.0;
    if (largest > 0.0) best.p = std::min(1.0, kFamilies * places * twoSidedT(largest, dof));
    return best;
  }

  /// Two steps of which the second takes the first back: neither of them alone may show.
  Candidate bestBump(std::size_t a, std::size_t b) const {
    const std::size_t count = b - a, least = shortest(count);
    Candidate best;
    if (count < 3 * least) return best;
    const double dof = static_cast<double>(count) - 2.0;
    double largest = -1.0, pairs = 0.0;
    for (std::size_t i = a + least; i + 2 * least <= b; ++i)
      for (std::size_t j = i + least; j + least <= b; ++j) {
        ++pairs;
        const double chi2 = sums_.chi2(i, j) + sums_.chi2Around(a, i, j, b);
        const double variance =
            scaleOf(chi2, dof) * (1.0 / sums_.weight(i, j) + 1.0 / sums_.weightAround(a, i, j, b));
        const double t = std::abs(sums_.level(i, j) - sums_.levelAround(a, i, j, b)) / std::sqrt(variance);
        if (t <= largest) continue;
        largest = t;
        best.at = i;
        best.back = j;
        best.bic = bicOf(chi2, count, 4.0);  // two levels and two places
      }
    if (largest > 0.0) best.p = std::min(1.0, kFamilies * pairs * twoSidedT(largest, dof));
    return best;
  }

  Candidate driftOf(std::size_t a, std::size_t b) const {
    const std::size_t count = b - a;
    Candidate drift;
    if (count < kFewest) return drift;
    const Line line = lineThrough(points_, scatter_, a, b);
    if (!(line.std > 0.0)) return drift;
    const double dof = static_cast<double>(count) - 2.0;
    const double t = line.slope / (line.std * std::sqrt(scaleOf(line.chi2, dof)));
    drift.p = std::min(1.0, kFamilies * twoSidedT(t, dof));
    drift.bic = bicOf(line.chi2, count, 2.0);
    return drift;
  }

  const std::vector<TrendPoint>& points_;
  double scatter_, alpha_;
  Sums sums_;
};

/// From differences of neighbours: of white scatter each has twice the variance of a point.
double scatterOf(const std::vector<TrendPoint>& points) {
  std::vector<double> difference, variance;
  for (std::size_t i = 1; i < points.size(); ++i) {
    difference.push_back((points[i].value - points[i - 1].value) / std::sqrt(2.0));
    variance.push_back(0.5 * (points[i].std * points[i].std + points[i - 1].std * points[i - 1].std));
  }
  return excessScatter(difference, variance);
}

}  // namespace

double excessScatter(const std::vector<double>& value, const std::vector<double>& variance) {
  if (value.empty()) return 0.0;
  const auto tooLarge = [&](double scatter) {
    std::vector<double> size;
    for (std::size_t i = 0; i < value.size(); ++i)
      size.push_back(std::abs(value[i]) / std::sqrt(variance[i] + scatter * scatter + kTiny));
    return median(std::move(size)) > kNormalMedian;
  };
  if (!tooLarge(0.0)) return 0.0;
  double low = 0.0, high = 0.0;
  for (const double v : value) high = std::max(high, 2.0 * std::abs(v));
  constexpr int kHalvings = 60;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (low + high);
    (tooLarge(middle) ? low : high) = middle;
  }
  return high;
}

Trend trendOf(const std::vector<TrendPoint>& points, double alpha) {
  Trend trend;
  if (points.empty()) return trend;
  trend.scatter = scatterOf(points);
  double largest = 0.0, stated = std::numeric_limits<double>::infinity();
  for (const TrendPoint& p : points) {
    largest = std::max(largest, std::abs(p.value));
    stated = std::min(stated, p.std);
  }
  // values that are all equal, of no stated uncertainty: any weight will do
  const double weighing =
      stated > 0.0 || trend.scatter > 0.0 ? trend.scatter : std::max(kAnyWeight * largest, kLeastWeight);
  Search(points, weighing, alpha).look(0, points.size(), trend);
  const Line line = lineThrough(points, weighing, 0, points.size());
  const double dof = static_cast<double>(points.size()) - 2.0;
  trend.slope = line.slope;
  trend.slopeStd = dof > 0.0 ? line.std * std::sqrt(scaleOf(line.chi2, dof)) : 0.0;
  trend.start = line.level + line.slope * (points.front().day - line.middle);
  trend.end = line.level + line.slope * (points.back().day - line.middle);
  return trend;
}

}  // namespace mm
