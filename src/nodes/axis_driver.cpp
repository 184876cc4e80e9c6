#include "nodes/axis_driver.h"

#include <ros/master.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "base/error.h"
#include "ros_bridge/node_support.h"
#include "session/csv_cells.h"

namespace mm {
namespace {

constexpr double kLongestGap = 0.1;  // s: after a longer pause of the process the motion does not jump

std::vector<std::vector<std::string>> stagesOf(const std::string& text) {
  std::vector<std::vector<std::string>> stages;
  for (const std::string_view stage : wordsIn(text, ";")) {
    const std::vector<std::string_view> names = wordsIn(stage);
    stages.emplace_back(names.begin(), names.end());
  }
  return stages;
}

MotionControl::Settings controlSettings(const ros::NodeHandle& own, bool clock) {
  refuseUnknownParameters(
      own, {"rate",          "linear_speed", "rotary_speed", "temperature_rate", "time_factor",
            "clock",         "hardware",     "tolerance",    "rotary_tolerance", "silence",
            "late",          "rest_timeout", "hold_limit",   "homing_order",     "probe_settle",
            "probe_longest", "probe_stuck",  "silent_moves", "frame_prefix",     "clock_next"});
  MotionControl::Settings settings;
  settings.tolerance = numberParameter(own, "tolerance", settings.tolerance, 1e-9, 1e-2);
  settings.rotaryTolerance = numberParameter(own, "rotary_tolerance", settings.rotaryTolerance, 1e-9, 0.1);
  settings.silence = numberParameter(own, "silence", settings.silence, 0.05, 60.0);
  settings.late = numberParameter(own, "late", settings.late, 0.02, 60.0);
  settings.restTimeout = numberParameter(own, "rest_timeout", settings.restTimeout, 0.05, 600.0);
  settings.holdLimit = numberParameter(own, "hold_limit", settings.holdLimit, 0.1, 86400.0);
  ProbeDebounce::Settings& probe = settings.probe;
  probe.settle = numberParameter(own, "probe_settle", probe.settle, 0.0, 1.0);
  probe.longest = numberParameter(own, "probe_longest", probe.longest, probe.settle, 10.0);
  probe.stuck = numberParameter(own, "probe_stuck", probe.stuck, 0.1, 3600.0);
  settings.silentMoves =
      static_cast<unsigned>(numberParameter(own, "silent_moves", settings.silentMoves, 1, 1000));
  settings.homingOrder = stagesOf(textParameter(own, "homing_order", ""));
  settings.simulatedTime = clock;
  return settings;
}

/// Publishes a status where it says something else than the last one, and every second.
template <typename Status>
void publishNews(const ros::Publisher& out, const Status& status, Status& last) {
  const ros::Time stamp = status.header.stamp, next = last.header.stamp + ros::Duration(1.0);
  Status same = last;
  same.header = status.header;
  if (same == status && stamp < next && next - stamp < ros::Duration(2.0)) return;
  last = status;
  out.publish(status);
}

}  // namespace

AxisDriver::AxisDriver(ros::NodeHandle node, ros::NodeHandle own, std::shared_ptr<AxisController> controller,
                       const Machine& machine)
    : machine_(machine),
      prefix_(framePrefix(own)),
      clock_(flagParameter(own, "clock", false)),
      controller_(std::move(controller)),
      control_(controller_, machine_, controlSettings(own, clock_)),
      holdSpinner_(1, &holdQueue_),
      leaseSpinner_(1, &leaseQueue_),
      updater_(node, own, ros::this_node::getName()) {
  rate_ = numberParameter(own, "rate", 100.0, 1.0, 1000.0);
  linearSpeed_ = numberParameter(own, "linear_speed", 0.01, 1e-6, 10.0);
  rotarySpeed_ = numberParameter(own, "rotary_speed", 0.35, 1e-6, 100.0);
  temperatureRate_ = numberParameter(own, "temperature_rate", 1.0, 1e-3, 100.0);
  timeFactor_ = numberParameter(own, "time_factor", 1.0, 1e-3, 1000.0);
  travel_.assign(control_.axes().size(), 0);
  for (const Joint& joint : control_.joints()) {
    trackers_.emplace_back(travelDeadband(joint.kind));
    axisHomed_.push_back(false);
  }
  jointsOut_ = node.advertise<sensor_msgs::JointState>("joint_states", 1000);
  statusOut_ = own.advertise<measuring_machine::AxisStatus>("status", 100, true);
  motionOut_ = own.advertise<measuring_machine::MotionStatus>("motion", 100, true);
  latchOut_ = own.advertise<measuring_machine::ProbeLatch>("latch", 1000);
  temperaturesOut_ = own.advertise<measuring_machine::SensorReadings>("temperatures", 100);
  if (controller_->trueTip()) truthOut_ = own.advertise<geometry_msgs::PointStamped>("truth", 1000);
  if (clock_) {
    clockOut_ = node.advertise<rosgraph_msgs::Clock>("/clock", 1000);
    clockStart_ = ros::Time(numberParameter(own, "clock_next", ros::WallTime::now().toSec(), 0.0, 4e9));
    clockSaid_ = clockStart_.toSec();
    tellNextLife();
    clockTimer_ =
        node.createWallTimer(ros::WallDuration(1.0), [this](const ros::WallTimerEvent&) { tellNextLife(); });
  }
  advertise(own);
  updater_.setHardwareID(textParameter(own, "hardware", "simulated"));
  updater_.add("motion", this, &AxisDriver::diagnose);
  updater_.add("probe", this, &AxisDriver::diagnoseProbe);
  moveServer_ = std::make_unique<MoveServer>(
      own, "move", [this](Goal goal) { takeGoal(goal); }, [this](Goal goal) { cancelGoal(goal); }, false);
  moveServer_->start();
  homeServer_ = std::make_unique<HomeServer>(
      own, "home", [this](HomeServer::GoalHandle goal) { takeHoming(goal); },
      [this](HomeServer::GoalHandle) { homingCancelled_ = true; }, false);
  homeServer_->start();
  watchListeners(own);
  for (const std::string& note : control_.capabilities().notes) ROS_INFO("controller: %s", note.c_str());
  thread_ = std::thread([this] { run(); });
  mover_ = std::thread([this] { moveAll(); });
  homer_ = std::thread([this] { homeAll(); });
  holdSpinner_.start();
  leaseSpinner_.start();
  stops_->begin();
}

AxisDriver::~AxisDriver() {
  if (!control_.shutDown("the end of the driver"))
    ROS_ERROR("the driver is shutting down: stop was sent, but it is unknown whether the axes have stopped");
  {
    const std::lock_guard<std::mutex> lock(goals_);
    ending_ = true;
  }
  control_.end();
  asked_.notify_all();
  stops_.reset();
  holdSpinner_.stop();
  leaseSpinner_.stop();
  mover_.join();
  homer_.join();
  thread_.join();
}

void AxisDriver::run() {
  using Clock = std::chrono::steady_clock;
  const double period = 1.0 / rate_;
  const auto wait = std::chrono::duration_cast<Clock::duration>(
      std::chrono::duration<double>(period / (clock_ ? timeFactor_ : 1.0)));
  auto last = Clock::now(), next = last + wait;
  while (!ending_) {
    std::this_thread::sleep_until(next);
    const auto now = Clock::now();
    next += wait;
    if (next < now) {  // late: catches up, but after a long pause it goes on from here
      ++late_;
      if (clock_ || now - next > std::chrono::milliseconds(50)) next = now + wait;
    }
    const double gone = std::chrono::duration<double>(now - last).count();
    last = now;
    if (gone > kLongestGap) control_.paused(gone);
    cycle(clock_ ? period : std::min(gone, kLongestGap));
  }
}

// Not by setParam, which waits for a master that has gone.
void AxisDriver::tellNextLife() {
  XmlRpc::XmlRpcValue told, answer, payload;
  told[0] = ros::this_node::getName();
  told[1] = ros::this_node::getName() + "/clock_next";
  told[2] = nextLife(clockSaid_, timeFactor_);
  ros::master::execute("setParam", told, answer, payload, false);
}

ros::Time AxisDriver::stampOf(double controllerTime, double host) const {
  return clock_ ? clockStart_ + ros::Duration(controllerTime) : ros::Time(host);
}

void AxisDriver::cycle(double elapsed) {
  try {
    if (!clock_) control_.forbid(time_.look());
    std::optional<MotionControl::Observation> seen =
        control_.cycle(elapsed, clock_ ? 0.0 : ros::Time::now().toSec());
    const MotionControl::View view = control_.view();
    if (view.fault != faultSaid_ && view.lost.empty() && !view.fault.empty())
      ROS_WARN("nothing moves: %s", view.fault.c_str());
    faultSaid_ = view.fault;
    if (!view.lost.empty() && lostSaid_.empty()) ROS_ERROR("controller: %s", view.lost.c_str());
    if (view.lost.empty() && !lostSaid_.empty()) ROS_INFO("controller: responds again");
    lostSaid_ = view.lost;
    if (view.probe != probeSaid_) {
      if (!view.probe.empty()) ROS_WARN("%s", view.probe.c_str());
      nextDiagnostics_ = {};
    }
    probeSaid_ = view.probe;
    ros::Time stamp = clock_ ? lastStamp_ : ros::Time::now();
    if (seen) stamp = stampOf(seen->state.time, seen->host);
    // Joint states and status say the same, whatever the controller believes: that there is a zero, from the
    // first state that is published with it.
    if (!view.state.homed)
      homedAt_ = ros::Time();
    else if (homedAt_.isZero() && seen && stamp > lastStamp_)
      homedAt_ = stamp;
    if (seen) seen->state.homed = !homedAt_.isZero();
    if (seen) {
      if (clock_) {
        rosgraph_msgs::Clock clock;
        clock.clock = stamp;
        clockOut_.publish(clock);
        clockSaid_ = stamp.toSec();
      }
      const auto ns = static_cast<std::int64_t>(stamp.toNSec());
      for (std::size_t j = 0; j < travel_.size(); ++j) {
        if (seen->state.axisHomed[j] && !axisHomed_[j]) trackers_[j].countAnew();
        axisHomed_[j] = seen->state.axisHomed[j];
        trackers_[j].take(ns, seen->state.position[j], seen->state.velocity[j]);
        travel_[j] = static_cast<std::int8_t>(trackers_[j].direction());
      }
      for (const ProbeEdge& trip : seen->trips) publishLatch(trip, trip.probing ? probed() : Meant());
      if (stamp > lastStamp_) publishJoints(*seen, stamp);
      publishTemperatures(stamp);
      lastStamp_ = std::max(stamp, lastStamp_);
    }
    publishStatus(view, stamp);
    publishMotion(view, stamp);
  } catch (const std::exception& e) {
    ROS_ERROR_THROTTLE(1.0, "axis driver: %s", e.what());
  }
  ++cycles_;
  const ros::WallTime now = ros::WallTime::now();
  if (now < nextDiagnostics_) return;
  nextDiagnostics_ = now + ros::WallDuration(1.0);
  updater_.force_update();
}

void AxisDriver::publishJoints(const MotionControl::Observation& seen, const ros::Time& stamp) {
  jointsOut_.publish(toJointState(control_.axes(), seen.state, stamp, prefix_));
  if (!truthOut_) return;
  geometry_msgs::PointStamped truth;
  truth.header.stamp = stamp;
  truth.header.frame_id = prefix_ + "workpiece";
  const std::array<double, 3> tip =
      controller_->trueTip().value_or(std::array<double, 3>{std::nan(""), std::nan(""), std::nan("")});
  truth.point.x = tip[0];
  truth.point.y = tip[1];
  truth.point.z = tip[2];
  truthOut_.publish(truth);
}

Meant AxisDriver::probed() {
  const std::lock_guard<std::mutex> lock(goals_);
  return meant_;
}

bool AxisDriver::latchLaser(const Meant& meant) {
  const std::optional<ProbeEdge> reading = control_.readLaser();
  if (reading) publishLatch(*reading, meant);
  return reading.has_value();
}

void AxisDriver::publishLatch(const ProbeEdge& edge, const Meant& meant) {
  const ros::Time stamp = stampOf(edge.time, control_.toHost(edge.time));
  measuring_machine::ProbeLatch latch = toLatchMessage(edge, control_.axes(), stamp, meant);
  latch.header.frame_id = prefix_ + latch.header.frame_id;
  latchOut_.publish(latch);
}

void AxisDriver::publishTemperatures(const ros::Time& stamp) {
  if (stamp < nextTemperature_ && nextTemperature_ - stamp < ros::Duration(2.0 / temperatureRate_)) return;
  nextTemperature_ = stamp + ros::Duration(1.0 / temperatureRate_);
  const auto readings = control_.temperatures();
  if (readings.empty()) return;
  measuring_machine::SensorReadings message;
  message.header.stamp = stamp;
  for (const auto& [name, value] : readings) {
    message.name.push_back(name);
    message.temperature.push_back(value);
  }
  temperaturesOut_.publish(message);
}

void AxisDriver::publishStatus(const MotionControl::View& view, const ros::Time& stamp) {
  measuring_machine::AxisStatus status;
  status.header.stamp = stamp;
  status.homed = !homedAt_.isZero();
  status.homed_at = homedAt_;
  status.moving = view.state.moving;
  status.probing = view.probing;
  status.emergency_stop = view.state.emergencyStop;
  status.probe_closed = view.state.probeClosed;
  status.unsuccessful = view.unsuccessful;
  status.fault = view.fault;
  status.name = control_.axes();
  status.travel = travel_;
  publishNews(statusOut_, status, shown_);
}

void AxisDriver::publishMotion(const MotionControl::View& view, const ros::Time& stamp) {
  measuring_machine::MotionStatus status;
  status.header.stamp = stamp;
  status.owner = control_.owner().owner();
  status.stops = view.stops;
  status.stopped_by = view.stoppedBy;
  status.homing = view.homing;
  status.held = view.state.held;
  status.feed_override = view.state.feedOverride;
  status.lost = !view.lost.empty();
  status.resets = view.state.resets;
  status.alarm_code = view.state.alarm.code;
  status.alarm = view.state.alarm.text;
  status.remedy = view.state.alarm.remedy;
  status.late = view.late;
  shownMotion_.late = status.late;  // alone it is no news
  publishNews(motionOut_, status, shownMotion_);
}

void AxisDriver::diagnose(diagnostic_updater::DiagnosticStatusWrapper& status) {
  using diagnostic_msgs::DiagnosticStatus;
  const MotionControl::View view = control_.view();
  if (!view.fault.empty())
    status.summary(DiagnosticStatus::ERROR, view.lost.empty() ? view.fault : view.lost);
  else if (!view.state.homed)
    status.summary(DiagnosticStatus::WARN, "not homed; call ~home");
  else if (view.late > 0.1)
    status.summary(DiagnosticStatus::WARN, "the controller's states arrive late");
  else
    status.summary(DiagnosticStatus::OK, view.state.moving ? "moving" : "at rest");
  status.add("homed", view.state.homed);
  status.add("owner", control_.owner().owner());
  status.add("cycles", cycles_.load());
  status.add("late cycles", late_.load());
  status.add("states late by (s)", view.late);
  for (std::size_t j = 0; j < control_.joints().size(); ++j)
    if (view.state.limitSwitch.size() > j && view.state.limitSwitch[j] != 0)
      status.add("limit switch",
                 control_.joints()[j].name + (view.state.limitSwitch[j] > 0 ? " upper" : " lower"));
  for (const std::string& note : control_.capabilities().notes) status.add("note", note);
}

void AxisDriver::diagnoseProbe(diagnostic_updater::DiagnosticStatusWrapper& status) {
  using diagnostic_msgs::DiagnosticStatus;
  const MotionControl::View view = control_.view();
  status.summary(view.probe.empty() ? DiagnosticStatus::OK : DiagnosticStatus::ERROR,
                 view.probe.empty() ? "ready" : view.probe);
  status.add("bounces swallowed", view.bounces);
  status.add("closings that did not last", view.jolts);
  status.add("switch", view.state.probeClosed ? "closed" : "open");
}

}  // namespace mm
