#include "session/gross_rows.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <tuple>

#include "base/format.h"
#include "base/median.h"
#include "base/units.h"
#include "machine/joint_units.h"
#include "session/copied_rows.h"
#include "session/sphere_centre.h"

namespace mm {
namespace {

/// How many values of a kind there must be before one of them can be called impossible.
constexpr std::size_t kFewest = 20;
/// At most one in fifty stands alone: more is something else (two places, two machines, wrong units).
constexpr std::size_t kShare = 50;

/// A list of values in which single ones may be impossible. SI.
struct Column {
  std::vector<double> values;       // NaN: not there
  double times = 10.0;              // the range of all others, beyond it
  double leastRange = 0.0;          // that range is taken to be at least this
  double samePlace = 0.0;           // two values closer than this are one place, which was meant
  double lower = 0.0, upper = 0.0;  // of the others; found
};

/// Indices of values that stand alone: farther beyond the range of the others than any measurement of that
/// kind, among many, at a place that occurs once.
std::vector<std::size_t> standAlone(Column& column) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < column.values.size(); ++i)
    if (!std::isnan(column.values[i])) order.push_back(i);
  if (order.size() < kFewest) return {};
  const auto& v = column.values;
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return v[a] < v[b]; });
  const std::size_t n = order.size(), most = std::max<std::size_t>(2, n / kShare);
  column.lower = v[order[most]];
  column.upper = v[order[n - 1 - most]];
  // What is not far, or a place that was measured twice, belongs to the others and widens their range.
  std::vector<std::size_t> alone;
  for (bool grown = true; grown;) {
    grown = false;
    alone.clear();
    const double reach = column.times * std::max(column.upper - column.lower, column.leastRange);
    if (!(reach > 0.0)) return {};  // all the same: nothing says what is far
    const double lower = column.lower, upper = column.upper;
    for (std::size_t k = 0; k < n; ++k) {
      const double value = v[order[k]];
      if (value >= lower && value <= upper) continue;
      const bool twice = (k > 0 && value - v[order[k - 1]] <= column.samePlace) ||
                         (k + 1 < n && v[order[k + 1]] - value <= column.samePlace);
      if (!twice && (value < lower - reach || value > upper + reach)) {
        alone.push_back(order[k]);
        continue;
      }
      column.lower = std::min(column.lower, value);
      column.upper = std::max(column.upper, value);
      grown = true;
    }
  }
  if (alone.size() > most) return {};
  std::sort(alone.begin(), alone.end());
  return alone;
}

class GrossRows {
 public:
  explicit GrossRows(Session& session) : session_(session), gone_(session.observations.size(), 0) {}

  void setAside() {
    copies();
    times();
    joints();
    contacts();
    move();
    for (const bool temperature : {true, false})
      for (Series& series : temperature ? session_.temperatures : session_.covariates)
        logged(series, temperature);
    restart();
  }

 private:
  void name(std::size_t observation, const std::string& field, const std::string& value,
            const std::string& why) {
    if (gone_[observation] != 0) return;
    gone_[observation] = 1;
    found_[observation] = {session_.observations[observation].row, 0, field, value, why, {}, {}};
  }

  void copies() {
    for (const CopiedRow& copy : copiedRows(session_)) name(copy.row, kCopiedRow, "", copy.why);
  }

  void column(Column column, const std::string& field, const std::string& symbol, double toUnit) {
    const char* unit = symbol.c_str();
    for (const std::size_t i : standAlone(column))
      name(
          i, field, format("%.6g %s", column.values[i] / toUnit, unit),
          format("all others are within %.6g … %.6g %s", column.lower / toUnit, column.upper / toUnit, unit) +
              "; correct the value, or leave the row out");
  }

  void times() {
    Column c;
    for (const Observation& o : session_.observations) c.values.push_back(o.time);
    c.times = 100.0;    // a machine may be looked at again the next day
    c.leastRange = 60;  // s
    c.samePlace = 60;
    for (const std::size_t i : standAlone(c))
      name(i, "time", format("%.6g s", c.values[i] - c.lower),
           format("counted from the first of the others, which span %.6g s; correct the time, or leave the "
                  "row out",
                  c.upper - c.lower));
  }

  void joints() {
    const auto& joints = session_.machine.joints();
    for (std::size_t j = 0; j < joints.size(); ++j) {
      const auto [unit, symbol] = readingUnit(joints[j]);
      Column c;
      for (const Observation& o : session_.observations) c.values.push_back(o.position[j]);
      // Where a machine can go, it may have gone once: its travel is the least that counts as a range.
      const double travel = joints[j].upper - joints[j].lower;
      c.leastRange = std::isfinite(travel) && travel > 0.0 ? travel : 0.0;
      constexpr double kSamePlace = 20e-6;  // m or rad: a target is reached up to its deviation
      c.samePlace = kSamePlace;
      column(c, joints[j].name, symbol, unit);
      if (!(joints[j].maxVelocity > 0.0)) continue;
      Column v;
      for (const Observation& o : session_.observations) v.values.push_back(o.velocity[j]);
      v.leastRange = joints[j].maxVelocity;
      v.samePlace = 0.01 * joints[j].maxVelocity;
      column(std::move(v), joints[j].name + " velocity", symbol + std::string("/s"), unit);
    }
  }

  /// What is known of a feature from most of its contacts.
  struct Place {
    bool ball = false;
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    double distance = 0.0;  // R + r, m; 0: of a point
    double off = 0.0;       // median of | distance of a tip from the centre - R - r |
    bool known = false;     // the contacts determine it
  };

  static Eigen::Vector3d medianOf(const std::vector<Eigen::Vector3d>& tips) {
    Eigen::Vector3d middle;
    for (int k = 0; k < 3; ++k) {
      std::vector<double> values;
      for (const auto& t : tips) values.push_back(t[k]);
      middle[k] = upperMedian(std::move(values));
    }
    return middle;
  }

  Place placeOf(const Feature& feature, const std::vector<Eigen::Vector3d>& tips, double tipRadius) const {
    Place place;
    place.ball = feature.kind == FeatureKind::kBall;
    place.distance = place.ball ? feature.radius + tipRadius : 0.0;
    const Eigen::Vector3d middle = medianOf(tips);
    place.centre = middle;
    constexpr std::size_t kDetermining = 6;
    if (!place.ball || tips.size() < kDetermining) return place;
    std::vector<Eigen::Vector3d> near;
    for (const auto& t : tips)
      if ((t - middle).norm() < 2.1 * place.distance) near.push_back(t);
    Eigen::Vector3d centre;
    for (int pass = 0; pass < 3; ++pass) {
      if (near.size() < kDetermining || !sphereCentre(near, place.distance, centre)) return place;
      std::vector<double> off;
      for (const auto& t : tips) off.push_back(std::abs((t - centre).norm() - place.distance));
      place.off = upperMedian(off);
      place.centre = centre;
      near.clear();
      for (std::size_t i = 0; i < tips.size(); ++i)
        if (off[i] <= std::max(5.0 * place.off, 0.02 * place.distance)) near.push_back(tips[i]);
    }
    constexpr double kFits = 0.05;  // of R + r: the readings are of one ball of that radius
    place.known = place.off < kFits * place.distance && 5 * near.size() >= 4 * tips.size();
    return place;
  }

  /// Contacts far from what they are said to have touched.
  void contacts() {
    std::set<std::pair<int, int>> parts;
    for (const Observation& o : session_.observations) parts.emplace(o.placement, o.stylus);
    for (const auto& [placement, stylus] : parts) contacts(placement, stylus);
  }

  void contacts(int placement, int stylus) {
    const auto& features = session_.artifact.features;
    std::vector<std::vector<std::size_t>> of(features.size());
    std::vector<std::vector<Eigen::Vector3d>> tips(features.size());
    std::vector<char> laser(features.size(), 0);
    for (std::size_t i = 0; i < session_.observations.size(); ++i) {
      const Observation& o = session_.observations[i];
      if (o.kind != ObservationKind::kContact || gone_[i] != 0) continue;
      if (o.placement != placement || o.stylus != stylus) continue;
      of[o.feature].push_back(i);
      tips[o.feature].push_back(session_.nominalProbe(o).position);
      if (!std::isnan(o.laserReading)) laser[o.feature] = 1;
    }
    std::vector<Place> places(features.size());
    for (std::size_t f = 0; f < features.size(); ++f)
      if (!tips[f].empty())
        places[f] =
            placeOf(features[f], tips[f], laser[f] != 0 ? 0.0 : session_.artifact.tipRadiusOf(stylus));
    for (std::size_t f = 0; f < features.size(); ++f) judge(f, of[f], tips[f], places);
  }

  void judge(std::size_t f, const std::vector<std::size_t>& rows, const std::vector<Eigen::Vector3d>& tips,
             const std::vector<Place>& places) {
    constexpr std::size_t kFewestOfABall = 5;
    if (rows.size() < kFewestOfABall) return;
    const Place& place = places[f];
    const auto& features = session_.artifact.features;
    const Eigen::Vector3d middle = medianOf(tips);
    std::vector<double> away;
    for (const auto& t : tips) away.push_back((t - middle).norm());
    // Far from the rest whatever the machine's errors are: many times farther than half of the others.
    const double far = std::max(5.0 * place.distance, 30.0 * std::max(upperMedian(away), kMillimetre));
    std::vector<std::pair<std::size_t, std::string>> wrong;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const double from = (tips[i] - place.centre).norm();
      // A touch beside the ball (a stem, a burr) is for the fit to leave aside; this is not even near it.
      const bool beside = place.known && std::abs(from - place.distance) > 0.5 * place.distance;
      if (!beside && away[i] <= far) continue;
      wrong.emplace_back(i, format("the tip is %.4g mm from the %s of '%s'", from / kMillimetre,
                                   place.ball ? "centre" : "place", features[f].name.c_str()));
    }
    if (5 * wrong.size() > rows.size()) return;  // not single rows: a question of names or units
    for (const auto& [i, what] : wrong) {
      std::string why = what + (place.ball ? format(" (R + r = %.4g mm)", place.distance / kMillimetre) : "");
      std::string field = "feature", value = features[f].name;
      const int other = onAnother(f, tips[i], places);
      if (other >= 0)
        why += ", and on '" + features[static_cast<std::size_t>(other)].name + "'; is the name wrong?";
      else
        std::tie(field, value) = suspect(rows, rows[i]);
      name(rows[i], field, value, why + (other >= 0 ? "" : "; correct the row, or leave it out"));
    }
  }

  /// The ball that a tip touches, if it is one.
  static int onAnother(std::size_t f, const Eigen::Vector3d& tip, const std::vector<Place>& places) {
    for (std::size_t g = 0; g < places.size(); ++g) {
      if (g == f || !places[g].known) continue;
      const double off = std::abs((tip - places[g].centre).norm() - places[g].distance);
      if (off < std::max(5.0 * places[g].off, 0.02 * places[g].distance)) return static_cast<int>(g);
    }
    return -1;
  }

  /// The joint whose reading is farthest from the others of that feature.
  std::pair<std::string, std::string> suspect(const std::vector<std::size_t>& rows, std::size_t row) const {
    const auto& joints = session_.machine.joints();
    double worst = -1.0;
    std::size_t at = 0;
    for (std::size_t j = 0; j < joints.size(); ++j) {
      std::vector<double> others, away;
      for (const std::size_t i : rows)
        if (i != row) others.push_back(session_.observations[i].position[j]);
      const double middle = upperMedian(others);
      for (const double q : others) away.push_back(std::abs(q - middle));
      constexpr double kWritten = 1e-3;  // mm or deg: the last digit that a file has
      const double far = std::abs(session_.observations[row].position[j] - middle) /
                         std::max(upperMedian(away), kWritten * readingUnit(joints[j]).factor);
      if (far > worst) worst = far, at = j;
    }
    const auto [unit, symbol] = readingUnit(joints[at]);
    return {joints[at].name, format("%.6g %s", session_.observations[row].position[at] / unit, symbol)};
  }

  void move() {
    if (found_.empty()) return;
    std::vector<Observation> kept;
    for (std::size_t i = 0; i < gone_.size(); ++i) {
      if (gone_[i] == 0) {
        kept.push_back(std::move(session_.observations[i]));
        continue;
      }
      SetAside& aside = found_.at(i);
      aside.observation = std::move(session_.observations[i]);
      session_.setAside.push_back(std::move(aside));
    }
    session_.observations = std::move(kept);
  }

  void logged(Series& series, bool temperature) {
    Column c;
    c.values = series.value;
    // A heater may take a body far up within one reading; an error code (-127, 85, 999) stands farther out.
    c.leastRange = temperature ? 5.0 : 0.0;
    c.times = temperature ? 10.0 : 100.0;
    const std::vector<std::size_t> alone = temperature ? codes(c) : standAlone(c);
    if (alone.empty()) return;
    std::vector<char> out(series.value.size(), 0);
    for (const std::size_t i : alone) {
      out[i] = 1;
      SetAside aside;
      for (const Observation& o : session_.observations)
        if (o.time == series.time[i]) aside.row = o.row;
      aside.field = (temperature ? "temperature " : "") + series.name;
      aside.value = format("%.6g %s", series.value[i], series.unit.c_str());
      aside.why = format(
          "at %.6g s; all others are within %.6g … %.6g %s; values logged before and after it are used "
          "instead",
          series.time[i], c.lower, c.upper, series.unit.c_str());
      aside.logged = SetAside::LoggedValue{series.name, temperature, series.time[i], series.value[i]};
      session_.setAside.push_back(std::move(aside));
    }
    Series kept{series.name, series.unit, {}, {}};
    for (std::size_t i = 0; i < out.size(); ++i)
      if (out[i] == 0) kept.time.push_back(series.time[i]), kept.value.push_back(series.value[i]);
    series = std::move(kept);
  }

  /// As standAlone; but a sensor's error code comes again and again, each time for a moment.
  static std::vector<std::size_t> codes(Column& c) {
    std::vector<std::size_t> alone;
    c.samePlace = -1.0;
    for (const std::size_t i : standAlone(c)) {
      const auto apart = [&](std::size_t k) {
        return std::abs(c.values[k] - c.values[i]) >
               0.5 * std::min(std::abs(c.values[i] - c.lower), std::abs(c.values[i] - c.upper));
      };
      if ((i == 0 || apart(i - 1)) && (i + 1 == c.values.size() || apart(i + 1))) alone.push_back(i);
    }
    return alone;
  }

  /// Where the session seemed to begin at a time that was set aside, it begins at the first that was not.
  void restart() {
    double first = INFINITY, aside = INFINITY;
    for (const SetAside& a : session_.setAside)
      if (a.field == "time" && a.observation) aside = std::min(aside, a.observation->time);
    for (const Observation& o : session_.observations) first = std::min(first, o.time);
    if (!(aside < first)) return;
    for (const auto* all : {&session_.temperatures, &session_.covariates})
      for (const Series& s : *all)
        for (const double t : s.time)
          if (t > aside) first = std::min(first, t);
    const auto shift = [&](double& t) { t = std::round((t - first) * 1e9) / 1e9; };
    for (Observation& o : session_.observations) shift(o.time);
    for (SetAside& a : session_.setAside) {
      if (a.observation) shift(a.observation->time);
      if (a.logged) shift(a.logged->time);
    }
    for (auto* all : {&session_.temperatures, &session_.covariates})
      for (Series& s : *all)
        for (double& t : s.time) shift(t);
    session_.epoch += first;
  }

  Session& session_;
  std::vector<char> gone_;
  std::map<std::size_t, SetAside> found_;
};

}  // namespace

void setGrossRowsAside(Session& session) { GrossRows(session).setAside(); }

void takeBackGrossRows(Session& session) {
  std::vector<SetAside> unread;  // the reader's: nothing of these could be kept
  for (SetAside& a : session.setAside) {
    if (!a.observation && !a.logged) unread.push_back(a);
    if (a.observation) {
      const auto behind = [&](const Observation& o) {
        return o.time > a.observation->time ||
               (o.time == a.observation->time && o.kind == a.observation->kind && o.row > a.observation->row);
      };
      const auto at = std::find_if(session.observations.begin(), session.observations.end(), behind);
      session.observations.insert(at, std::move(*a.observation));
    }
    if (!a.logged) continue;
    for (Series& s : a.logged->temperature ? session.temperatures : session.covariates) {
      if (s.name != a.logged->series) continue;
      const auto at = std::upper_bound(s.time.begin(), s.time.end(), a.logged->time) - s.time.begin();
      s.time.insert(s.time.begin() + at, a.logged->time);
      s.value.insert(s.value.begin() + at, a.logged->value);
    }
  }
  session.setAside = std::move(unread);
}

}  // namespace mm
