#pragma once
#include <measuring_machine/AxisStatus.h>
#include <sensor_msgs/JointState.h>

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "machine/machine.h"
#include "session/travel_tracker.h"

namespace mm {

/// How the joints of a session moved, by their joint states. Those of one publisher count: of the driver
/// whose status names the joint, wherever it came; of a joint that no status names, of the publisher that was
/// heard first. In whatever order states and statuses arrive. Not thread-safe.
class TravelLog {
 public:
  struct Motion {
    std::int64_t stamp;  // ns
    double direction;    // -1 or +1
  };

  /// @param most motions of a joint that are kept; 0: all.
  void bound(std::size_t most) { most_ = most; }
  /// @param told a direction is that of the velocity, whatever the readings: a file told it.
  void trustVelocities(bool told) { told_ = told; }

  /// @param publisher its node. @param machine whose joints count; null: not known yet.
  /// @param start stamp of the session, ns: what lies before goes first, where room is needed.
  void take(const sensor_msgs::JointState& message, const std::string& publisher, const Machine* machine,
            std::int64_t start);
  void take(const measuring_machine::AxisStatus& message, const std::string& publisher);

  /// Where the joint's direction of travel changed, by stamp.
  std::vector<Motion> motions(const std::string& joint) const;
  std::optional<std::int64_t> earliest(const std::string& joint) const;  ///< stamp of its first state, ns
  /// For people, what is no longer kept; empty: everything is.
  std::string lacking() const;

  void dropAfter(std::int64_t stamp);   ///< forgets what is stamped then or later (ns)
  void dropBefore(std::int64_t stamp);  ///< forgets what is stamped earlier (ns), but for the last of it

 private:
  struct Track {  // of one joint, by one publisher
    TravelTracker travel;
    std::vector<Motion> motions;
    std::int64_t earliest;    // ns
    std::size_t dropped = 0;  // motions, for want of room
  };
  struct Joint {
    std::string first;              // publisher that was heard first
    std::set<std::string> drivers;  // whose statuses name it
    std::map<std::string, Track> tracks;
  };
  Joint* jointOf(const std::string& name);
  bool counts(const Joint& joint, const std::string& publisher) const;
  template <typename Work>
  void each(Work work);

  std::size_t most_ = 0;
  bool told_ = false;
  std::map<std::string, Joint> joints_;
};

}  // namespace mm
