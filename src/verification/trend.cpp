#include "verification/trend.h"

#include <algorithm>
#include <cmath>

#include "base/median.h"
#include "base/quantity_words.h"
#include "base/text.h"
#include "base/utc_now.h"
#include "effects/effect_words.h"
#include "machine/machine_fit.h"
#include "session/time_stamp.h"
#include "verification/calibration_changes.h"
#include "workflow/recalibration.h"

namespace mm {
namespace {

constexpr double kDay = 86400.0;  // s
constexpr double kMonth = 30.0;   // days

std::vector<const Calibration*> ofOneMachine(const std::vector<Calibration>& all) {
  std::vector<const Calibration*> same;
  if (all.empty()) return same;
  const Machine last(all.back().urdf, all.back().machineName);
  for (const Calibration& c : all)
    if (differenceOf(last, Machine(c.urdf, c.machineName), "").empty()) same.push_back(&c);
  return same;
}

/// Days since 1970 of what was measured: by the session's own clock, else when the calibration was made.
double dayOf(const Calibration& c) { return hasDate(c) ? c.sessionEpoch / kDay : daysOf(c.created); }

/// As time goes; of the calibrations of one session the last that was made: they are not independent.
std::vector<const Calibration*> oneASession(const std::vector<const Calibration*>& all) {
  std::vector<const Calibration*> kept;
  for (auto c = all.begin(); c != all.end(); ++c) {
    const bool again = std::any_of(c + 1, all.end(), [&](const Calibration* later) {
      return !(*c)->sessionHash.empty() && later->sessionHash == (*c)->sessionHash;
    });
    if (!again) kept.push_back(*c);
  }
  std::stable_sort(kept.begin(), kept.end(),
                   [](const Calibration* a, const Calibration* b) { return dayOf(*a) < dayOf(*b); });
  return kept;
}

/// The points that a trend is sought in.
std::vector<const ParameterPoint*> comparablePoints(const ParameterTrend& t) {
  std::vector<const ParameterPoint*> points;
  for (const ParameterPoint& p : t.points)
    if (p.comparable && p.std > 0.0) points.push_back(&p);
  return points;
}

std::vector<TrendPoint> seriesOf(const ParameterTrend& t) {
  std::vector<TrendPoint> points;
  for (const ParameterPoint* p : comparablePoints(t)) points.push_back({p->day, p->value, p->std});
  return points;
}

/// Variance of residuals in units of the stated one: the median over the parameters; 1 where none tells.
double usualVariance(const std::vector<ParameterTrend>& trends) {
  std::vector<double> variances;
  for (const ParameterTrend& t : trends)
    if (const double variance = residualVariance(seriesOf(t)); std::isfinite(variance))
      variances.push_back(variance);
  return variances.empty() ? 1.0 : median(std::move(variances));
}

void say(ParameterTrend& t, const Trend& course) {
  const std::string what = inWords(t.effect) + ", " + t.name;
  if (!std::isfinite(t.slope)) {
    t.inWords = what + ": no trend can be told from " +
                (t.points.size() == 1 ? "one calibration"
                                      : std::to_string(t.points.size()) +
                                            " calibrations; comparable ones of a day or more are needed");
    return;
  }
  const std::string rate = expanded(kMonth * t.slope, kMonth * t.slopeStd, t.unit) + " in 30 days (k = 2)";
  if (!t.significant || course.kind != Trend::Kind::kSteps) {
    t.inWords = what + ": " + (t.significant ? rate : "no significant trend, " + rate);
    return;
  }
  constexpr std::size_t kDate = 10;  // characters of a day
  const std::vector<const ParameterPoint*> points = comparablePoints(t);
  std::vector<std::string> steps;
  for (std::size_t i = 0; i + 1 < course.segments.size(); ++i) {
    const TrendSegment &before = course.segments[i], &after = course.segments[i + 1];
    steps.push_back(
        withFactor(expanded(after.level - before.level, std::hypot(before.std, after.std), t.unit)) +
        " between " + points[before.end - 1]->measured.substr(0, kDate) + " and " +
        points[after.first]->measured.substr(0, kDate));
  }
  t.inWords = what + ": changed by " + joined(steps, ", by ");
}

}  // namespace

double daysOf(const std::string& time) {
  const std::optional<std::int64_t> stamp = parseCalendar(time);
  return stamp ? secondsBetween(0, *stamp) / kDay : std::nan("");
}

bool hasDate(const Calibration& c) {
  constexpr double kEarliest = 1.2e9;  // s; stamps from before 2008 have the made-up date of an import
  return c.sessionEpoch > kEarliest;
}

std::string measuredAt(const Calibration& c) { return hasDate(c) ? utcText(c.sessionEpoch) : c.created; }

std::vector<std::string> refitted(const std::vector<Calibration>& calibrations) {
  const std::vector<const Calibration*> same = ofOneMachine(calibrations), kept = oneASession(same);
  std::vector<std::string> ids;
  for (const Calibration* c : same)
    if (std::find(kept.begin(), kept.end(), c) == kept.end()) ids.push_back(c->id);
  return ids;
}

std::vector<std::string> ofOtherMachines(const std::vector<Calibration>& calibrations) {
  const std::vector<const Calibration*> kept = ofOneMachine(calibrations);
  std::vector<std::string> others;
  for (const Calibration& c : calibrations)
    if (std::find(kept.begin(), kept.end(), &c) == kept.end()) others.push_back(c.id);
  return others;
}

std::vector<ParameterTrend> trendsOf(const std::vector<Calibration>& calibrations) {
  const std::vector<const Calibration*> kept = oneASession(ofOneMachine(calibrations));
  std::vector<ParameterTrend> trends;
  if (kept.empty()) return trends;
  const Calibration& last = *kept.back();
  const double first = dayOf(*kept.front());
  for (auto c = kept.rbegin(); c != kept.rend(); ++c)
    for (const Calibration::Value& v : (*c)->values) {
      if (v.fixed) continue;
      const EffectSpec& effect = (*c)->effects[v.effect];
      auto found = std::find_if(trends.begin(), trends.end(), [&](const ParameterTrend& t) {
        return t.name == v.name && sameEffect(t.effect, effect, (*c)->domain);
      });
      if (found == trends.end()) {
        trends.emplace_back();
        found = trends.end() - 1;
        found->effect = effect;
        found->name = v.name;
        found->unit = v.unit;
      }
      const bool comparable = *c == &last || found->points.empty() || meansTheSame(effect, **c, last);
      const ParameterPoint point{(*c)->id,           (*c)->created,    measuredAt(**c), dayOf(**c) - first,
                                 v.value * v.toUnit, v.std * v.toUnit, comparable};
      found->points.insert(found->points.begin(), point);
    }
  const double alpha = kSignificant / std::max<std::size_t>(1, trends.size());
  const double usual = usualVariance(trends);
  std::vector<Trend> courses;
  for (ParameterTrend& t : trends) {
    const Trend course = courses.emplace_back(trendOf(seriesOf(t), alpha, usual));
    t.slope = course.slope;
    t.slopeStd = course.slopeStd;
    if (std::isfinite(t.slope)) t.pValue = course.p;
    const auto comparable = [](const ParameterPoint& p) { return p.comparable; };
    const auto begin = std::find_if(t.points.begin(), t.points.end(), comparable);
    if (begin == t.points.end()) continue;
    t.change = t.points.back().value - begin->value;
    t.changeStd = std::hypot(t.points.back().std, begin->std);
  }
  std::vector<ParameterTrend*> asked;
  for (ParameterTrend& t : trends)
    if (std::isfinite(t.slope)) asked.push_back(&t);
  correctForMany(asked);
  for (std::size_t i = 0; i < trends.size(); ++i) {
    // Holm accepts more than Bonferroni: what stood out is told then, too
    const double accepted = std::max(alpha, std::nextafter(courses[i].p, 1.0));
    say(trends[i], trends[i].significant ? trendOf(seriesOf(trends[i]), accepted, usual) : courses[i]);
  }
  return trends;
}

}  // namespace mm
