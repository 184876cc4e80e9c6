#include "uncertainty/drift_figures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>

#include "base/grid_values.h"
#include "base/random.h"
#include "base/range.h"

namespace mm {
namespace {

constexpr double kOneHour = 1.0;        // h
constexpr double kMinute = 1.0 / 60.0;  // h: readings that are due after an hour may come so early
constexpr std::size_t kFewestNear = 5, kMostNear = 50, kNearShare = 8;
constexpr double kMostValues = 2e6;  // drawn for one curve
constexpr int kFewestPairs = 30, kMostPairs = 400;

using FigureValues = std::array<double, 5>;  // in the order of eachDriftFigure
constexpr std::size_t kRanges = 2;           // the first; displacements follow

std::array<DriftFigure*, 5> eachDriftFigure(DriftFigures& f) {
  return {&f.range, &f.hour, &f.firstHour, &f.heated, &f.recovery};
}

double rangeOfAll(const std::vector<double>& values) {
  Range range;
  for (const double v : values) range.add(v);
  return range.any() ? range.size() : kNotMeasured;
}

/// The largest range within any hour: of each window the extremes, kept in order as it slides.
double rangeWithinAnHour(const std::vector<double>& hours, const std::vector<double>& values) {
  if (hours.back() - hours.front() < kOneHour - kMinute) return kNotMeasured;
  std::deque<std::size_t> least, most;
  double largest = 0.0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    while (!least.empty() && values[least.back()] >= values[i]) least.pop_back();
    while (!most.empty() && values[most.back()] <= values[i]) most.pop_back();
    least.push_back(i);
    most.push_back(i);
    const double from = hours[i] - kOneHour - 1e-9;
    while (hours[least.front()] < from) least.pop_front();
    while (hours[most.front()] < from) most.pop_front();
    largest = std::max(largest, values[most.front()] - values[least.front()]);
  }
  return largest;
}

/// Linear between the readings, of which there are two or more; constant beyond the ends.
double valueAt(const std::vector<double>& hours, const std::vector<double>& values, double hour) {
  const auto [before, share] = placeAmong(hours, hour);
  return (1.0 - share) * values[before] + share * values[before + 1];
}

FigureValues figuresOfDrift(const std::vector<double>& hours, const std::vector<double>& values,
                            const HeatedTime& heated) {
  const double zero = valueAt(hours, values, heated.from), end = valueAt(hours, values, heated.to);
  const bool anHour = hours.back() - heated.from >= kOneHour - kMinute;
  return {rangeOfAll(values), rangeWithinAnHour(hours, values),
          anHour ? valueAt(hours, values, heated.from + kOneHour) - zero : kNotMeasured,
          heated.to > heated.from ? end - zero : kNotMeasured,
          hours.back() > heated.to ? values.back() - end : kNotMeasured};
}

/// Value of a straight line through the readings from `first` to before `end`, at `hour`.
double lineThrough(const DriftCurve& c, std::size_t first, std::size_t end, double hour) {
  const double count = end - first;
  double t = 0.0, v = 0.0, tt = 0.0, tv = 0.0;
  for (std::size_t i = first; i < end; ++i) {
    t += c.hours[i] / count;
    v += c.value[i] / count;
  }
  for (std::size_t i = first; i < end; ++i) {
    tt += (c.hours[i] - t) * (c.hours[i] - t);
    tv += (c.hours[i] - t) * (c.value[i] - v);
  }
  return tt > 0.0 ? v + tv / tt * (hour - t) : v;
}

}  // namespace

std::vector<double> smoothed(const DriftCurve& curve) {
  const std::size_t all = curve.value.size();
  const std::size_t near = std::min(all, std::clamp(all / kNearShare, kFewestNear, kMostNear));
  std::vector<double> smooth(all);
  for (std::size_t i = 0; i < all; ++i) {
    const std::size_t first = std::min(i > near / 2 ? i - near / 2 : 0, all - near);
    smooth[i] = lineThrough(curve, first, first + near, curve.hours[i]);
  }
  return smooth;
}

HeatedTime heatedTime(const DriftCurve& curve) {
  const std::vector<double> smooth = smoothed(curve);
  if (smooth.empty()) return {};
  std::size_t most = 0;
  const auto size = [&](std::size_t i) { return std::abs(smooth[i] - smooth.front()); };
  for (std::size_t i = 1; i < smooth.size(); ++i)
    if (size(i) > size(most)) most = i;
  return {curve.hours.front(), curve.hours[most], true};
}

DriftFigures driftFigures(const DriftCurve& whole, const HeatedTime& heated, double noise) {
  DriftFigures figures;
  DriftCurve curve;
  for (std::size_t i = 0; i < std::min(whole.hours.size(), whole.value.size()); ++i) {
    if (!std::isfinite(whole.value[i])) continue;
    curve.hours.push_back(whole.hours[i]);
    curve.value.push_back(whole.value[i]);
  }
  const std::vector<double>& hours = curve.hours;
  if (hours.size() < 2) return figures;
  const auto each = eachDriftFigure(figures);
  const FigureValues measured = figuresOfDrift(hours, curve.value, heated);
  for (std::size_t k = 0; k < each.size(); ++k) each[k]->value = measured[k];
  if (!(noise > 0.0)) return figures;
  const std::vector<double> smooth = smoothed(curve);
  const FigureValues without = figuresOfDrift(hours, smooth, heated);
  const int pairs = static_cast<int>(
      std::clamp(0.5 * kMostValues / smooth.size(), double{kFewestPairs}, double{kMostPairs}));
  Random random(1, "drift figures");
  FigureValues sum{}, squares{};
  std::vector<double> plus(smooth.size()), minus(smooth.size());
  for (int pair = 0; pair < pairs; ++pair) {
    for (std::size_t i = 0; i < smooth.size(); ++i) {
      const double drawn = noise * random.normal();
      plus[i] = smooth[i] + drawn;
      minus[i] = smooth[i] - drawn;  // with it a difference of two readings gets exactly nothing
    }
    for (const auto* values : {&plus, &minus}) {
      const HeatedTime time = heated.chosen ? heatedTime({hours, *values}) : heated;
      const FigureValues noisy = figuresOfDrift(hours, *values, time);
      for (std::size_t k = 0; k < noisy.size(); ++k) {
        sum[k] += noisy[k] - without[k];
        squares[k] += (noisy[k] - without[k]) * (noisy[k] - without[k]);
      }
    }
  }
  const double draws = 2.0 * pairs;
  for (std::size_t k = 0; k < each.size(); ++k) {
    const double mean = sum[k] / draws;
    each[k]->noise = mean;
    const double told = k < kRanges ? mean : 0.0;  // beside a range; of a displacement it is uncertainty
    each[k]->std = std::sqrt(std::max(0.0, squares[k] / draws - told * told));
  }
  return figures;
}

}  // namespace mm
