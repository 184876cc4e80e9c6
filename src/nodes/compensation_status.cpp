// What the node says of itself: its status, the arrows at the tip, diagnostics.
#include <algorithm>
#include <utility>

#include "nodes/compensation_node.h"
#include "ros_bridge/correction_messages.h"
#include "ros_bridge/message_conversion.h"

namespace mm {
namespace {

constexpr double kSilent = 1.0;  // s without a joint state, on the wall clock
constexpr double kNamed = 10.0;  // s for which status and diagnostics name who is not believed

std::string wordsOf(std::string text) {
  text.erase(std::remove_if(text.begin(), text.end(), [](char c) { return c >= '+' && c <= '9'; }),
             text.end());
  return text;
}

}  // namespace

bool CompensationNode::isSilent() const {
  return heard_.isZero() || ros::WallTime::now() - heard_ > ros::WallDuration(kSilent);
}

measuring_machine::CompensationStatus CompensationNode::statusNow() {
  const std::lock_guard<std::mutex> lock(mutex_);
  measuring_machine::CompensationStatus status = status_;
  const bool silent = isSilent();
  status.calibration_id = active_.loaded ? active_.loaded->id : "";
  status.candidate_id = candidate_.loaded ? candidate_.loaded->id : "";
  if (silent)
    addWords(status.message, "no joint states are received; is the axis driver running?");
  else if (!active_.loaded && pair_->warning.empty())
    addWords(status.message, "no calibration is active; calibrate and promote one");
  else if (!active_.reason.empty())
    addWords(status.message, "nothing is published: " + active_.reason);
  else if (!withheldSince_.empty())
    addWords(status.message, "frames or contacts were withheld: " + withheldSince_);
  if (!stranger_.empty() && ros::WallTime::now() - strangerAt_ < ros::WallDuration(kNamed))
    addWords(status.message, stranger_);
  addWords(status.message, pair_->warning);
  addWords(status.message, active_.note);
  status.extrapolating = status.extrapolating && !silent;
  status.publishing = !silent && active_.loaded && inputs_.complete() && active_.reason.empty();
  if (candidate_.loaded) addWords(status.candidate_message, candidate_.reason);
  addWords(status.candidate_message, pair_->candidateWarning);
  if (status.publishing) {
    MovingState state = active_.state;
    const Correction now = active_.loaded->contacts.apply(state);
    status.sigma = now.sigma;
    if (markersOut_.getNumSubscribers() > 0 && ros::WallTime::now() >= nextMarkers_) {
      nextMarkers_ = ros::WallTime::now() + ros::WallDuration(0.2);
      markersOut_.publish(correctionMarkers(now, prefix_ + "workpiece"));
    }
    if (now.pastUnknown)
      addWords(
          status.message,
          "temperatures have not been received for long enough to evaluate effects with a time lag; sigma "
          "includes this uncertainty");
  }
  withheldSince_.clear();
  return status;
}

bool CompensationNode::isNews(bool beyond, const std::string& calibration, std::string& saidOf) {
  return !beyond || std::exchange(saidOf, calibration) != calibration;
}

void CompensationNode::look(const ros::WallTimerEvent&) {
  if (const auto pair = watch_.refresh()) install(pair);
  measuring_machine::CompensationStatus status = statusNow();
  const ros::WallTime now = ros::WallTime::now();
  // The words without their numbers: a value that moves on is no news.
  const std::string words = wordsOf(status.calibration_id) + "|" + wordsOf(status.candidate_id) + "|" +
                            wordsOf(status.message) + "|" + wordsOf(status.candidate_message);
  const bool ids =
      status.calibration_id == shown_.calibration_id && status.candidate_id == shown_.candidate_id;
  const bool same = words == words_ && ids && status.publishing == shown_.publishing;
  if (same && now < nextStatus_) return;
  if (words != words_ && !status.message.empty() && !status.publishing) {
    const bool news = isNews(status.extrapolating, status.calibration_id, statusBeyond_);
    if (std::exchange(warned_, pair_->warning) != pair_->warning || news)
      ROS_WARN("%s", status.message.c_str());
  }
  words_ = words;
  nextStatus_ = now + ros::WallDuration(1.0);
  status.header.stamp = ros::Time::now();
  shown_ = status;
  statusOut_.publish(status);
  updater_.force_update();
}

void CompensationNode::diagnose(diagnostic_updater::DiagnosticStatusWrapper& status) {
  using diagnostic_msgs::DiagnosticStatus;
  const int level = !shown_.publishing
                        ? DiagnosticStatus::ERROR
                        : (shown_.message.empty() ? DiagnosticStatus::OK : DiagnosticStatus::WARN);
  status.summary(level, shown_.message.empty() ? "correcting" : shown_.message);
  status.add("calibration", shown_.calibration_id);
  status.add("candidate", shown_.candidate_id);
  status.add("frames", shown_.frames);
  status.add("withheld", shown_.withheld);
  status.add("sigma_um", shown_.sigma * 1e6);
}

}  // namespace mm
