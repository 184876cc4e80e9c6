#include "session/sense_checks.h"

#include <algorithm>
#include <cmath>

#include "base/erase_if.h"
#include "base/format.h"
#include "base/range.h"
#include "base/units.h"
#include "machine/joint_units.h"
#include "session/agreement.h"
#include "session/assumed_travel.h"

namespace mm {
namespace {

constexpr double kSameTurn = 1e-3;  // rad: two ways to lie turned that far apart are equally likely

/// Machines out of a box are wrong by tens of um; mistaken units and names by millimetres.
constexpr double kSuspect = 50e-6;  // m
/// A machine's own errors stay whatever is tried; a mistake that is undone takes nearly all away.
constexpr double kUndone = 0.1;
constexpr double kAsGood = 1.5;  // times the least misfit

/// "14 mm", "3.1 um".
std::string length(double metres) {
  return metres >= kMillimetre ? format("%.3g mm", metres / kMillimetre)
                               : format("%.3g um", metres / kMicrometre);
}

/// Something that may have been meant, and how well it agrees.
struct Hypothesis {
  std::string with, question;
  Agreement agreement;
};

class Asker {
 public:
  explicit Asker(const Session& session)
      : session_(session), geometry_(session), base_(geometry_.judge({})) {}

  std::vector<Doubt> ask() {
    temperatures();
    references();
    directions();
    const double noise = session_.artifact.repeatability;
    constexpr double kTimesNoise = 100.0;
    if (base_.misfit > std::max(kSuspect, std::isfinite(noise) ? kTimesNoise * noise : 0.0)) {
      scales();
      signs();
      exchanges();
      names();
      tell();
    } else {
      approaches();
      velocities();
    }
    return std::move(doubts_);
  }

 private:
  bool imported() const { return !session_.rowFile.empty(); }
  bool linear(std::size_t j) const { return session_.machine.joints()[j].kind == JointKind::kLinear; }
  /// A joint as the file calls it.
  std::string column(std::size_t j) const {
    const std::string& name = session_.machine.joints()[j].name;
    return imported() ? name + "_" + readingUnit(session_.machine.joints()[j]).symbol : name;
  }

  /// A question that the geometry does not judge, and that comes before any physics.
  void first(const std::string& question) { doubts_.push_back({question, kNotMeasured, kNotMeasured, true}); }

  void temperatures() {
    constexpr double kKelvin = 200.0;                           // degC: no sensor of a machine reads above
    constexpr double kWarm = 55.0, kHot = 110.0, kRoom = 15.0;  // degF of a room, and how far it may change
    std::vector<Range> ranges(session_.temperatures.size());
    for (std::size_t i = 0; i < ranges.size(); ++i)
      for (const double v : session_.temperatures[i].value) ranges[i].add(v);
    // one warm sensor is a heated bed; all of them are a unit
    const bool fahrenheit = std::all_of(ranges.begin(), ranges.end(), [&](const auto& r) {
      return r.any() && r.lower >= kWarm && r.upper <= kHot && r.size() <= kRoom;
    });
    for (std::size_t i = 0; i < ranges.size(); ++i) {
      if (!ranges[i].any()) continue;
      const auto& [low, high] = ranges[i];
      const std::string is =
          format("temperature %s is %.4g to %.4g: is it ", session_.temperatures[i].name.c_str(), low, high);
      if (low > kKelvin)
        first(is + "kelvin? (degC expected)");
      else if (fahrenheit)
        doubts_.push_back({is + format("Fahrenheit? (degC expected; it would be %.3g to %.3g degC)",
                                       (low - 32.0) / 1.8, (high - 32.0) / 1.8)});
    }
  }

  /// Deviations that are the readings of their joint with the other sign: what was taken for the true
  /// position did not move (a flat surface that was probed at many places), and the reading is itself the
  /// deviation.
  void references() {
    constexpr double kTheSame = 1e-3;  // of the range of the readings: no machine errs by its whole way
    constexpr int kFewest = 5;
    for (std::size_t j = 0; j < session_.machine.joints().size(); ++j) {
      Range readings, sums;
      int count = 0;
      for (const Observation& o : session_.observations) {
        if (o.kind != ObservationKind::kDeviation || !std::isfinite(o.deviation[j])) continue;
        readings.add(o.position[j]);
        sums.add(o.position[j] + o.deviation[j]);
        ++count;
      }
      if (count < kFewest || !(readings.size() > 0.0) || !(sums.size() < kTheSame * readings.size()))
        continue;
      const std::string name = session_.machine.joints()[j].name;
      first("the deviations of " + name + " are its readings with the other sign: what they were " +
            "compared with is the same place in all " + std::to_string(count) +
            " rows; was the reading itself meant as the deviation? (else give the positions that " +
            "an independent instrument measured)");
    }
  }

  /// Directions of travel against the order of the positions that an instrument measured. (A touch ends in
  /// the direction of its approach: velocities().)
  void directions() {
    constexpr int kFewest = 10;
    constexpr double kFew = 0.05;  // of the rows; a way from one side only contradicts about half
    for (std::size_t j = 0; j < session_.machine.joints().size(); ++j) {
      int rows = 0, agree = 0;
      const Observation* last = nullptr;
      for (const Observation& o : session_.observations) {
        if (o.kind == ObservationKind::kContact) continue;
        const double moved = last != nullptr ? o.position[j] - last->position[j] : 0.0;
        last = &o;
        if (o.travel[j] == 0.0 || std::abs(moved) < kSameTarget) continue;
        ++rows;
        agree += moved * o.travel[j] > 0.0;
      }
      if (rows < kFewest || agree > kFew * rows) continue;
      const std::string name = session_.machine.joints()[j].name;
      first(
          format("%s moved against its recorded direction of travel in %d of %d rows, by the order of its "
                 "positions: is the sign of that direction wrong?",
                 name.c_str(), rows - agree, rows));
    }
  }

  /// @return whether it agrees, and so is kept.
  /// @param factor by which readings are multiplied: what is shrunk disagrees less, whatever it is.
  bool consider(const std::string& with, const std::string& question, const Change& change,
                double factor = 1.0) {
    constexpr double kCap = 0.3;  // radii: what is shrunk to a point lies on any sphere
    Hypothesis h{with, question, geometry_.judge(change)};
    if (!(h.agreement.misfit < kUndone * std::min(1.0, factor) * base_.misfit) ||
        (factor != 1.0 && h.agreement.cap < kCap))
      return false;
    found_.push_back(std::move(h));
    return true;
  }

  void scales() {
    struct Unit {
      double factor;
      const char* name;
      bool linear;
    };
    std::vector<Unit> units = {{25.4, "inches", true}, {1000.0, "metres", true}, {1e-3, "micrometres", true}};
    if (!imported()) units = {{1e-3, "millimetres", true}, {0.0254, "inches", true}};
    units.push_back(imported() ? Unit{1.0 / kDegree, "radians", false} : Unit{kDegree, "degrees", false});
    for (const Unit& unit : units) {
      std::vector<std::size_t> joints;
      std::string all;
      for (std::size_t j = 0; j < session_.machine.joints().size(); ++j)
        if (linear(j) == unit.linear && moved(j))
          joints.push_back(j), all += (all.empty() ? "" : ", ") + column(j);
      const auto tried = [&](const std::vector<std::size_t>& some, const std::string& name) {
        return consider(
            "with " + name + " in " + unit.name,
            std::string(some.size() > 1 ? "are they" : "is it") + " in " + unit.name + "?",
            [&](std::vector<double>& q) {
              for (const std::size_t j : some) q[j] *= unit.factor;
            },
            unit.factor);
      };
      if (joints.empty() || tried(joints, all) || joints.size() == 1) continue;
      for (const std::size_t j : joints) tried({j}, column(j));
    }
  }

  bool moved(std::size_t j) const {
    for (const Observation& o : session_.observations)
      if (o.position[j] != session_.observations.front().position[j]) return true;
    return false;
  }

  void signs() {
    for (std::size_t j = 0; j < session_.machine.joints().size(); ++j)
      if (moved(j))
        consider("with " + column(j) + " reversed", "is its sign wrong?",
                 [j](std::vector<double>& q) { q[j] = -q[j]; });
  }

  void exchanges() {
    for (std::size_t i = 0; i < session_.machine.joints().size(); ++i)
      for (std::size_t j = i + 1; j < session_.machine.joints().size(); ++j)
        if (linear(i) == linear(j) && (moved(i) || moved(j)))
          consider("with " + column(i) + " and " + column(j) + " exchanged", "are the two mixed up?",
                   [i, j](std::vector<double>& q) { std::swap(q[i], q[j]); });
  }

  /// Exchanges two names at a time as long as the layout agrees better.
  void names() {
    std::vector<int> names = geometry_.names();
    const std::vector<int> own = names;
    Agreement a = base_;
    const double start = geometry_.layout(a.centres, names, a);
    double best = start;
    for (bool better = true; better && best > 0.0;) {
      better = false;
      std::pair<std::size_t, std::size_t> at;
      double least = best;
      for (std::size_t f = 0; f < names.size(); ++f)
        for (std::size_t g = f + 1; g < names.size(); ++g) {
          if (!a.centres[f].allFinite() || !a.centres[g].allFinite()) continue;
          std::swap(names[f], names[g]);
          const double misfit = geometry_.layout(a.centres, names, a);
          if (misfit < 0.999 * least) least = misfit, at = {f, g}, better = true;
          std::swap(names[f], names[g]);
        }
      if (better) std::swap(names[at.first], names[at.second]), best = least;
    }
    if (names == own) return;
    a.misfit = std::sqrt(std::max(0.0, base_.misfit * base_.misfit - start * start) + best * best);
    geometry_.layout(a.centres, names, a);
    if (!(a.misfit < kUndone * base_.misfit)) return;
    std::string list;
    int changed = 0;
    const auto& features = session_.artifact.features;
    for (std::size_t f = 0; f < names.size(); ++f) {
      if (names[f] == own[f]) continue;
      ++changed;
      list += (list.empty() ? "'" : ", '") + features[f].name + "' as '" +
              features[static_cast<std::size_t>(names[f])].name + "'";
    }
    constexpr int kFew = 4;  // of many names the layout as a whole may be another one
    if (changed <= kFew || 2 * changed <= static_cast<int>(names.size()))
      found_.push_back({"with ball " + list, "are the names mixed up?", a});
  }

  void tell() {
    if (found_.empty()) return;
    double least = INFINITY;
    bool anyAligned = false;
    constexpr double kAligned = 0.9;
    for (const Hypothesis& h : found_) {
      least = std::min(least, h.agreement.misfit);
      anyAligned |= h.agreement.aligned > kAligned;
    }
    eraseIf(found_, [&](const Hypothesis& h) {
      return h.agreement.misfit > kAsGood * least || (anyAligned && !(h.agreement.aligned > kAligned));
    });
    // A mirror image is a mirror image: what needs the artifact to be turned least comes first.
    std::stable_sort(found_.begin(), found_.end(), [](const Hypothesis& a, const Hypothesis& b) {
      return a.agreement.turn < b.agreement.turn - kSameTurn;
    });
    const Hypothesis& h = found_.front();
    std::string others;
    constexpr std::size_t kNamed = 3;
    for (std::size_t i = 1; i < std::min(kNamed, found_.size()); ++i)
      others += (others.empty() ? " (as well " : ", or ") + found_[i].with;
    doubts_.push_back({h.with + " " + what() + " within " + length(h.agreement.misfit) + " instead of " +
                           length(base_.misfit) + ": " + h.question + (others.empty() ? "" : others + ")"),
                       base_.misfit, h.agreement.misfit, true});
  }

  std::string what() const {
    const bool contacts =
        std::any_of(session_.observations.begin(), session_.observations.end(),
                    [](const Observation& o) { return o.kind == ObservationKind::kContact; });
    return contacts ? "the contacts agree with the artifact" : "the readings agree with the instrument";
  }

  /// Recorded approaches that do not point at what was touched.
  void approaches() {
    constexpr double kAway = -0.8;
    if (!(base_.aligned < kBeside)) return;
    if (base_.aligned < kAway)
      return first(
          format("the recorded approaches point away from the balls (mean cosine %.2f): is the approach "
                 "reversed? (the motion of the tip into the surface is expected)",
                 base_.aligned));
    for (std::size_t j = 0; j < session_.machine.joints().size(); ++j) {
      const Agreement a = geometry_.judge([j](std::vector<double>& q) { q[j] = -q[j]; });
      if (!(a.aligned > kAt) || !(a.misfit < kAsGood * std::max(base_.misfit, kMicrometre))) continue;
      first("with " + column(j) +
            format(" reversed the recorded approaches point at the balls (mean cosine %.2f instead of %.2f): "
                   "is its sign wrong?",
                   a.aligned, base_.aligned));
    }
  }

  /// Recorded velocities that do not move the tip into what was touched, and would with another sign or in
  /// another column. A scan moves along the surface, whatever is changed.
  void velocities() {
    const double recorded = geometry_.travelling(base_, {});
    if (!(recorded < kBeside)) return;
    const auto& joints = session_.machine.joints();
    const auto tried = [&](const std::string& how, const std::string& question, const Change& change) {
      const double aligned = geometry_.travelling(base_, change);
      if (!(aligned > kAt)) return;
      first(
          format("with the velocities of %s the tip moves into the balls (mean cosine %.2f instead of "
                 "%.2f): %s",
                 how.c_str(), aligned, recorded, question.c_str()));
    };
    tried("all joints reversed", "is the sign of their velocities wrong?", [](std::vector<double>& v) {
      for (double& each : v) each = -each;
    });
    for (std::size_t j = 0; j < joints.size(); ++j)
      tried(joints[j].name + " reversed", "is the sign of its velocity wrong?",
            [j](std::vector<double>& v) { v[j] = -v[j]; });
    for (std::size_t i = 0; i < joints.size(); ++i)
      for (std::size_t j = i + 1; j < joints.size(); ++j)
        if (linear(i) == linear(j))
          tried(joints[i].name + " and " + joints[j].name + " exchanged", "are the two mixed up?",
                [i, j](std::vector<double>& v) { std::swap(v[i], v[j]); });
  }

  static constexpr double kBeside = 0.8, kAt = 0.95;  // mean cosines: the motion is not, and is, as expected

  const Session& session_;
  Geometry geometry_;
  Agreement base_;
  std::vector<Hypothesis> found_;
  std::vector<Doubt> doubts_;
};

}  // namespace

std::vector<Doubt> sensibleDoubts(const Session& session) {
  std::vector<Doubt> doubts = Asker(session).ask();
  const bool judged =
      std::any_of(doubts.begin(), doubts.end(), [](const Doubt& d) { return std::isfinite(d.before); });
  for (Doubt& doubt : rowDoubts(session, !judged)) doubts.push_back(std::move(doubt));
  return doubts;
}

}  // namespace mm
