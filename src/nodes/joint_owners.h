#pragma once
#include <boost/shared_ptr.hpp>
#include <boost/weak_ptr.hpp>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace mm {

/// Whose the joints of a machine are, and which of their states is believed: only the owner's. A driver owns
/// the joints that its status names; a joint that no status names belongs to the publisher that was heard
/// first, until that has gone. What a driver's state says must fit its status: homed, of the same life of the
/// driver, at the same time. Stamps in ns; `now` in s of a clock that never goes back.
class JointOwners {
 public:
  /// A connection to a publisher: one object for all of its messages, gone with it.
  using Link = boost::shared_ptr<const void>;
  struct Sender {
    std::string name;  // as it calls itself: "/axis_driver"
    Link link;
  };
  /// What one joint state says beside its readings.
  struct State {
    std::int64_t stamp = 0;
    bool told = false, homed = false;  // told: it says itself whether its readings have a zero
    std::int64_t homedAt = 0;          // 0: it does not say
  };
  struct Status {
    std::int64_t stamp = 0;
    bool homed = false;
    std::int64_t homedAt = 0;         // 0: never
    std::vector<int> joints;          // of the machine
    std::vector<std::int8_t> travel;  // of each: direction of its last motion; 0: none yet
  };
  struct Verdict {
    std::string why;                 // it is not believed; empty: it is
    bool foreign = false;            // it is not the owner's
    bool forget = false;             // how its joints moved until now is not known
    const Status* status = nullptr;  // of its driver; null: none. Valid until the next call
  };

  static constexpr const char* kUnhomed =
      "the axes are not homed, so their readings have no zero; call axis_driver/home";

  /// @param joints of the machine, by name.
  explicit JointOwners(std::vector<std::string> joints);
  /// A status is on its way: until `until` nobody owns a joint by being first.
  void awaitStatus(double until) { awaited_ = until; }

  /// @param joints of the machine in the message, not empty.
  Verdict take(const Sender& sender, const State& state, const std::vector<int>& joints, double now);
  /// @return why it is not believed; empty: it is.
  std::string take(const Sender& sender, const Status& status, double now);

  bool anyNotHomed() const;   ///< a joint whose owner says that it has no zero
  std::int64_t zero() const;  ///< of the last homing; 0: not known

 private:
  struct Joint {
    std::string name, owner;
    bool byStatus = false;
  };
  struct Owner {
    boost::weak_ptr<const void> states, statuses;  // links
    int life = 0, statusLife = 0;                  // how often they were new
    std::optional<Status> status;                  // of this life
    std::int64_t first = 0, unhomedAt = 0;         // stamps of this life's states; 0: none
    std::int64_t zero = 0;                         // of the homing; 0: not known
    bool unhomed = false;
    double heard = 0.0;
  };
  bool gone(const std::string& owner, double now) const;
  std::string rivalOf(const Sender& sender, const std::vector<int>& joints, bool byStatus, double now) const;
  Owner& claim(const Sender& sender, const std::vector<int>& joints, bool byStatus, double now);
  std::string misfit(const std::string& name, const Owner& owner, const State& state) const;

  std::vector<Joint> joints_;
  std::map<std::string, Owner> owners_;
  double awaited_ = 0.0;
};

}  // namespace mm
