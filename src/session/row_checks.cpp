#include <algorithm>
#include <cmath>
#include <string>

#include "base/format.h"
#include "base/range.h"
#include "base/units.h"
#include "machine/joint_units.h"
#include "session/copied_rows.h"
#include "session/sense_checks.h"

namespace mm {
namespace {

class RowAsker {
 public:
  explicit RowAsker(const Session& session) : session_(session) {
    positions_.resize(session.machine.joints().size());
    for (const Observation& o : session.observations)
      for (std::size_t j = 0; j < positions_.size(); ++j) positions_[j].add(o.position[j]);
  }

  std::vector<Doubt> ask(bool travelsToo) {
    if (travelsToo) travels();
    deviations();
    timesBack();
    timesLong();
    repeats();
    return std::move(doubts_);
  }

 private:
  void doubt(const std::string& question) { doubts_.push_back({question}); }

  bool linear(std::size_t j) const { return session_.machine.joints()[j].kind == JointKind::kLinear; }
  const std::string& name(std::size_t j) const { return session_.machine.joints()[j].name; }

  /// Whether a range, times `factor`, is within the travel and so much beyond (in travels).
  bool within(std::size_t j, const Range& range, double factor, double beyond) const {
    const Joint& joint = session_.machine.joints()[j];
    const double more = beyond * travel(j);
    return range.lower * factor >= joint.lower - more && range.upper * factor <= joint.upper + more;
  }

  double travel(std::size_t j) const {
    const Joint& joint = session_.machine.joints()[j];
    return joint.upper - joint.lower;
  }
  bool limited(std::size_t j) const { return std::isfinite(travel(j)) && travel(j) > 0.0; }

  /// "x is -16000 … 16000 mm, but the machine goes from -20 to 20 mm (16 of 18 rows are beyond): ".
  std::string beyondText(std::size_t j) const {
    const Joint& joint = session_.machine.joints()[j];
    const auto [unit, symbol] = readingUnit(joint);
    std::size_t beyond = 0;
    for (const Observation& o : session_.observations)
      beyond += o.position[j] < joint.lower || o.position[j] > joint.upper;
    return format(
        "%s is %.6g … %.6g %s, but the machine goes from %.6g to %.6g %s (%zu of %zu rows are beyond): ",
        name(j).c_str(), positions_[j].lower / unit, positions_[j].upper / unit, symbol, joint.lower / unit,
        joint.upper / unit, symbol, beyond, session_.observations.size());
  }

  /// Two joints that are both beyond their travels, and within when they are exchanged.
  bool exchanged() {
    constexpr double kClearly = 0.05;  // travels: a machine may be moved a little beyond what its URDF says
    const auto beyond = [&](std::size_t j) {
      return limited(j) && positions_[j].any() && !within(j, positions_[j], 1.0, kClearly);
    };
    for (std::size_t j = 0; j < positions_.size(); ++j)
      for (std::size_t k = j + 1; k < positions_.size(); ++k) {
        if (linear(j) != linear(k) || !beyond(j) || !beyond(k) || !within(j, positions_[k], 1.0, 0.0) ||
            !within(k, positions_[j], 1.0, 0.0))
          continue;
        doubt(beyondText(j) + name(j) + " and " + name(k) +
              " are both beyond, and both within when they are exchanged; are the two mixed up?");
        return true;
      }
    return false;
  }

  void travels() {
    // a URDF may be of a similar machine, or its zero elsewhere; another unit is off by much more
    constexpr double kFar = 2.0;  // travels
    if (exchanged()) return;
    for (std::size_t j = 0; j < positions_.size(); ++j)
      if (positions_[j].any() && limited(j) && !within(j, positions_[j], 1.0, kFar))
        doubt(beyondText(j) + perhaps(j));
  }

  /// What would bring a joint into its travel.
  std::string perhaps(std::size_t j) const {
    struct Unit {
      double factor;
      const char* what;
      bool linear;
    };
    constexpr double kLeast = 0.1;  // of the travel: what is shrunk to nothing is within any
    for (const Unit& u :
         {Unit{1e-3, "divided by 1000 it is within; is it in um instead of mm, or in mm instead of m?", true},
          Unit{kDegree, "it is within if it is in degrees instead of radians; is it?", false},
          Unit{1.0 / 60.0, "divided by 60 it is within; is it in minutes of arc?", false},
          Unit{1.0 / 3600.0, "divided by 3600 it is within; is it in seconds of arc?", false}})
      if (u.linear == linear(j) && within(j, positions_[j], u.factor, 0.0) &&
          positions_[j].size() * u.factor >= kLeast * travel(j))
        return u.what;
    return "are its unit and zero right, and is this the machine?";
  }

  void deviations() {
    constexpr double kRounding = 1e-12;  // m or rad: what is left of sums is no measurement
    for (std::size_t j = 0; j < positions_.size(); ++j) {
      Range range, sum;
      for (const Observation& o : session_.observations)
        if (o.kind == ObservationKind::kDeviation) {
          range.add(o.deviation[j]);
          sum.add(o.deviation[j] + o.position[j]);
        }
      if (!range.any() || range.largest() == 0.0) continue;
      // a surface of one height that was touched: the deviation is the reading with its sign changed
      if (sum.size() < kRounding) continue;
      const auto [unit, symbol] = errorUnit(session_.machine.joints()[j]);
      const auto [way, waySymbol] = readingUnit(session_.machine.joints()[j]);
      // a joint that hardly moves (a bed that is touched) says nothing
      constexpr double kHardly = 0.05, kLittle = 1e-3;  // of the travel; m or rad
      double moved = positions_[j].any() ? positions_[j].size() : 0.0;
      if (moved < (limited(j) ? kHardly * travel(j) : kLittle)) moved = 0.0;
      if (limited(j)) moved = std::min(moved, travel(j));   // beyond it has a question of its own
      constexpr double kTooMuch = 0.02, kTooLittle = 1e-7;  // of the motion; a nanometre in a centimetre
      const std::string text =
          format("deviations of %s are %.4g … %.4g %s, while %s moves over %.4g %s: ", name(j).c_str(),
                 range.lower / unit, range.upper / unit, symbol, name(j).c_str(), moved / way, waySymbol);
      // an unknown zero is no deviation: their spread counts
      if (range.largest() < kRounding) continue;
      if (moved > 0.0 && range.size() > kTooMuch * moved)
        doubt(text + "no machine has such large errors; are they measured positions, or in another unit?");
      else if (moved > 0.0 && range.largest() < kTooLittle * moved && session_.observations.size() > 2)
        doubt(text + "no machine has such small errors; are they in " +
              (linear(j) ? "millimetres?" : "degrees?"));
    }
  }

  /// Rows in the order of the file whose time is before that of a row above.
  void timesBack() {
    if (session_.rowFile.empty()) return;
    std::vector<const Observation*> rows;
    for (const Observation& o : session_.observations) rows.push_back(&o);
    std::stable_sort(rows.begin(), rows.end(),
                     [](const Observation* a, const Observation* b) { return a->row < b->row; });
    // where a line of the file is several rows, their order is not that of the lines
    const auto sameLine = [](const Observation* a, const Observation* b) { return a->row == b->row; };
    if (std::adjacent_find(rows.begin(), rows.end(), sameLine) != rows.end()) return;
    std::size_t count = 0;
    const Observation* first = nullptr;
    const Observation* before = nullptr;
    for (std::size_t i = 1; i < rows.size(); ++i) {
      if (rows[i]->time >= rows[i - 1]->time) continue;
      if (count++ == 0) first = rows[i], before = rows[i - 1];
    }
    // a table that is sorted by something else than time goes back again and again
    constexpr std::size_t kFew = 3, kShare = 20;
    if (count == 0 || count > std::max(kFew, rows.size() / kShare)) return;
    doubt(format("time goes back at %zu place%s, first from %.6g s to %.6g s in ", count,
                 count == 1 ? "" : "s", before->time, first->time) +
          session_.rowText(first->row, first->recording) +
          ": rows are taken in the order of their times; was the clock set, were several runs joined, or is "
          "the order wrong?");
  }

  void timesLong() {
    constexpr double kDay = 86400.0, kYear = 365.0 * kDay;  // no session lasts as long
    const auto& all = session_.observations;
    constexpr std::size_t kFew = 5;
    if (session_.rowFile.empty() || all.size() < kFew) return;
    const double lasts = all.back().time - all.front().time;
    if (lasts > kYear)
      doubt(
          format("the rows last %.4g days; are the times in milliseconds, or is one of them of another year?",
                 lasts / kDay));
  }

  /// What `prepare` did not set aside: a direction of travel or a temperature differs, or the stretch is
  /// short.
  void repeats() {
    constexpr std::size_t kStretch = 6;
    const std::vector<RepeatedStretch> stretches = repeatedStretches(session_, kStretch, false);
    if (stretches.empty()) return;
    const RepeatedStretch& longest = *std::max_element(
        stretches.begin(), stretches.end(), [](const auto& a, const auto& b) { return a.length < b.length; });
    const auto& all = session_.observations;
    doubt(format("%zu rows from ", longest.length) +
          session_.rowText(all[longest.begin].row, all[longest.begin].recording) +
          " on are identical to the last digit to those from " +
          session_.rowText(all[longest.begin - longest.distance].row,
                           all[longest.begin - longest.distance].recording) +
          " on: is a run included twice? (the noise would be underestimated)");
  }

  const Session& session_;
  std::vector<Range> positions_;
  std::vector<Doubt> doubts_;
};

}  // namespace

std::vector<Doubt> rowDoubts(const Session& session, bool travels) { return RowAsker(session).ask(travels); }

}  // namespace mm
