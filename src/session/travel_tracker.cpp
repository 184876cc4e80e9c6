#include "session/travel_tracker.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace mm {
namespace {

constexpr double kDeadband = 1e-6;        // m: an encoder at rest moves less
constexpr double kRotaryDeadband = 1e-5;  // rad

// s within which a velocity at which a joint really moves would take it past the deadband. An encoder at rest
// that dithers by a digit says a tenth of that.
constexpr double kMoves = 10e-3;

constexpr std::int64_t kSparse =
    200000000;  // ns: readings further apart may have a whole motion between them

}  // namespace

double directionOf(double velocity) {
  if (!(std::abs(velocity) > kStandstill)) return 0.0;
  return velocity > 0.0 ? 1.0 : -1.0;
}

double travelDeadband(JointKind kind) { return kind == JointKind::kLinear ? kDeadband : kRotaryDeadband; }

void deriveTravel(std::vector<Observation>& observations, int joints, bool byTheWay) {
  std::vector<std::size_t> order(observations.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto earlier = [&](std::size_t a, std::size_t b) {
    return observations[a].time < observations[b].time;
  };
  if (!std::is_sorted(order.begin(), order.end(), earlier))
    std::stable_sort(order.begin(), order.end(), earlier);
  std::vector<double> last(joints, 0.0);
  const Observation* before = nullptr;
  for (const std::size_t i : order) {
    Observation& o = observations[i];
    o.travel.resize(joints, 0.0);
    for (int j = 0; j < joints; ++j) {
      const double v = o.velocity[j], way = before != nullptr ? o.position[j] - before->position[j] : 0.0;
      if (std::abs(way) > kDeadband) last[j] = byTheWay ? std::copysign(1.0, way) : 0.0;
      if (directionOf(v) != 0.0)
        o.travel[j] = directionOf(v);
      else if (!std::isnan(v) && o.travel[j] == 0.0)
        o.travel[j] = last[j];
      if (o.travel[j] != 0.0) last[j] = o.travel[j];
    }
    before = &o;
  }
}

bool TravelTracker::turn(double direction, double from) {
  const bool changed = direction != direction_;
  if (changed) turn_ = from;
  direction_ = direction;
  farthest_ = position_;
  turned_ = last_;
  return changed;
}

bool TravelTracker::take(std::int64_t stamp, double position, double velocity) {
  if (!std::isfinite(position)) return false;
  if (anotherZero_) {
    anotherZero_ = false;
    turn_ += position - position_;
    farthest_ += position - position_;
    low_ = high_ = position_ = position;
    last_ = stamp;
    return false;
  }
  const bool sparse = started_ && stamp - last_ > kSparse;
  last_ = stamp;
  position_ = position;
  if (!started_) turn_ = farthest_ = low_ = high_ = position;
  const bool first = !started_;
  started_ = true;
  // What was told is of one who saw it move; a first velocity beside it is none.
  if (((first && direction_ == 0.0) || sparse) && std::abs(velocity) * kMoves > deadband_)
    return turn(directionOf(velocity), position);
  if (direction_ != 0.0) {
    if ((position - farthest_) * direction_ > 0.0) farthest_ = position;
    if ((farthest_ - position) * direction_ > deadband_) return turn(-direction_, farthest_);
    return false;
  }
  low_ = std::min(low_, position);
  high_ = std::max(high_, position);
  if (position - low_ > deadband_) return turn(1.0, low_);
  if (high_ - position > deadband_) return turn(-1.0, high_);
  return false;
}

void TravelTracker::tell(std::int64_t stamp, double direction) {
  if (direction == direction_ || stamp < turned_) return;
  direction_ = direction;
  turned_ = stamp;
  turn_ = farthest_ = position_;
}

double TravelTracker::sinceReversal() const {
  return direction_ != 0.0 ? std::abs(position_ - turn_) : std::numeric_limits<double>::quiet_NaN();
}

double TravelTracker::back() const { return std::max(0.0, (farthest_ - position_) * direction_); }

}  // namespace mm
