// One measurement of a plan: a touch with its approach, its way back and its retries, or a reading of the
// laser.
#include "base/error.h"
#include "nodes/measure_node.h"

namespace mm {
namespace {

// Ways back from a surface that the probe may end before somebody has to look. Each one is the way by which
// the tip came, and begins where the one before was stopped.
constexpr int kWaysBack = 10;

}  // namespace

// Before the way back: a contact that was published counts, whatever comes then.
void MeasureNode::countContact() {
  ++feedback_.contacts;
  ++measured_;
  tellMeasured();
}

bool MeasureNode::measure(const Plan& plan, const PlanMove& move) {
  for (int attempt = 0; attempt <= retries_; ++attempt) {
    if (attempt > 0) ++retried_;
    if (move.kind == MoveKind::kTouch) {
      if (touch(plan, move)) return true;
      continue;
    }
    drive(plan, measuring_machine::MoveGoal::GO, move.position, move.speed, {});
    pauseFor(move.wait);
    const std::uint64_t before = contactsSeen();
    if (drive(plan, measuring_machine::MoveGoal::LASER, move.position, move.speed, feedback_.feature) &&
        waitForContact(before)) {
      countContact();
      return true;
    }
  }
  return false;
}

bool MeasureNode::touch(const Plan& plan, const PlanMove& move) {
  using Goal = measuring_machine::MoveGoal;
  drive(plan, Goal::GO, move.position, 0.0, {});
  pauseFor(move.wait);
  requireOpenProbe("touch of line " + std::to_string(move.line));
  const std::uint64_t before = contactsSeen();
  bool contact = false;
  try {
    contact = drive(plan, Goal::PROBE, move.target, move.speed, feedback_.feature) && waitForContact(before);
  } catch (const UnsettledProbe& e) {  // closed for a moment, as it was about to begin
    ROS_WARN("touch of line %d: %s", move.line, e.what());
  } catch (const Cancelled&) {
    if (ros::ok() && !ending_ && touches()) leave(plan, move);
    throw;
  }
  if (contact) countContact();
  leave(plan, move);
  return contact;
}

// A switch that chatters closes again on the way out: all axes are stopped, and once it is open the tip goes
// on the way by which it came. One that stays closed ends the plan.
void MeasureNode::leave(const Plan& plan, const PlanMove& move) {
  struct Leaving {
    bool& leaving;
    explicit Leaving(bool& flag) : leaving(flag) { leaving = true; }
    ~Leaving() { leaving = false; }
  } const leaves(leaving_);
  for (int way = 1;; ++way) {
    std::string reason;
    try {
      drive(plan, measuring_machine::MoveGoal::GO, move.position, 0.0, {});
      return;
    } catch (const UnsettledProbe& e) {
      if (way == kWaysBack)
        throw Error(std::string("on the way back from the touch of line ") + std::to_string(move.line) +
                    ", " + std::to_string(kWaysBack) + " times: " + e.what());
      ++left_;
      ROS_WARN("way back from the touch of line %d: %s", move.line, e.what());
      reason = e.what();
    }
    requireOpenProbe("way back from the touch of line " + std::to_string(move.line), reason);
  }
}

std::string MeasureNode::retriesInWords() const {
  const auto times = [](int n) { return n == 1 ? std::string("once") : std::to_string(n) + " times"; };
  std::string text;
  if (retried_ > 0) text += "; measurements were tried again " + times(retried_);
  if (feedback_.missed > 0) text += "; set aside: " + std::to_string(feedback_.missed);
  if (left_ > 0)
    text += "; the probe closed again on the way back " + times(left_) + ": is its switch bouncing?";
  return text;
}

}  // namespace mm
