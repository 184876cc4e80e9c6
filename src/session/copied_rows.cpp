#include "session/copied_rows.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "base/format.h"
#include "base/units.h"

namespace mm {
namespace {

/// How much of a row is compared.
enum class Content {
  kMeasured,  // readings and what was measured there
  kWritten,   // with velocities, the setup, stated uncertainties
  kWhole      // with the approach and what was logged beside
};

/// What is in a row, to the bit, but its time.
std::vector<double> contentOf(const Session& session, const Observation& o, Content much) {
  std::vector<double> content;
  const auto add = [&](double v) { content.push_back(std::isnan(v) ? INFINITY : v); };
  const auto addAll = [&](const auto& values) {
    for (Eigen::Index i = 0; i < static_cast<Eigen::Index>(values.size()); ++i) add(values[i]);
  };
  addAll(o.position);
  addAll(o.deviation);
  add(static_cast<double>(o.kind));
  for (const int index : {o.feature, o.placement, o.stylus}) add(index);
  add(o.laserReading);
  add(o.length);
  addAll(o.reference);
  if (much == Content::kMeasured) return content;
  add(o.setup);
  addAll(o.velocity);
  addAll(o.deviationStd);
  if (much == Content::kWritten) return content;
  addAll(o.approach);
  for (const auto* all : {&session.temperatures, &session.covariates})
    for (const Series& series : *all) add(series.at(o.time));
  return content;
}

/// How fine the values of a column are, as far as their digits tell.
class Digits {
 public:
  explicit Digits(double digit) : digit_(digit) {}
  void add(double value) {
    constexpr double kEqual = 1.5;  // digits: two values are rounded to one each, and so was the step
    if (!std::isfinite(value)) return;
    if (std::isnan(first_)) first_ = value;
    const double digits = std::abs(value - first_) / digit_;
    constexpr double kMost = 1e15;  // which a number holds: what is farther apart has no such digits
    if (!(digits < kMost)) return;
    for (double rest = digits; rest > kEqual;) {  // Euclid's, of numbers that are rounded
      const double before = std::exchange(common_, rest);
      rest = std::abs(std::remainder(before, common_));
    }
    farthest_ = std::max(farthest_, digits);
    if (common_ > 0.0) common_ = farthest_ / std::round(farthest_ / common_);  // of many it is known best
  }
  bool finer(double digits) const { return common_ > 0.0 && common_ < digits; }

 private:
  double digit_;
  double first_ = kNotMeasured;
  double common_ = 0.0;    // what all differences are multiples of, digits; 0: they are all the same
  double farthest_ = 0.0;  // the largest difference, digits
};

/// Whether what was measured has digits that noise would change.
bool fineDigits(const Session& session) {
  constexpr double kNanometre = 1e-9, kDigitOfAnAngle = 1e-4 * kArcsecond;
  constexpr double kFine = 100.0;
  std::vector<Digits> columns;
  const auto& joints = session.machine.joints();
  for (int of = 0; of < 2; ++of)  // positions, deviations
    for (const Joint& joint : joints)
      columns.emplace_back(joint.kind == JointKind::kLinear ? kNanometre : kDigitOfAnAngle);
  columns.resize(columns.size() + 5, Digits(kNanometre));  // references, the laser, lengths
  for (const Observation& o : session.observations) {
    auto column = columns.begin();
    // a position that an instrument looks at is where the joint was sent
    for (const double v : o.position) (column++)->add(o.kind == ObservationKind::kContact ? v : kNotMeasured);
    column = columns.begin() + static_cast<long>(joints.size());
    for (const double v : o.deviation) (column++)->add(v);
    column = columns.end() - 5;
    for (int k = 0; k < 3; ++k) (column++)->add(o.reference[k]);
    (column++)->add(o.laserReading);
    column->add(o.length);
  }
  return std::any_of(columns.begin(), columns.end(), [](const Digits& d) { return d.finer(kFine); });
}

}  // namespace

std::vector<RepeatedStretch> repeatedStretches(const Session& session, std::size_t least, bool whole) {
  constexpr std::size_t kMost = 100000;  // rows
  const auto& all = session.observations;
  if (all.size() < 2 * least || all.size() > kMost || !fineDigits(session)) return {};
  std::map<std::vector<double>, std::size_t> last;  // content -> where it was last
  std::vector<RepeatedStretch> stretches;
  RepeatedStretch now;
  const auto end = [&] {
    if (now.length >= least && now.distance >= least) stretches.push_back(now);
  };
  for (std::size_t i = 0; i < all.size(); ++i) {
    const auto [found, isNew] =
        last.emplace(contentOf(session, all[i], whole ? Content::kWhole : Content::kMeasured), i);
    const std::size_t distance = isNew ? 0 : i - found->second;
    found->second = i;
    if (distance == 0 || distance != now.distance) {
      end();
      now = {i, 0, distance};
    }
    if (distance > 0) ++now.length;
  }
  end();
  return stretches;
}

std::vector<CopiedRow> copiedRows(const Session& session) {
  const auto& all = session.observations;
  std::vector<CopiedRow> copies;
  const auto is = [&](std::size_t i) { return "is " + session.rowText(all[i].row, all[i].recording); };
  const auto together = [&](std::size_t i) { return all[i].time == all[i - 1].time; };
  std::map<std::vector<double>, std::size_t> kept;  // rows of the time at hand, by what is in them
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (i > 0 && !together(i)) kept.clear();
    if (kept.empty() && (i + 1 == all.size() || !together(i + 1))) continue;
    const auto [same, isNew] = kept.emplace(contentOf(session, all[i], Content::kWritten), i);
    if (!isNew)
      copies.push_back(
          {i, is(same->second) + " once more, to the same time and the last digit; it is used once"});
  }
  // Nothing that is measured repeats itself so.
  constexpr std::size_t kPasted = 10;
  for (const RepeatedStretch& stretch : repeatedStretches(session, kPasted, true))
    for (std::size_t i = stretch.begin; i < stretch.begin + stretch.length; ++i)
      copies.push_back({i, is(i - stretch.distance) + format(" once more, to the last digit, and so are %zu "
                                                             "rows in a row: a run that was pasted or read "
                                                             "twice; it is used once",
                                                             stretch.length)});
  return copies;
}

}  // namespace mm
