// Homing in stages, and the way off a limit.
#include <algorithm>

#include "base/erase_if.h"
#include "base/error.h"
#include "drivers/motion_control.h"

namespace mm {

std::vector<std::vector<std::size_t>> MotionControl::stagesOf(const std::vector<std::string>& names) const {
  const auto index = [&](const std::string& name) {
    const auto found = std::find(axes_.begin(), axes_.end(), name);
    if (found == axes_.end()) throw InputError("joint '" + name + "' is not moved by this driver");
    return static_cast<std::size_t>(found - axes_.begin());
  };
  std::vector<std::size_t> wanted;
  for (const std::string& name : names) wanted.push_back(index(name));
  for (std::size_t j = 0; names.empty() && j < axes_.size(); ++j) wanted.push_back(j);
  std::vector<std::vector<std::size_t>> stages;
  std::vector<bool> listed(axes_.size(), false);
  for (const std::vector<std::string>& stage : settings_.homingOrder) {
    stages.emplace_back();
    for (const std::string& name : stage) {
      const std::size_t j = index(name);
      if (listed[j]) throw InputError("joint '" + name + "' appears twice in the homing order");
      listed[j] = true;
      if (std::count(wanted.begin(), wanted.end(), j) > 0) stages.back().push_back(j);
    }
  }
  stages.emplace_back();
  for (const std::size_t j : wanted)
    if (!listed[j]) stages.back().push_back(j);
  eraseIf(stages, [](const auto& stage) { return stage.empty(); });
  return stages;
}

// What may be ordered of axes that are not ready: an alarm, or a zero that is not known, is what it ends.
void MotionControl::order(std::uint32_t stopsSeen, bool homing, const std::function<void()>& give) {
  withDevice([&] {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      requireAnswering(stopsSeen);
      beginCurrent(!state_.probeClosed);
      current_->homing = homing;
    }
    give();
  });
  if (stops_ != stopsSeen) sendStop();
}

void MotionControl::home(const std::vector<std::string>& names, const Mover& mover, const Watch& watch) {
  std::vector<std::vector<std::size_t>> stages = stagesOf(names);
  if (!capabilities_.homingByAxis) {
    if (!names.empty() && names.size() < axes_.size())
      throw Error("this controller homes all axes together; call ~home");
    stages.assign(1, {});
    for (std::size_t j = 0; j < axes_.size(); ++j) stages[0].push_back(j);
  }
  const std::uint32_t stopsSeen = stops_;
  owner_.begin(mover, "homing");
  const EndOfMotion end(*this);
  for (const std::vector<std::size_t>& stage : stages) {
    order(stopsSeen, true, [&] { controller_->home(stage); });
    awaitHoming(stage, stopsSeen, watch);
  }
  const std::lock_guard<std::mutex> lock(mutex_);
  if (state_.homed) homedHere_ = true;
  touched_ = false;  // homing has led away from the surface
  forgetSurface();
}

void MotionControl::awaitHoming(const std::vector<std::size_t>& stage, std::uint32_t stopsSeen,
                                const Watch& watch) {
  std::unique_lock<std::mutex> lock(mutex_);
  const std::uint64_t first = states_ + 1;
  std::string why;
  while (why.empty()) {
    changed_.wait_for(lock, std::chrono::milliseconds(20));
    if (ending_) throw Error("the driver is shutting down");
    const double age = owing();
    if (stops_ != stopsSeen)
      why = "stopped by " + stoppedBy();
    else if (current_->forced != Outcome::kUnderWay)
      why = current_->why;
    else if (age > settings_.silence)
      why = "the controller has not answered for " + shortSeconds(age);
    else if (states_ > first && !state_.moving)
      break;
    if (!why.empty() || !watch) continue;
    const AxesState now = state_;
    lock.unlock();
    const bool goOn = watch(now);
    lock.lock();
    if (!goOn) why = "cancelled";
  }
  const bool ended = state_.outcome == Outcome::kReached || state_.outcome == Outcome::kUnderWay;
  if (why.empty() && ended &&
      std::all_of(stage.begin(), stage.end(), [&](std::size_t j) { return state_.axisHomed[j]; }))
    return;
  if (why.empty()) why = faultText();
  if (why.empty()) why = state_.note;
  if (why.empty()) why = "the controller stopped before the end";
  lock.unlock();
  sendStop();
  lock.lock();
  awaitRest(lock);
  throw Error("homing did not end: " + why);
}

void MotionControl::moveOffLimit(const Mover& mover) {
  if (!capabilities_.moveOffLimit) throw Error("this controller cannot move off a limit; do it at its panel");
  const std::uint32_t stopsSeen = stops_;
  owner_.begin(mover, "moving off a limit");
  const EndOfMotion end(*this);
  order(stopsSeen, false, [&] { controller_->moveOffLimit(); });
  std::unique_lock<std::mutex> lock(mutex_);
  const std::uint64_t first = states_ + 1;
  if (!changed_.wait_for(lock, std::chrono::seconds(60), [&] {
        return ending_ || stops_ != stopsSeen || !lost_.empty() || current_->forced != Outcome::kUnderWay ||
               (states_ > first && !state_.moving);
      }))
    throw Error("the axes did not leave the limit switch within 60 s");
  if (stops_ != stopsSeen) throw Error("stopped by " + stoppedBy());
  if (!lost_.empty()) throw Error(faultText());
  if (current_->forced != Outcome::kUnderWay) throw Error(current_->why);
  for (std::size_t j = 0; j < state_.limitSwitch.size(); ++j)
    if (state_.limitSwitch[j] != 0) throw Error("the limit switch of " + axes_[j] + " is still closed");
}

}  // namespace mm
