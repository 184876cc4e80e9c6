#include "ros_bridge/live_session.h"

#include <ros/console.h>
#include <ros/master.h>
#include <ros/names.h>
#include <std_msgs/String.h>

#include <type_traits>

#include "base/error.h"

namespace mm {
namespace {

// Messages that wait while a session is copied: minutes of a machine's joint states at 1 kHz.
constexpr int kQueue = 100000;
constexpr std::size_t kMost = 100000;        // measurements, and values of each series, that are kept
constexpr std::int64_t kBlink = 1000000000;  // ns: contacts out of order by more are a clock that went back
const char* const kName = "the live session";

}  // namespace

LiveSession::LiveSession(ros::NodeHandle node) : node_(node), collector_(kName) {
  collector_.bound(kMost);
  collect<sensor_msgs::JointState>("joint_states", &SessionCollector::addJointState);
  collect<measuring_machine::ReferenceMeasurement>("reference", &SessionCollector::addReference);
  subscribe<measuring_machine::Artifact>(
      "artifact",
      [this](const auto& message, const std::string& publisher) { takeArtifact(message, publisher); });
  collectText("robot_description", false, &SessionCollector::addRobotDescription);
  collectText("controller_compensation", false, &SessionCollector::addCompensation);
  collectText("times_assumed", true, &SessionCollector::addTimesAssumed);
  collectText("imported_from", true, &SessionCollector::addImportedFrom);
  subscribe<measuring_machine::ProbeContact>(
      "probe/contact", [this](const auto& message, const std::string& /*publisher*/) {
        beginAgainIfBack(message);
        take([&](SessionCollector& collector) { collector.addContact(message); });
      });
  subscribers_["measure/measured"] = node_.subscribe<measuring_machine::Measured>(
      "measure/measured", 100, [this](const measuring_machine::MeasuredConstPtr& m) { takeMeasured(*m); });
  timer_ = node_.createWallTimer(ros::WallDuration(0.2), &LiveSession::findTopics, this);
}

template <typename Message, typename Heard>
void LiveSession::subscribe(const std::string& topic, Heard heard) {
  const boost::function<void(const ros::MessageEvent<const Message>&)> callback =
      [heard](const ros::MessageEvent<const Message>& event) {
        heard(*event.getConstMessage(), event.getPublisherName());
      };
  subscribers_[topic] = node_.subscribe<Message>(topic, kQueue, callback);
}

template <typename Message, typename Add>
void LiveSession::collect(const std::string& topic, Add add) {
  subscribe<Message>(topic, [this, add](const Message& message, const std::string& publisher) {
    take([&](SessionCollector& collector) {
      if constexpr (std::is_invocable_v<Add, SessionCollector&, const Message&>)
        std::invoke(add, collector, message);
      else
        std::invoke(add, collector, message, publisher);
    });
  });
}

void LiveSession::collectText(const std::string& topic, bool ofFile,
                              void (SessionCollector::*add)(const std::string&)) {
  subscribe<std_msgs::String>(topic, [=](const std_msgs::String& text, const std::string& publisher) {
    take([&](SessionCollector& collector) {
      if (ofFile) player_ = publisher;
      (collector.*add)(text.data);
    });
  });
}

void LiveSession::take(const std::function<void(SessionCollector&)>& add) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const std::size_t before = collector_.refusedCount();
  try {
    add(collector_);
  } catch (const std::exception& e) {
    if (wrong_.empty()) wrong_ = e.what();
    ROS_WARN_THROTTLE(10.0, "%s", e.what());
  }
  if (collector_.refusedCount() > before)
    ROS_WARN_THROTTLE(10.0, "set aside: %s", collector_.refused().back().c_str());
}

void LiveSession::takeMeasured(const measuring_machine::Measured& message) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!message.header.stamp.isZero() && message.header.stamp < artifact_) return;  // of the session before
  collector_.addMeasured(message);
}

// One contact with a stamp that lies behind is one bad contact, as in a bag; two of them are a clock that
// went back.
void LiveSession::beginAgainIfBack(const measuring_machine::ProbeContact& message) {
  const std::int64_t stamp = nanoseconds(message.header.stamp);
  const std::lock_guard<std::mutex> lock(mutex_);
  if (stamp == 0 || stamp >= collector_.newest() - kBlink) {
    behind_.reset();
    return;
  }
  const std::int64_t first = behind_ ? nanoseconds(behind_->header.stamp) : 0;
  if (!behind_ || stamp < first) {
    behind_ = message;
    return;
  }
  ROS_WARN("the clock went back: a new live session begins");
  collector_.dropAfter(first);
  collector_.addContact(*behind_);
  behind_.reset();
  wrong_.clear();
}

// Topics of one publisher arrive in any order: what it told of its file may be here before its artifact.
void LiveSession::takeArtifact(const measuring_machine::Artifact& message, const std::string& publisher) {
  const ros::Time stamp = message.header.stamp;
  std::unique_lock<std::mutex> lock(mutex_);
  if (!stamp.isZero() && stamp != artifact_) {
    const std::size_t before = collector_.observationCount();
    if (stamp < artifact_) collector_.dropAfter(nanoseconds(stamp));
    collector_.dropBefore(nanoseconds(stamp));
    if (publisher != player_) {
      collector_.addTimesAssumed({});
      collector_.addImportedFrom({});
    }
    wrong_.clear();
    if (before > 0) ROS_INFO("a new session begins; the %zu earlier contacts are discarded", before);
  }
  if (!stamp.isZero()) artifact_ = stamp;
  lock.unlock();
  take([&](SessionCollector& collector) { collector.addArtifact(message); });
}

void LiveSession::findTopics(const ros::WallTimerEvent&) {
  ros::master::V_TopicInfo topics;
  if (!ros::master::getTopics(topics)) return;
  const std::string temperature = node_.resolveName("temperature") + "/",
                    covariate = node_.resolveName("covariate") + "/",
                    space = ros::names::append(node_.getNamespace(), "/");
  for (const ros::master::TopicInfo& topic : topics) {
    if (subscribers_.count(topic.name) != 0) continue;
    if (topic.name.rfind(temperature, 0) == 0 && topic.datatype == "sensor_msgs/Temperature") {
      const std::string sensor = topic.name.substr(temperature.size());
      collect<sensor_msgs::Temperature>(
          topic.name, [sensor](SessionCollector& collector, const sensor_msgs::Temperature& message) {
            collector.addTemperature(sensor, message);
          });
    } else if (topic.name.rfind(covariate, 0) == 0 && topic.datatype == "measuring_machine/Covariate") {
      collect<measuring_machine::Covariate>(topic.name, &SessionCollector::addCovariate);
    } else if (topic.datatype == "measuring_machine/AxisStatus" && topic.name.rfind(space, 0) == 0) {
      collect<measuring_machine::AxisStatus>(topic.name, &SessionCollector::addStatus);
    }
  }
}

Session LiveSession::session(const Machine& fallback) const {
  SessionCollector copy(kName);
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!wrong_.empty()) throw InputError(wrong_ + "; begin a new session (measure a plan)");
    copy = collector_;
  }
  if (!copy.hasMachine()) copy.setMachine(fallback);
  return copy.build();
}

std::string LiveSession::complaint() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!wrong_.empty()) return wrong_;
  if (collector_.refusedCount() == 0) return {};
  return std::to_string(collector_.refusedCount()) + " set aside, the last: " + collector_.refused().back();
}

std::size_t LiveSession::observations() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return collector_.observationCount();
}

}  // namespace mm
