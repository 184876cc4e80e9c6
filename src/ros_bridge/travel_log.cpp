#include "ros_bridge/travel_log.h"

#include <algorithm>
#include <cmath>

#include "base/erase_if.h"
#include "ros_bridge/bounded_log.h"
#include "ros_bridge/message_conversion.h"

namespace mm {
namespace {

constexpr std::size_t kMostPublishers = 20;  // of a joint, where a log is bounded

}  // namespace

template <typename Work>
void TravelLog::each(Work work) {
  for (auto& [name, joint] : joints_)
    for (auto& [publisher, track] : joint.tracks) work(track);
}

TravelLog::Joint* TravelLog::jointOf(const std::string& name) {
  const auto found = joints_.find(name);
  if (found != joints_.end()) return &found->second;
  return most_ > 0 && joints_.size() >= kMostLoggedNames ? nullptr : &joints_[name];
}

bool TravelLog::counts(const Joint& joint, const std::string& publisher) const {
  return joint.drivers.empty() ? publisher == joint.first : joint.drivers.count(publisher) > 0;
}

void TravelLog::take(const sensor_msgs::JointState& message, const std::string& publisher,
                     const Machine* machine, std::int64_t start) {
  const std::int64_t ns = nanoseconds(message.header.stamp);
  for (std::size_t i = 0; i < std::min(message.name.size(), message.position.size()); ++i) {
    const int number = machine != nullptr ? machine->findJoint(message.name[i]) : -1;
    if (machine != nullptr && number < 0) continue;  // another machine's: its clock says nothing either
    Joint* const joint = jointOf(message.name[i]);
    if (joint == nullptr) continue;
    auto found = joint->tracks.find(publisher);
    if (found == joint->tracks.end()) {
      if (most_ > 0 && joint->tracks.size() >= kMostPublishers && joint->drivers.count(publisher) == 0)
        continue;
      if (joint->tracks.empty()) joint->first = publisher;
      const JointKind kind = number < 0 ? JointKind::kLinear : machine->joints()[number].kind;
      found = joint->tracks.emplace(publisher, Track{TravelTracker(travelDeadband(kind)), {}, ns}).first;
    }
    Track& track = found->second;
    track.earliest = std::min(track.earliest, ns);
    if (i >= message.velocity.size() || std::isnan(message.velocity[i])) continue;  // nothing is guessed
    if (told_) {
      if (message.velocity[i] != 0.0) track.motions.push_back({ns, message.velocity[i] > 0.0 ? 1.0 : -1.0});
      continue;
    }
    if (!track.travel.take(ns, message.position[i], message.velocity[i])) continue;
    track.dropped += makeRoom(track.motions, most_, start, [](const Motion& m) { return m.stamp; });
    track.motions.push_back({ns, track.travel.direction()});
  }
}

void TravelLog::take(const measuring_machine::AxisStatus& message, const std::string& publisher) {
  for (const std::string& name : message.name) {
    Joint* const joint = jointOf(name);
    if (joint == nullptr || (most_ > 0 && joint->drivers.size() >= kMostPublishers)) continue;
    joint->drivers.insert(publisher);
  }
}

std::vector<TravelLog::Motion> TravelLog::motions(const std::string& name) const {
  std::vector<Motion> all;
  const auto joint = joints_.find(name);
  if (joint == joints_.end()) return all;
  for (const auto& [publisher, track] : joint->second.tracks)
    if (counts(joint->second, publisher)) all.insert(all.end(), track.motions.begin(), track.motions.end());
  std::stable_sort(all.begin(), all.end(),
                   [](const Motion& a, const Motion& b) { return a.stamp < b.stamp; });
  return all;
}

std::optional<std::int64_t> TravelLog::earliest(const std::string& name) const {
  std::optional<std::int64_t> first;
  const auto joint = joints_.find(name);
  if (joint == joints_.end()) return first;
  for (const auto& [publisher, track] : joint->second.tracks)
    if (counts(joint->second, publisher)) first = first ? std::min(*first, track.earliest) : track.earliest;
  return first;
}

std::string TravelLog::lacking() const {
  std::string text;
  for (const auto& [name, joint] : joints_)
    for (const auto& [publisher, track] : joint.tracks)
      if (track.dropped > 0 && counts(joint, publisher))
        addWords(text, std::to_string(track.dropped) + " reversals of '" + name +
                           "', the oldest of the session, have been dropped");
  return text;
}

void TravelLog::dropAfter(std::int64_t stamp) {
  each([&](Track& track) {
    eraseIf(track.motions, [&](const Motion& m) { return m.stamp >= stamp; });
    track.travel.forget();
    track.earliest = std::min(track.earliest, stamp);
  });
}

void TravelLog::dropBefore(std::int64_t stamp) {
  each([&](Track& track) {
    track.earliest = std::max(track.earliest, stamp);
    track.dropped = 0;
    std::vector<Motion>& motions = track.motions;
    if (motions.size() < 2) return;
    auto keep = motions.begin();
    while (keep + 1 != motions.end() && (keep + 1)->stamp <= stamp) ++keep;
    motions.erase(motions.begin(), keep);
  });
}

}  // namespace mm
