#pragma once
#include <ros/time.h>

#include <string>

namespace mm {

/// Says when the time of ROS stands still: `/use_sim_time` is true, and nobody makes the clock. One thread.
class TimeWatch {
 public:
  /// To be called again and again. @return what is wrong, for people; empty: the time goes on.
  std::string look();

 private:
  ros::Time last_;
  ros::SteadyTime since_;  // when it last went on
};

/// Where the clock of a simulation goes on when its driver comes up again, s: beyond all that is said before
/// this is told anew, a second later, so that no node ever sees time go back.
/// @param stamp said last, s. @param factor simulated seconds a second.
double nextLife(double stamp, double factor);

}  // namespace mm
