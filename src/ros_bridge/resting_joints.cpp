#include "ros_bridge/resting_joints.h"

#include <algorithm>

#include "base/format.h"

namespace mm {
namespace {

const ros::Duration kKept(3.0);

/// Keeps the newest of those that are too old: it is what holds at the beginning.
template <typename Entry>
void append(std::deque<Entry>& entries, Entry entry) {
  if (!entries.empty() && entry.stamp < entries.back().stamp) entries.clear();  // another driver, or a replay
  entries.push_back(std::move(entry));
  while (entries.size() > 1 && entries.back().stamp - entries[1].stamp > kKept) entries.pop_front();
}

std::string motionOf(const measuring_machine::AxisStatus& status) {
  if (status.moving) return "its driver reports that it is moving";
  if (!status.homed) return "its driver reports that it is not homed";
  if (status.emergency_stop) return "its driver is in emergency stop";
  if (!status.fault.empty()) return "its driver says: " + status.fault;
  return {};
}

}  // namespace

void RestingJoints::take(const sensor_msgs::JointState& message, const std::string& publisher) {
  for (std::size_t i = 0; i < std::min(message.name.size(), message.position.size()); ++i) {
    const auto found = joints_.find(message.name[i]);
    if (found == joints_.end() || found->second.driver != publisher) continue;
    append(found->second.positions, Position{message.header.stamp, message.position[i]});
  }
}

void RestingJoints::take(const measuring_machine::AxisStatus& message, const std::string& publisher) {
  for (const std::string& name : message.name) {
    Track& track = joints_[name];
    if (track.driver != publisher) track = Track{publisher, {}, {}};
    append(track.said, Said{message.header.stamp, motionOf(message)});
  }
}

RestingJoints::Rest RestingJoints::over(const Joint& joint, const ros::Time& from, const ros::Time& to,
                                        double resolution) const {
  const auto found = joints_.find(joint.name);
  if (found == joints_.end() || found->second.positions.empty() || found->second.said.empty())
    return {"no driver reports its position"};
  const std::deque<Position>& positions = found->second.positions;
  const auto first = std::upper_bound(positions.begin(), positions.end(), from,
                                      [](const ros::Time& t, const Position& p) { return t < p.stamp; });
  const auto last = std::lower_bound(positions.begin(), positions.end(), to,
                                     [](const Position& p, const ros::Time& t) { return p.stamp < t; });
  if (last == positions.end()) return {"there is no joint state behind the contact"};
  if (first == positions.begin()) return {"there is no joint state before the contact"};
  const std::deque<Said>& said = found->second.said;
  if (said.front().stamp > from) return {"its driver sent nothing before the contact"};
  for (std::size_t i = 0; i < said.size() && said[i].stamp <= to; ++i)
    if ((i + 1 == said.size() || said[i + 1].stamp > from) && !said[i].why.empty()) return {said[i].why};
  const auto [least, most] = std::minmax_element(
      first - 1, last + 1, [](const Position& a, const Position& b) { return a.value < b.value; });
  if (!(most->value - least->value <= resolution))
    return {format("it moved by %.3g %s in the %.0f ms around it", 1e6 * (most->value - least->value),
                   joint.kind == JointKind::kRotary ? "urad" : "um",
                   1e3 * (last->stamp - (first - 1)->stamp).toSec())};
  return {{}, 0.5 * (least->value + most->value)};
}

}  // namespace mm
