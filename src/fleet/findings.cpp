#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "base/format.h"
#include "base/median.h"
#include "base/quantity_words.h"
#include "fleet/fleet.h"
#include "fleet/recurrence.h"

namespace mm {
namespace {

constexpr double kNoSpan = 1e-9;  // d^2: sessions of one moment have no trend

constexpr std::size_t kFewestForTrend = 5, kFewestSisters = 4;

std::string dayText(const std::string& date) { return date.substr(0, 10); }

/// Three significant digits, and the unit.
std::string measure(double value, const std::string& unit) { return format("%.3g %s", value, unit.c_str()); }

/// Noise is kept as its logarithm; people are told kelvin.
double spokenValue(const FleetSeries& s, double value) { return s.unit == "ln K" ? std::exp(value) : value; }
std::string spokenUnit(const FleetSeries& s) { return s.unit == "ln K" ? "K" : s.unit; }

Finding findingOf(const std::string& kind, const FleetSeries& s, double before, double after, double p) {
  Finding f{s.kind == SeriesKind::kSensor ? "sensor" : kind, s.machine, s.quantity, spokenUnit(s)};
  f.before = spokenValue(s, before);
  f.after = spokenValue(s, after);
  f.p = p;
  return f;
}

/// By how much, with its expanded uncertainty; of a ratio of noise nothing.
std::string byHowMuch(const Finding& f) {
  return std::isfinite(f.std) ? " by " + withFactor(expanded(f.after - f.before, f.std, f.unit)) + "," : "";
}

std::string chanceOf(const Finding& f) {
  constexpr double kSmallest = 1e-99;
  return f.p < kSmallest ? " (p < 1e-99)" : format(" (p = %.1g)", f.p);
}

std::string fromTo(const Finding& f) { return measure(f.before, f.unit) + " to " + measure(f.after, f.unit); }

/// Whether a sensor could tell this change at all: less than its resolution is rounding.
bool resolved(const FleetSeries& s, double change) { return !(std::abs(change) <= s.resolution); }

/// Of each quantity the variance of residuals in units of the stated one: the median over its machines, or
/// over everything where that is larger.
std::map<std::string, double> usualVariances(const Fleet& fleet) {
  std::map<std::string, std::vector<double>> known;
  std::vector<double> all;
  for (const FleetSeries& s : fleet.series) {
    std::vector<double>& ofQuantity = known[s.quantity];
    const double variance = s.points.size() >= kFewestForTrend ? residualVariance(s.points) : std::nan("");
    if (!std::isfinite(variance)) continue;
    ofQuantity.push_back(variance);
    all.push_back(variance);
  }
  std::map<std::string, double> usual;
  for (const auto& [quantity, variances] : known)
    usual[quantity] = variances.empty() ? 1.0 : std::max(median(variances), median(all));
  return usual;
}

/// Two steps of which the second takes the first back, by half of it at least.
bool backAgain(const TrendSegment& first, const TrendSegment& between, const TrendSegment& last) {
  const double away = std::abs(between.level - first.level);
  return std::abs(last.level - first.level) < 0.5 * away && std::abs(between.level) < std::abs(first.level);
}

void addSteps(const FleetSeries& s, std::vector<Finding>& findings) {
  const std::vector<TrendSegment>& parts = s.trend.segments;
  for (std::size_t i = 0; i + 1 < parts.size(); ++i) {
    if (!resolved(s, parts[i + 1].level - parts[i].level)) continue;
    Finding f = findingOf("changed", s, parts[i].level, parts[i + 1].level, s.trend.stepP[i]);
    f.change = true;
    if (s.unit != "ln K") f.std = std::hypot(parts[i].std, parts[i + 1].std);
    f.date = s.dates[parts[i + 1].first];
    f.inWords = "Machine " + s.machine + ": " + s.quantity + " changed" + byHowMuch(f) + " from " +
                fromTo(f) + " between " + dayText(s.dates[parts[i].end - 1]) + " and " + dayText(f.date) +
                chanceOf(f) + ".";
    if (i > 0 && s.kind == SeriesKind::kParameter && backAgain(parts[i - 1], parts[i], parts[i + 1])) {
      f.kind = "came_back";
      f.inWords = "Machine " + s.machine + ": " + s.quantity +
                  " came back: " + measure(parts[i - 1].level, s.unit) + ", then " + fromTo(f) +
                  " again from " + dayText(f.date) + chanceOf(f) + ".";
    }
    findings.push_back(f);
  }
}

/// Series of one quantity, a machine each.
std::map<std::string, std::vector<const FleetSeries*>> byQuantity(const Fleet& fleet) {
  std::map<std::string, std::vector<const FleetSeries*>> groups;
  for (const FleetSeries& s : fleet.series) groups[s.quantity].push_back(&s);
  return groups;
}

/// A machine's own scatter, found from few sessions, may be small by chance: none is taken to be known better
/// than its sisters would be with as many sessions. @param amount of information that each has: its
/// uncertainty falls with its root.
void knownNoBetterThanSisters(std::vector<Sister>& sisters, const std::vector<double>& amount) {
  std::vector<double> ofOne;
  for (std::size_t i = 0; i < sisters.size(); ++i) ofOne.push_back(sisters[i].std * std::sqrt(amount[i]));
  const double usual = median(ofOne);
  for (std::size_t i = 0; i < sisters.size(); ++i)
    sisters[i].std = std::max(sisters[i].std, usual / std::sqrt(amount[i]));
}

/// Sum of squares of the days about their mean: what a slope is known by.
double leverOf(const FleetSeries& s) {
  double mean = 0.0, sum = 0.0;
  for (const TrendPoint& p : s.points) mean += p.day / s.points.size();
  for (const TrendPoint& p : s.points) sum += (p.day - mean) * (p.day - mean);
  return std::max(sum, kNoSpan);
}

void compareLevels(const std::vector<const FleetSeries*>& group, double alpha,
                   std::vector<Finding>& findings) {
  std::vector<Sister> sisters;
  std::vector<double> sessions;
  for (const FleetSeries* s : group) {
    const TrendSegment& last = s->trend.segments.back();
    sisters.push_back(presentOf(*s));
    sessions.push_back(last.end - last.first);
  }
  knownNoBetterThanSisters(sisters, sessions);
  const Sisterhood all = sistersOf(sisters);
  for (std::size_t i = 0; i < group.size(); ++i) {
    const FleetSeries& s = *group[i];
    if (!(all.p[i] < alpha) || !resolved(s, sisters[i].value - all.centre)) continue;
    Finding f = findingOf("apart", s, all.centre, sisters[i].value, all.p[i]);
    f.date = s.dates.back();
    f.inWords =
        "Machine " + s.machine + ": " + s.quantity + " is " + measure(f.after, f.unit) + ", its sisters' " +
        measure(f.before, f.unit) +
        (s.unit == "ln K" ? "" : format(" ± %.2g %s (between machines)", all.spread, f.unit.c_str())) + ".";
    findings.push_back(f);
  }
}

void compareSlopes(const std::vector<const FleetSeries*>& group, double alpha,
                   std::vector<Finding>& findings) {
  std::vector<Sister> sisters;
  std::vector<const FleetSeries*> known;
  std::vector<double> levers;
  for (const FleetSeries* s : group)
    if (s->points.size() >= kFewestForTrend && s->trend.slopeStd > 0.0) {
      known.push_back(s);
      sisters.push_back({s->machine, s->trend.slope, s->trend.slopeStd});
      levers.push_back(leverOf(*s));
    }
  knownNoBetterThanSisters(sisters, levers);
  const Sisterhood all = sistersOf(sisters);
  constexpr double kYear = 365.25;
  for (std::size_t i = 0; i < known.size(); ++i) {
    const FleetSeries& s = *known[i];
    const double reach = s.points.back().day - s.points.front().day;
    if (!(all.p[i] < alpha) || !resolved(s, reach * (sisters[i].value - all.centre))) continue;
    Finding f = findingOf("drifts_apart", s, kYear * all.centre, kYear * sisters[i].value, all.p[i]);
    if (s.unit == "ln K") {  // a rate of a logarithm stays one
      f.before = kYear * all.centre;
      f.after = kYear * sisters[i].value;
    }
    f.unit = s.unit + " a year";
    f.date = s.dates.back();
    f.inWords = "Machine " + s.machine + ": " + s.quantity + " goes by " + measure(f.after, f.unit) +
                ", its sisters' by " + measure(f.before, f.unit) + ".";
    findings.push_back(f);
  }
}

/// What the diagnoses of each machine found, in the order of time; of effects that were found at all.
struct FoundSeries {
  std::string machine, effect;
  std::vector<bool> found;
  std::vector<std::string> dates;
};

std::vector<FoundSeries> foundSeries(const Fleet& fleet) {
  std::map<std::string, std::vector<const FleetRecord*>> ofMachine;
  for (const FleetRecord& r : fleet.records)
    if (r.result.asked) ofMachine[r.machine].push_back(&r);
  std::vector<FoundSeries> all;
  for (const auto& [machine, records] : ofMachine) {
    std::set<std::string> effects;
    for (const FleetRecord* r : records) effects.insert(r->result.found.begin(), r->result.found.end());
    for (const std::string& effect : effects) {
      FoundSeries s{machine, effect, {}, {}};
      for (const FleetRecord* r : records) {
        const auto& found = r->result.found;
        s.found.push_back(std::find(found.begin(), found.end(), effect) != found.end());
        s.dates.push_back(r->date);
      }
      all.push_back(std::move(s));
    }
  }
  return all;
}

bool isOffset(const Finding& f) { return f.kind == "sensor" && f.quantity.rfind("offset of ", 0) == 0; }

/// Of one cause one finding. A step is also a slope and a difference from the sisters, and one sensor that is
/// wrong moves the offsets of all others of its machine.
bool follows(const Finding& f, const Finding& cause) {
  if (&f == &cause || f.machine != cause.machine) return false;
  if (f.quantity == cause.quantity) {
    const bool step = cause.kind == "changed" || cause.kind == "came_back";
    if (f.kind == "apart") return step || cause.kind == "drifts";
    if (f.kind == "drifts_apart") return step;
    // a change tells more than what they are now
    return f.kind == "sensor" && cause.kind == "sensor" && cause.change && !f.change;
  }
  if (!isOffset(f) || !isOffset(cause)) return false;
  if (f.change != cause.change) return cause.change;
  return f.date == cause.date && std::abs(f.after - f.before) < std::abs(cause.after - cause.before);
}

/// Whether a sensor that moved by some of its steps in every session is still in the last two, at one value.
/// A coarse sensor in a quiet room never moved so, and a session in which nothing got warmer is but one.
/// @param all of one sensor, in the order of time.
bool isStuck(const std::vector<const SensorHealth*>& all) {
  constexpr int kValues = 10;                                 // that say anything
  constexpr std::size_t kFewestStill = 2, kFewestBefore = 2;  // sessions
  constexpr double kSteps = 5.0;                              // by which it moved, at least
  const auto still = [&](const SensorHealth& h) {
    return h.values >= kValues && h.span == 0.0 && h.mean == all.back()->mean;
  };
  std::size_t run = 0;
  while (run < all.size() && still(*all[all.size() - 1 - run])) ++run;
  const std::size_t before = all.size() - run;
  if (run < kFewestStill || before < kFewestBefore) return false;
  double step = std::numeric_limits<double>::infinity();
  for (const SensorHealth* h : all)
    if (std::isfinite(h->step)) step = std::min(step, h->step);
  for (std::size_t i = 0; i < before; ++i)
    if (!(all[i]->span >= kSteps * step)) return false;
  return true;
}

}  // namespace

Sister presentOf(const FleetSeries& s) {
  if (s.trend.kind == Trend::Kind::kDrift && s.points.size() >= kFewestForTrend) {
    const double reach = s.points.back().day - s.points.front().day;
    return {s.machine, s.trend.end, std::hypot(s.trend.segments.back().std, 0.5 * reach * s.trend.slopeStd)};
  }
  return {s.machine, s.trend.segments.back().level, s.trend.segments.back().std};
}

void condense(Fleet& fleet) {
  std::vector<Finding> kept;
  for (const Finding& f : fleet.findings)
    if (std::none_of(fleet.findings.begin(), fleet.findings.end(),
                     [&](const Finding& cause) { return follows(f, cause); }))
      kept.push_back(f);
  fleet.findings = std::move(kept);
}

void findTrends(Fleet& fleet, double alpha) {
  const std::map<std::string, double> usual = usualVariances(fleet);
  for (FleetSeries& s : fleet.series) {
    s.trend = trendOf(s.points, s.points.size() >= kFewestForTrend ? alpha : 0.0, usual.at(s.quantity));
    if (s.trend.kind == Trend::Kind::kSteps) addSteps(s, fleet.findings);
    if (s.trend.kind != Trend::Kind::kDrift || !resolved(s, s.trend.end - s.trend.start)) continue;
    Finding f = findingOf("drifts", s, s.trend.start, s.trend.end, s.trend.p);
    f.date = s.dates.back();
    if (s.unit != "ln K") f.std = (s.points.back().day - s.points.front().day) * s.trend.slopeStd;
    f.inWords = "Machine " + s.machine + ": " + s.quantity + " drifts" +
                (std::isfinite(f.std) ? byHowMuch(f) : ",") + " from " + fromTo(f) + " between " +
                dayText(s.dates.front()) + " and " + dayText(s.dates.back()) + chanceOf(f) + ".";
    fleet.findings.push_back(f);
  }
}

double sisterQuestions(const Fleet& fleet) {
  double count = 0.0;
  for (const auto& [quantity, group] : byQuantity(fleet)) {
    if (group.size() < kFewestSisters) continue;
    count += group.size();
    for (const FleetSeries* s : group)
      if (s->points.size() >= kFewestForTrend) ++count;
  }
  return count;
}

void findSisters(Fleet& fleet, double alpha) {
  for (const auto& [quantity, group] : byQuantity(fleet)) {
    compareLevels(group, alpha, fleet.findings);
    compareSlopes(group, alpha, fleet.findings);
  }
}

double recurrenceQuestions(const Fleet& fleet) { return foundSeries(fleet).size(); }

void findRecurrences(Fleet& fleet, double alpha) {
  for (const FoundSeries& s : foundSeries(fleet)) {
    const Recurrence r = recurrenceOf(s.found);
    if (!(r.logOdds > -std::log(alpha))) continue;
    Finding f{"came_back", s.machine, s.effect};
    f.date = s.dates[r.back];
    f.p = std::exp(-r.logOdds);
    f.inWords = "Machine " + s.machine + ": " + s.effect + " came back: present until " +
                dayText(s.dates[r.gone - 1]) + ", gone from " + dayText(s.dates[r.gone]) +
                ", present again from " + dayText(f.date) + ".";
    fleet.findings.push_back(f);
  }
}

void findBadSensors(Fleet& fleet) {
  constexpr double kMostAside = 0.1;  // share of values that cannot be right
  std::map<std::string, const FleetRecord*> last;
  std::map<std::string, std::map<std::string, std::vector<const SensorHealth*>>>
      sensors;  // of a machine, ever
  for (const FleetRecord& r : fleet.records) {
    last[r.machine] = &r;  // by date
    for (const SensorHealth& h : r.result.sensors) sensors[r.machine][h.sensor].push_back(&h);
  }
  for (const auto& [machine, record] : last) {
    const auto add = [&, name = machine, at = record](const std::string& sensor, const std::string& what) {
      Finding f{"sensor", name, "sensor " + sensor};
      f.date = at->date;
      f.p = 0.0;  // no chance about it
      f.inWords = "Machine " + name + ": sensor " + sensor + " " + what + " in the session of " +
                  dayText(at->date) + ".";
      fleet.findings.push_back(f);
    };
    std::map<std::string, std::vector<const SensorHealth*>> lost = sensors[machine];
    for (const SensorHealth& h : record->result.sensors) {
      lost.erase(h.sensor);
      if (isStuck(sensors[machine][h.sensor]))
        add(h.sensor, "is stuck: all " + std::to_string(h.values) + " values are " + measure(h.mean, "degC"));
      else if (h.setAside > kMostAside * (h.setAside + h.values))
        add(h.sensor, "gave " + std::to_string(h.setAside) + " of " + std::to_string(h.setAside + h.values) +
                          " values that cannot be right");
    }
    for (const auto& [sensor, history] : lost) add(sensor, "has disappeared");
  }
}

}  // namespace mm
