#pragma once
#include <chrono>
#include <cstdint>
#include <mutex>
#include <string>

namespace mm {

/// Who asks for a motion. Nothing here is authenticated: names are what callers say of themselves.
struct Mover {
  std::string who;           // for people
  std::uint64_t ticket = 0;  // of `MotionOwner::take`; 0: none
};

/// One owner of motion at a time. Whoever moves owns the axes for that motion; whoever means to move for
/// longer takes a ticket, and keeps it by renewing. A stop takes every ticket away, so that what was under
/// way does not go on after it. From any thread.
class MotionOwner {
 public:
  using Clock = std::chrono::steady_clock;

  /// A ticket for `seconds`, or the renewal of one. @throw Error naming the owner when there is another, or
  /// saying why a ticket is no longer valid.
  std::uint64_t take(const Mover& mover, double seconds);
  /// Gives a ticket back; one that is not valid is ignored.
  void give(std::uint64_t ticket);
  /// Takes every ticket away. @param why for people.
  void revoke(const std::string& why);

  /// A motion begins. @param what for people: homing, a move. @throw Error naming who moves or owns the axes,
  /// or saying why the ticket is no longer valid.
  void begin(const Mover& mover, const std::string& what);
  void end();

  /// Whom the axes obey now, for people; empty: whoever comes.
  std::string owner() const;

 private:
  bool leased(Clock::time_point now) const;
  void refuseOthers(const Mover& mover, Clock::time_point now) const;

  mutable std::mutex mutex_;
  std::uint64_t ticket_ = 0, last_ = 0;
  std::string holder_, why_;   // why_: the last ticket became invalid
  Clock::time_point until_;    // of the ticket
  std::string moving_, what_;  // the motion under way; empty: none
};

}  // namespace mm
