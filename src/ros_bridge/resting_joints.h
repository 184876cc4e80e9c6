#pragma once
#include <measuring_machine/AxisStatus.h>
#include <sensor_msgs/JointState.h>

#include <deque>
#include <map>
#include <string>

#include "machine/machine.h"

namespace mm {

/// Which joints rest, by their joint states and by what their drivers say: a joint that does not move is
/// where its states say, also where its controller latched nothing. States of another publisher than the
/// driver say nothing. Messages in the order of their stamps; forgets what is older than a few seconds.
class RestingJoints {
 public:
  /// A joint over an interval of time.
  struct Rest {
    std::string why;        // it cannot be said that it rested; empty: it did
    double position = 0.0;  // m or rad
  };

  /// Where its joints are. @param publisher its node.
  void take(const sensor_msgs::JointState& message, const std::string& publisher);
  /// Whose they are, and whether they are homed, without a fault, and move.
  void take(const measuring_machine::AxisStatus& message, const std::string& publisher);
  /// Of the states from the last before the interval to the first behind it. It rested where its driver, all
  /// the while, said that it is homed, without a fault and does not move, and these states differ by no more
  /// than the resolution. @param resolution m or rad.
  Rest over(const Joint& joint, const ros::Time& from, const ros::Time& to, double resolution) const;

 private:
  struct Position {
    ros::Time stamp;
    double value;
  };
  struct Said {
    ros::Time stamp;
    std::string why;  // it is not at rest; empty: it is
  };
  struct Track {
    std::string driver;
    std::deque<Position> positions;
    std::deque<Said> said;
  };
  std::map<std::string, Track> joints_;
};

}  // namespace mm
