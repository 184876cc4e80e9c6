#pragma once
#include <chrono>
#include <cstdint>
#include <functional>
#include <mutex>
#include <string>

namespace mm {

/// Who asks for a motion. Nothing here is authenticated: names are what callers say of themselves.
struct Mover {
  std::string who;           // for people
  std::uint64_t ticket = 0;  // of `MotionOwner::take`; 0: none
  /// Why whoever asked is no longer there, for people; empty: there. Quick. No function: nobody can know.
  std::function<std::string()> gone = {};
};

/// One owner of motion at a time, and only as long as he lives. Whoever moves owns the axes for that motion;
/// whoever means to move for longer takes a ticket: a lease that he renews. A motion goes on only while its
/// ticket is renewed and whoever asked for it is there. A stop takes every ticket away, so that what was
/// under way does not go on after it. By a steady clock; from any thread.
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
  /// or saying why the ticket is no longer valid, or why whoever asks is not there.
  void begin(const Mover& mover, const std::string& what);
  void end();
  /// Why the motion under way may not go on, for people; empty: it may, or nothing moves.
  std::string lapse() const;

  /// Whom the axes obey now, for people; empty: whoever comes.
  std::string owner() const;

 private:
  bool leased(Clock::time_point now) const;
  std::string notRenewed() const;
  void refuseOthers(const Mover& mover, Clock::time_point now) const;

  mutable std::mutex mutex_;
  std::uint64_t ticket_ = 0, last_ = 0;
  std::string holder_, why_;   // why_: the last ticket became invalid
  Clock::time_point until_;    // of the ticket
  double seconds_ = 0.0;       // that it was renewed for
  Mover mover_;                // of the motion under way
  std::string moving_, what_;  // the same for people; empty: none
};

}  // namespace mm
