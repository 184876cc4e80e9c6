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

/// Where the clock of a simulation begins, s: a driver that comes up again goes on where the one before would
/// be by now, so that no node ever sees time go back.
/// @param began when the first one began, @param now of the wall, s. @param factor simulated seconds a
/// second.
double clockStart(double began, double now, double factor);

}  // namespace mm
