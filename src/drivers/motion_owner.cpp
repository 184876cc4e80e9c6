#include "drivers/motion_owner.h"

#include "base/error.h"
#include "base/format.h"

namespace mm {

bool MotionOwner::leased(Clock::time_point now) const { return ticket_ != 0 && now < until_; }

std::string MotionOwner::notRenewed() const { return format("it was not renewed for %.3g s", seconds_); }

void MotionOwner::refuseOthers(const Mover& mover, Clock::time_point now) const {
  const bool another = mover.ticket != ticket_;
  if (mover.ticket != 0 && (another || !leased(now)))
    throw Error("the ticket of '" + mover.who +
                "' is no longer valid: " + (another && !why_.empty() ? why_ : notRenewed()));
  if (another && leased(now))
    throw Error("the axes belong to '" + holder_ + "' now; wait until it has ended, or end it with ~stop");
}

std::uint64_t MotionOwner::take(const Mover& mover, double seconds) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const Clock::time_point now = Clock::now();
  refuseOthers(mover, now);
  if (mover.ticket == 0) {
    if (!moving_.empty()) throw Error(what_ + " by '" + moving_ + "' is under way; wait until it has ended");
    ticket_ = ++last_;
    holder_ = mover.who;
    why_.clear();
  }
  seconds_ = seconds;
  until_ = now + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
  return ticket_;
}

void MotionOwner::give(std::uint64_t ticket) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (ticket == 0 || ticket != ticket_) return;
  ticket_ = 0;
  why_ = "it was given back";
}

void MotionOwner::revoke(const std::string& why) {
  const std::lock_guard<std::mutex> lock(mutex_);
  ticket_ = 0;
  why_ = why;
}

void MotionOwner::begin(const Mover& mover, const std::string& what) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!moving_.empty())
    throw Error(what_ + " by '" + moving_ + "' is under way; wait until it has ended, or call ~stop");
  refuseOthers(mover, Clock::now());
  const std::string gone = mover.gone ? mover.gone() : std::string();
  if (!gone.empty()) throw Error(gone);
  mover_ = mover;
  moving_ = mover.who.empty() ? "somebody" : mover.who;
  what_ = what;
}

void MotionOwner::end() {
  const std::lock_guard<std::mutex> lock(mutex_);
  moving_.clear();
  mover_ = {};
}

std::string MotionOwner::lapse() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (moving_.empty()) return {};
  if (mover_.ticket != 0) {
    if (mover_.ticket == ticket_ && !leased(Clock::now()))
      return format("the lease of '%s' was not renewed for %.3g s", holder_.c_str(), seconds_);
    if (mover_.ticket != ticket_) return "the ticket of '" + moving_ + "' is no longer valid: " + why_;
  }
  return mover_.gone ? mover_.gone() : std::string();
}

std::string MotionOwner::owner() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (leased(Clock::now())) return holder_;
  return moving_;
}

}  // namespace mm
