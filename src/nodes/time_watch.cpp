#include "nodes/time_watch.h"

namespace mm {
namespace {

const ros::WallDuration kStands(1.0);  // a clock of a slow simulation comes more often
constexpr double kAhead = 2.0;         // s, twice the time between two stores

}  // namespace

std::string TimeWatch::look() {
  if (ros::Time::isSystemTime()) return {};
  const ros::Time now = ros::Time::now();
  const ros::SteadyTime wall = ros::SteadyTime::now();
  if (now != last_ && !now.isZero()) {
    last_ = now;
    since_ = wall;
  }
  if (!now.isZero() && wall - since_ <= kStands) return {};
  return "ROS time stands still: /use_sim_time is true and nothing publishes /clock; start the clock, or "
         "`rosparam set /use_sim_time false` and restart this node";
}

double nextLife(double stamp, double factor) { return stamp + kAhead * factor; }

}  // namespace mm
