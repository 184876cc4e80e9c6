#include "nodes/axis_driver.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "base/error.h"
#include "ros_bridge/axis_messages.h"
#include "ros_bridge/node_support.h"

namespace mm {
namespace {

constexpr double kLongestGap = 0.1;  // s: after a longer pause of the process the motion does not jump

}  // namespace

AxisDriver::AxisDriver(ros::NodeHandle node, ros::NodeHandle own, std::shared_ptr<AxisController> controller,
                       const Machine& machine)
    : controller_(std::move(controller)), machine_(machine), updater_(node, own, ros::this_node::getName()) {
  refuseUnknownParameters(
      own, {"rate", "linear_speed", "rotary_speed", "temperature_rate", "time_factor", "clock", "hardware"});
  rate_ = numberParameter(own, "rate", 100.0, 1.0, 1000.0);
  linearSpeed_ = numberParameter(own, "linear_speed", 0.01, 1e-6, 10.0);
  rotarySpeed_ = numberParameter(own, "rotary_speed", 0.35, 1e-6, 100.0);
  temperatureRate_ = numberParameter(own, "temperature_rate", 1.0, 1e-3, 100.0);
  timeFactor_ = numberParameter(own, "time_factor", 1.0, 1e-3, 1000.0);
  clock_ = flagParameter(own, "clock", false);
  for (const std::string& axis : controller_->axes()) {
    const int joint = machine_.findJoint(axis);
    if (joint < 0)
      throw InputError("the controller moves joint '" + axis + "', which the machine does not have");
    joints_.push_back(machine_.joints()[joint]);
  }
  travel_.assign(joints_.size(), 0);
  for (const Joint& joint : joints_) trackers_.emplace_back(travelDeadband(joint.kind));
  jointsOut_ = node.advertise<sensor_msgs::JointState>("joint_states", 1000);
  statusOut_ = own.advertise<measuring_machine::AxisStatus>("status", 100, true);
  latchOut_ = own.advertise<measuring_machine::ProbeLatch>("latch", 1000);
  temperaturesOut_ = own.advertise<measuring_machine::SensorReadings>("temperatures", 100);
  if (controller_->trueTip()) truthOut_ = own.advertise<geometry_msgs::PointStamped>("truth", 1000);
  if (clock_) clockOut_ = node.advertise<rosgraph_msgs::Clock>("/clock", 1000);
  const ros::WallTime now = ros::WallTime::now();
  clockStart_ = ros::Time(now.sec, now.nsec);
  state_ = controller_->poll(0.0);
  home_ = own.advertiseService("home", &AxisDriver::home, this);
  stop_ = own.advertiseService("stop", &AxisDriver::stop, this);
  emergencyStop_ = own.advertiseService("emergency_stop", &AxisDriver::emergencyStop, this);
  updater_.setHardwareID(textParameter(own, "hardware", "simulated"));
  updater_.add("motion", this, &AxisDriver::diagnose);
  moveServer_ = std::make_unique<MoveServer>(
      own, "move", [this](const measuring_machine::MoveGoalConstPtr& goal) { executeMove(goal); }, false);
  moveServer_->start();
  thread_ = std::thread([this] { run(); });
}

AxisDriver::~AxisDriver() {
  ending_ = true;
  cycled_.notify_all();
  thread_.join();
  moveServer_->shutdown();
  const std::lock_guard<std::mutex> lock(mutex_);
  try {
    controller_->stop();
  } catch (const std::exception& e) {
    ROS_ERROR("while ending: %s", e.what());
  }
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
    cycle(clock_ ? period : std::min(gone, kLongestGap));
  }
}

void AxisDriver::cycle(double elapsed) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    try {
      const bool homed = state_.homed;
      state_ = controller_->poll(elapsed);
      lost_.clear();
      const ros::Time stamp = clock_ ? clockStart_ + ros::Duration(state_.time) : ros::Time::now();
      if (state_.homed && !homed) homedAt_ = stamp;
      if (!state_.homed) homedAt_ = ros::Time();
      const auto ns = static_cast<std::int64_t>(stamp.toNSec());
      for (std::size_t j = 0; j < travel_.size() && j < state_.position.size(); ++j) {
        const double velocity = j < state_.velocity.size() ? state_.velocity[j] : std::nan("");
        trackers_[j].take(ns, state_.position[j], velocity);
        travel_[j] = static_cast<std::int8_t>(trackers_[j].direction());
      }
      if (clock_) {
        rosgraph_msgs::Clock clock;
        clock.clock = stamp;
        clockOut_.publish(clock);
      }
      publishJoints(state_, stamp);
      publishEdges(state_, stamp);
      publishTemperatures(stamp);
      publishStatus(state_, stamp);
    } catch (const std::exception& e) {
      if (lost_ != e.what()) ROS_ERROR("controller: %s", e.what());
      lost_ = e.what();
    }
    ++cycles_;
  }
  cycled_.notify_all();
  const ros::WallTime now = ros::WallTime::now();
  if (now < nextDiagnostics_) return;
  nextDiagnostics_ = now + ros::WallDuration(1.0);
  updater_.force_update();
}

void AxisDriver::publishJoints(const AxesState& state, const ros::Time& stamp) {
  jointsOut_.publish(toJointState(controller_->axes(), state, stamp, homedAt_));
  if (!truthOut_) return;
  geometry_msgs::PointStamped truth;
  truth.header.stamp = stamp;
  truth.header.frame_id = "workpiece";
  const Eigen::Vector3d tip = controller_->trueTip().value_or(Eigen::Vector3d::Constant(std::nan("")));
  truth.point.x = tip.x();
  truth.point.y = tip.y();
  truth.point.z = tip.z();
  truthOut_.publish(truth);
}

void AxisDriver::publishEdges(const AxesState& state, const ros::Time& stamp) {
  for (const ProbeEdge& edge : controller_->takeProbeEdges()) {
    if (edge.closed && edge.probing) tripped_ = true;
    const ros::Time at = stamp - ros::Duration(state.time - edge.time);
    latchOut_.publish(toLatchMessage(edge, controller_->axes(), at, edge.probing ? feature_ : std::string()));
  }
}

void AxisDriver::publishTemperatures(const ros::Time& stamp) {
  if (stamp < nextTemperature_ && nextTemperature_ - stamp < ros::Duration(2.0 / temperatureRate_)) return;
  nextTemperature_ = stamp + ros::Duration(1.0 / temperatureRate_);
  const auto readings = controller_->temperatures();
  if (readings.empty()) return;
  measuring_machine::SensorReadings message;
  message.header.stamp = stamp;
  for (const auto& [name, value] : readings) {
    message.name.push_back(name);
    message.temperature.push_back(value);
  }
  temperaturesOut_.publish(message);
}

void AxisDriver::publishStatus(const AxesState& state, const ros::Time& stamp) {
  measuring_machine::AxisStatus status;
  status.header.stamp = stamp;
  status.homed = state.homed;
  status.homed_at = homedAt_;
  status.moving = state.moving;
  status.probing = probing_;
  status.emergency_stop = state.emergencyStop;
  status.probe_closed = state.probeClosed;
  status.unsuccessful = unsuccessful_;
  status.fault = state.fault;
  status.name = controller_->axes();
  status.travel = travel_;
  std::string text = std::to_string(state.homed + 2 * state.moving + 4 * probing_ + 8 * state.emergencyStop +
                                    16 * state.probeClosed) +
                     " " + std::to_string(unsuccessful_) + " " + state.fault;
  for (const std::int8_t direction : travel_) text += " " + std::to_string(direction);
  if (text == shown_ && stamp < nextStatus_ && nextStatus_ - stamp < ros::Duration(2.0)) return;
  shown_ = text;
  nextStatus_ = stamp + ros::Duration(1.0);
  statusOut_.publish(status);
}

void AxisDriver::diagnose(diagnostic_updater::DiagnosticStatusWrapper& status) {
  using diagnostic_msgs::DiagnosticStatus;
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!lost_.empty())
    status.summary(DiagnosticStatus::ERROR, lost_);
  else if (!state_.fault.empty())
    status.summary(DiagnosticStatus::ERROR, state_.fault);
  else if (!state_.homed)
    status.summary(DiagnosticStatus::WARN, "not homed; call ~home");
  else
    status.summary(DiagnosticStatus::OK, state_.moving ? "moving" : "at rest");
  status.add("homed", state_.homed);
  status.add("cycles", cycles_);
  status.add("late cycles", late_);
  for (std::size_t j = 0; j < joints_.size(); ++j)
    if (state_.limitSwitch.size() > j && state_.limitSwitch[j] != 0)
      status.add("limit switch", joints_[j].name + (state_.limitSwitch[j] > 0 ? " upper" : " lower"));
}

}  // namespace mm
