#include "nodes/joint_owners.h"

#include <algorithm>
#include <cmath>

#include "base/format.h"

namespace mm {
namespace {

constexpr double kGone = 10.0;  // s without a word, of an owner whose connection did not end
constexpr double kFits = 5.0;   // s between a state and its driver's status, which comes every second

bool same(const boost::weak_ptr<const void>& known, const JointOwners::Link& link) {
  return !known.owner_before(link) && !link.owner_before(known);
}

}  // namespace

JointOwners::JointOwners(std::vector<std::string> joints) {
  for (std::string& name : joints) joints_.push_back({std::move(name), "", false});
}

bool JointOwners::gone(const std::string& owner, double now) const {
  const auto found = owners_.find(owner);
  if (found == owners_.end()) return true;
  const Owner& o = found->second;
  return now - o.heard > kGone || (o.states.expired() && o.statuses.expired());
}

/// Who else owns one of the joints, in words; empty: the sender may have them all.
std::string JointOwners::rivalOf(const Sender& sender, const std::vector<int>& joints, bool byStatus,
                                 double now) const {
  for (const int j : joints) {
    const Joint& joint = joints_[j];
    if (joint.owner == sender.name || joint.owner.empty()) continue;
    if (byStatus && !joint.byStatus) continue;  // a driver that says so, before one that was first
    const bool left = gone(joint.owner, now);
    if (left && (byStatus || !joint.byStatus)) continue;
    return format("joint %s belongs to %s%s, so joint states from %s are ignored; end one of the two",
                  joint.name.c_str(), joint.owner.c_str(),
                  left ? ", which has stopped (restart this node if another one moves the joint now)" : "",
                  sender.name.c_str());
  }
  return "";
}

JointOwners::Owner& JointOwners::claim(const Sender& sender, const std::vector<int>& joints, bool byStatus,
                                       double now) {
  for (const int j : joints) {
    joints_[j].byStatus = byStatus || (joints_[j].byStatus && joints_[j].owner == sender.name);
    joints_[j].owner = sender.name;
  }
  for (auto it = owners_.begin(); it != owners_.end();) {  // who owns nothing any more
    const bool owns = std::any_of(joints_.begin(), joints_.end(),
                                  [&](const Joint& joint) { return joint.owner == it->first; });
    it = owns ? std::next(it) : owners_.erase(it);
  }
  Owner& owner = owners_[sender.name];
  owner.heard = now;
  return owner;
}

/// Why a driver's state does not fit its status; empty: it does.
std::string JointOwners::misfit(const std::string& name, const Owner& owner, const State& state) const {
  const bool otherLife =
      owner.status && state.homedAt != 0 && owner.status->homed && owner.status->homedAt != state.homedAt;
  if (!owner.status || otherLife || (owner.status->homed && owner.status->homedAt <= owner.unhomedAt))
    return "the status of " + name + " that belongs to its joint states has not arrived yet";
  const double apart = static_cast<double>(state.stamp - owner.status->stamp) * 1e-9;
  if (std::abs(apart) > kFits)
    return format("a joint state of %s is stamped %.1f s %s its status", name.c_str(), std::abs(apart),
                  apart < 0.0 ? "before" : "after");
  if (!owner.status->homed || state.stamp < owner.status->homedAt) return kUnhomed;
  return "";
}

JointOwners::Verdict JointOwners::take(const Sender& sender, const State& state,
                                       const std::vector<int>& joints, double now) {
  Verdict verdict;
  verdict.why = rivalOf(sender, joints, false, now);
  verdict.foreign = !verdict.why.empty();
  if (verdict.foreign) return verdict;
  const bool unknown =
      std::any_of(joints.begin(), joints.end(), [this](int j) { return joints_[j].owner.empty(); });
  if (unknown && now < awaited_) {
    verdict.why =
        "the status of the axis driver, which tells which node owns the joints, has not arrived yet";
    return verdict;
  }
  Owner& owner = claim(sender, joints, false, now);
  if (same(owner.states, sender.link)) {
    owner.statusLife = std::min(owner.statusLife, owner.life);
  } else {  // a driver that came up again, or a connection that broke: what it did meanwhile is not known
    ++owner.life;
    owner.states = sender.link;
    owner.first = state.stamp;
    owner.unhomedAt = owner.zero = 0;
    owner.unhomed = false;
    verdict.forget = true;
    if (owner.statusLife < owner.life) owner.status.reset();
  }
  const bool byStatus =
      std::any_of(joints.begin(), joints.end(), [this](int j) { return joints_[j].byStatus; });
  owner.unhomed = state.told && !state.homed;
  if (owner.unhomed) {
    owner.unhomedAt = state.stamp;
    verdict.why = kUnhomed;
  } else if (byStatus) {
    verdict.why = misfit(sender.name, owner, state);
  }
  const std::int64_t at = owner.unhomed        ? 0
                          : state.homedAt != 0 ? state.homedAt
                          : owner.status       ? owner.status->homedAt
                                               : 0;
  verdict.forget = verdict.forget || at != owner.zero;
  owner.zero = at;
  if (owner.status) verdict.status = &*owner.status;
  return verdict;
}

std::string JointOwners::take(const Sender& sender, const Status& status, double now) {
  if (status.joints.empty()) return "";
  const std::string rival = rivalOf(sender, status.joints, true, now);
  if (!rival.empty()) return rival;
  Owner& owner = claim(sender, status.joints, true, now);
  if (!same(owner.statuses, sender.link)) {
    owner.statuses = sender.link;
    owner.statusLife = owner.statusLife < owner.life ? owner.life : owner.life + 1;
  }
  if (owner.statusLife < owner.life && status.stamp >= owner.first) owner.statusLife = owner.life;
  if (owner.statusLife >= owner.life) owner.status = status;
  return "";
}

bool JointOwners::anyNotHomed() const {
  return std::any_of(joints_.begin(), joints_.end(), [this](const Joint& joint) {
    const auto found = owners_.find(joint.owner);
    if (found == owners_.end()) return false;
    const Owner& owner = found->second;
    return owner.unhomed || (joint.byStatus && owner.status && !owner.status->homed);
  });
}

std::int64_t JointOwners::zero() const {
  std::int64_t last = 0;
  for (const auto& [name, owner] : owners_)
    last = std::max({last, owner.zero, owner.status ? owner.status->homedAt : 0});
  return last;
}

}  // namespace mm
