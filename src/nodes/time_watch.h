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

}  // namespace mm
