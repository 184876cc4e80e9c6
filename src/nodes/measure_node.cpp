#include "nodes/measure_node.h"

#include <chrono>
#include <filesystem>

#include "base/requested_file.h"
#include "interpreters/loaded_compensation.h"
#include "ros_bridge/message_conversion.h"
#include "ros_bridge/node_support.h"
#include "session/plan_ways.h"
#include "session/trial_block.h"

namespace mm {
namespace {

const ros::WallDuration kShortWait(0.02);  // s between looks at pause and cancel

}  // namespace

MeasureNode::MeasureNode(ros::NodeHandle node, ros::NodeHandle own, const Machine& machine)
    : machine_(machine),
      prefix_(framePrefix(own)),
      take_(node, "axis_driver/take"),
      updater_(node, own, ros::this_node::getName()),
      axes_(node, "axis_driver/move", [this] { tellWaiting(); }),
      server_(
          own, "run", [this](const measuring_machine::MeasureGoalConstPtr& goal) { execute(goal); }, false) {
  refuseUnknownParameters(
      own, {"retries", "give_up", "contact_timeout", "release_timeout", "frame_prefix", "compensation"});
  retries_ = static_cast<int>(numberParameter(own, "retries", 2, 0, 100));
  giveUp_ = static_cast<int>(numberParameter(own, "give_up", 3, 1, 1000));
  contactTimeout_ = numberParameter(own, "contact_timeout", 1.0, 0.01, 100.0);
  releaseTimeout_ = numberParameter(own, "release_timeout", 2.0, 0.01, 100.0);
  compensation_ = statedCompensation("~compensation", own.param<std::string>("compensation", ""));
  statusIn_ = hear<measuring_machine::AxisStatus>(node, "axis_driver/status", 100,
                                                  [this](const auto& message) { status_ = message; });
  motionIn_ = hear<measuring_machine::MotionStatus>(node, "axis_driver/motion", 100,
                                                    [this](const auto& message) { motion_ = message; });
  artifactOut_ = node.advertise<measuring_machine::Artifact>("artifact", 10, true);
  compensationOut_ = node.advertise<std_msgs::String>("controller_compensation", 10, true);
  measuredOut_ = own.advertise<measuring_machine::Measured>("measured", 10, true);
  descriptionOut_ = node.advertise<std_msgs::String>("robot_description", 10, true);
  contactIn_ = hear<measuring_machine::ProbeContact>(node, "probe/contact", 1000,
                                                     [this](const auto&) { ++contacts_; });
  pause_ = offer<std_srvs::SetBool>(own, "pause", [this](auto& request, auto& response) {
    paused_ = request.data;
    response.message = paused_ ? "pauses after the current move" : "continues";
  });
  renewIn_ = offer<std_srvs::Trigger>(own, "renew", [this](auto&, auto&) {
    const std::lock_guard<std::mutex> lock(mutex_);
    renewed_ = Wall::now();
  });
  updater_.setHardwareID("measure");
  updater_.add("plan", this, &MeasureNode::diagnose);
  timer_ =
      node.createWallTimer(ros::WallDuration(0.5), [this](const ros::WallTimerEvent&) { updater_.update(); });
  server_.registerPreemptCallback([this] { cancel_ = true; });
  renewer_ = std::thread([this] { renewAll(); });
  server_.start();
}

template <typename Message, typename Take>
ros::Subscriber MeasureNode::hear(ros::NodeHandle& node, const std::string& topic, std::uint32_t queue,
                                  Take take) {
  return node.subscribe<Message>(topic, queue, [this, take](const typename Message::ConstPtr& message) {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      take(*message);
    }
    contact_.notify_all();
  });
}

void MeasureNode::tellWaiting() {
  { const std::lock_guard<std::mutex> lock(mutex_); }  // whoever looks now sleeps before it is told
  contact_.notify_all();
}

// The axes stop with the lease, before anything else ends.
MeasureNode::~MeasureNode() {
  ending_ = true;
  giveAxes();
  contact_.notify_all();
  server_.shutdown();
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    over_ = true;
  }
  contact_.notify_all();
  renewer_.join();
}

void MeasureNode::diagnose(diagnostic_updater::DiagnosticStatusWrapper& status) {
  using diagnostic_msgs::DiagnosticStatus;
  const std::lock_guard<std::mutex> lock(saidMutex_);
  if (running_)
    status.summary(blockedWays_.empty() ? DiagnosticStatus::OK : DiagnosticStatus::WARN,
                   (paused_ ? "paused" : "measuring") + (blockedWays_.empty() ? "" : "; " + blockedWays_));
  else
    status.summary(failed_ ? DiagnosticStatus::ERROR : DiagnosticStatus::OK,
                   said_.empty() ? "ready" : "the last plan: " + said_);
  status.add("move", move_);
  status.add("moves", moves_);
  status.add("retries", retried_.load());
}

Plan MeasureNode::loadPlan(const std::string& plan) const {
  if (plan.empty()) throw InputError("the goal names no plan; give the path of a plan file, or its text");
  if (plan.find('\n') != std::string::npos)
    return Plan::parse(plan, "plan of the goal", std::filesystem::current_path(), machine_);
  return Plan::load(requestedYaml(plan, "plan"), machine_);
}

// Before anything moves, while somebody may still be there to stop it.
void MeasureNode::sayBlockedWays(const Plan& plan) {
  const std::string ways = blockedWaysText(plan, blockedWays(plan, machine_));
  if (ways.empty()) return;
  ROS_WARN("%s", ways.c_str());
  const std::lock_guard<std::mutex> lock(saidMutex_);
  blockedWays_ = ways;
}

void MeasureNode::announce(const Plan& plan, bool again) {
  descriptionOut_.publish(toText(machine_.urdf()));
  compensationOut_.publish(toText(compensationJson(compensation_)));
  measuring_machine::Artifact artifact = toMessage(plan.artifact);
  // A plan that goes on belongs to the session that it began, by this node or by the one before it.
  if (!again || plan.text != announcedPlan_) {
    announced_ = again ? ros::Time() : ros::Time::now();
    measured_ = 0;
  }
  announcedPlan_ = plan.text;
  artifact.header.stamp = announced_;
  artifact.header.frame_id = prefix_ + artifact.header.frame_id;
  artifactOut_.publish(artifact);
  tellMeasured();
}

void MeasureNode::tellMeasured() {
  measuring_machine::Measured measured;
  measured.header.stamp = announced_;
  measured.contacts = measured_;
  measuredOut_.publish(measured);
}

void MeasureNode::execute(const measuring_machine::MeasureGoalConstPtr& goal) {
  measuring_machine::MeasureResult result;
  feedback_ = {};
  paused_ = false;
  stand_.clear();
  retried_ = left_ = 0;
  const auto fill = [&](const std::string& message, bool failed = false) {
    result.contacts = feedback_.contacts;
    result.missed = feedback_.missed;
    result.next = feedback_.move;
    result.message = message;
    const std::lock_guard<std::mutex> lock(saidMutex_);
    said_ = message;
    failed_ = failed;
    running_ = false;
  };
  {
    const std::lock_guard<std::mutex> lock(saidMutex_);
    running_ = true;
    blockedWays_.clear();
  }
  if (server_.isPreemptRequested()) cancel_ = true;  // asked for before the goal's turn had come
  try {
    const Plan plan = loadPlan(goal->plan);
    for (const PlanMove& move : plan.moves)
      if (byInstrument(move.kind))
        throw InputError(
            plan.source + ":" + std::to_string(move.line) +
            ": needs an independent instrument, which this node does not have; use `mm simulate`, "
            "or publish /reference from the instrument's own node");
    if (goal->first >= plan.moves.size())
      throw InputError("'first' is " + std::to_string(goal->first) + "; the plan has moves 0 to " +
                       std::to_string(plan.moves.size() - 1));
    sayBlockedWays(plan);
    if (!axes_.waitForServer(ros::WallDuration(5.0)))
      throw Error("the axis driver does not answer; is the node axis_driver running?");
    if (!(goal->lease == 0.0 || (goal->lease >= 0.1 && goal->lease <= 60.0)))
      throw InputError("'lease' is " + std::to_string(goal->lease) + "; it must be 0, or from 0.1 to 60");
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      lease_ = goal->lease;
      renewed_ = Wall::now();
    }
    takeAxes(plan.name.empty() ? plan.source : plan.name);
    struct Give {
      MeasureNode& node;
      ~Give() { node.giveAxes(); }
    } const give{*this};
    requireOpenProbe("before the plan");
    announce(plan, goal->first > 0);
    runFrom(plan, goal->first);
    fill("done" + retriesInWords());
    server_.setSucceeded(result);
  } catch (const Cancelled&) {
    fill("cancelled before move " + std::to_string(feedback_.move));
    server_.setPreempted(result, result.message);
  } catch (const std::exception& e) {
    ROS_ERROR("measurement ended: %s", e.what());
    fill(e.what() + retriesInWords(), true);
    server_.setAborted(result, result.message);
  }
  cancel_ = false;  // the next goal's turn comes after this
}

void MeasureNode::runFrom(const Plan& plan, std::size_t first) {
  int inARow = 0;
  for (std::size_t m = first; m < plan.moves.size(); ++m) {
    const PlanMove& move = plan.moves[m];
    tell(plan, m);
    askFor(plan, move);
    holdWhilePaused();
    if (move.kind == MoveKind::kGo) {
      drive(plan, measuring_machine::MoveGoal::GO, move.position, move.speed, {});
      pauseFor(move.wait);
      continue;
    }
    if (measure(plan, move)) {
      inARow = 0;
      continue;
    }
    ++feedback_.missed;
    if (++inARow >= giveUp_)
      throw Error(plan.source + ":" + std::to_string(move.line) + ": " + std::to_string(inARow) +
                  " measurements in a row without a contact (last: '" + feedback_.feature +
                  "'); check the probe and the position of the artifact");
  }
  feedback_.move = static_cast<std::uint32_t>(plan.moves.size());
  feedback_.progress = 1.0;
  server_.publishFeedback(feedback_);
}

bool MeasureNode::waitForArrival(double wallSeconds) {
  std::unique_lock<std::mutex> lock(mutex_);
  return contact_.wait_for(lock, std::chrono::duration<double>(wallSeconds),
                           [this] { return axes_.ended(); });
}

void MeasureNode::pauseFor(double seconds) {
  const ros::Time end = ros::Time::now() + ros::Duration(seconds);
  while (seconds > 0.0 && ros::Time::now() < end) {
    goOn();
    keepLease();
    kShortWait.sleep();
  }
}

void MeasureNode::holdWhilePaused() {
  while (paused_) {
    goOn();
    keepLease();
    kShortWait.sleep();
    if (feedback_.paused) continue;
    feedback_.paused = true;
    server_.publishFeedback(feedback_);
  }
  feedback_.paused = false;
}

void MeasureNode::askFor(const Plan& plan, const PlanMove& move) {
  const std::string stand = plan.standText(move);
  placement_ = plan.placements.empty() ? "" : plan.placements[static_cast<std::size_t>(move.placement)].name;
  stylus_ =
      plan.artifact.styli.empty() ? "" : plan.artifact.styli[static_cast<std::size_t>(move.stylus)].name;
  if (stand == stand_) return;
  const bool first = stand_.empty();
  stand_ = stand;
  const bool trial = trialBlock(placement_).has_value();
  if (first && !trial) return;  // as it stands when a plan begins
  feedback_.asks = (trial ? "switch to " : "set up ") + stand + ", then continue";
  ROS_INFO("%s", feedback_.asks.c_str());
  paused_ = true;
  holdWhilePaused();
  feedback_.asks.clear();
}

void MeasureNode::tell(const Plan& plan, std::size_t move) {
  feedback_.move = static_cast<std::uint32_t>(move);
  feedback_.moves = static_cast<std::uint32_t>(plan.moves.size());
  const int feature = plan.moves[move].feature;
  feedback_.feature = feature >= 0 ? plan.artifact.features[feature].name : std::string();
  feedback_.progress = static_cast<double>(move) / static_cast<double>(plan.moves.size());
  server_.publishFeedback(feedback_);
  const std::lock_guard<std::mutex> lock(saidMutex_);
  move_ = feedback_.move;
  moves_ = feedback_.moves;
}

std::uint64_t MeasureNode::contactsSeen() {
  const std::lock_guard<std::mutex> lock(mutex_);
  return contacts_;
}

bool MeasureNode::waitForContact(std::uint64_t before) {
  std::unique_lock<std::mutex> lock(mutex_);
  // By both clocks: simulated time may run faster than messages travel.
  const ros::Time end = ros::Time::now() + ros::Duration(contactTimeout_);
  const ros::WallTime wallEnd = ros::WallTime::now() + ros::WallDuration(contactTimeout_);
  while (contacts_ == before && ros::ok() && motion_ && motion_->stops == stopsBefore_ &&
         (ros::Time::now() < end || ros::WallTime::now() < wallEnd))
    contact_.wait_for(lock, std::chrono::milliseconds(20));
  return contacts_ != before;
}

}  // namespace mm
