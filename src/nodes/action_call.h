#pragma once
#include <actionlib/client/action_client.h>
#include <ros/callback_queue.h>
#include <ros/ros.h>

#include <chrono>
#include <cstdint>
#include <functional>
#include <mutex>
#include <string>

namespace mm {

inline constexpr double kUnheard = 2.0;  // s until a goal of which the server says nothing is lost

/// One goal at a time of an action's server, and how it ended. What the server says while the goal is still
/// being sent counts: actionlib's SimpleActionClient throws that away, and with it the end of a goal that is
/// refused at once. Hears the server in a thread of its own; every function may be called from any thread.
template <typename Action>
class ActionCall {
 public:
  using Goal = typename Action::_action_goal_type::_goal_type;
  using Result = typename Action::_action_result_type::_result_type;
  using Feedback = typename Action::_action_feedback_type::_feedback_type;
  using Heard = std::function<void(const Feedback&)>;

  /// How a goal ended.
  struct End {
    actionlib::TerminalState state = actionlib::TerminalState::LOST;
    Result result;  // as it is made where none came
  };

  /// @param news is called, from the thread that hears the server, when the goal has ended.
  ActionCall(ros::NodeHandle node, const std::string& name, std::function<void()> news = {})
      : news_(std::move(news)), client_(node, name, &queue_), hearing_(1, &queue_) {
    hearing_.start();
  }
  ~ActionCall() {
    hearing_.stop();
    forget();
  }
  ActionCall(const ActionCall&) = delete;
  ActionCall& operator=(const ActionCall&) = delete;

  /// @param most of real time: a simulated clock may run twenty times as fast. @return whether it is there.
  bool waitForServer(const ros::WallDuration& most) {
    constexpr double kLook = 0.01;  // s
    const ros::WallTime end = ros::WallTime::now() + most;
    while (!client_.isServerConnected()) {
      if (!ros::ok() || ros::WallTime::now() > end) return false;
      ros::WallDuration(kLook).sleep();
    }
    return true;
  }
  /// Whether the server listens now.
  bool isServerConnected() { return client_.isServerConnected(); }

  /// Sends a goal; the one before is no longer listened to.
  void send(const Goal& goal, Heard heard = {}) {
    std::uint64_t number = 0;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      number = ++sent_;
      ended_ = taken_ = false;
      end_ = {};
      sentAt_ = std::chrono::steady_clock::now();
    }
    Handle handle = client_.sendGoal(
        goal, [this, number](Handle h) { change(h, number); },
        [heard](const Handle&, const typename Feedback::ConstPtr& feedback) {
          if (heard && feedback) heard(*feedback);
        });
    exchange(handle);
  }
  /// Asks the server to end the goal that was sent last; nothing where none is under way.
  void cancel() {
    Handle handle = copy();
    if (!handle.isExpired()) handle.cancel();
  }
  /// Asks the server to end every goal, also those of others.
  void cancelAll() { client_.cancelAllGoals(); }
  /// The goal is not listened to any more.
  void forget() { exchange(Handle()); }

  /// Whether the goal that was sent last has ended.
  bool ended() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return ended_;
  }
  /// Whether the server has said nothing of the goal for longer than that: it went out as nobody heard it,
  /// and no end of it will come.
  bool unheard(double seconds) const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return !taken_ && std::chrono::steady_clock::now() - sentAt_ > std::chrono::duration<double>(seconds);
  }
  /// How the goal ended; lost as long as it has not.
  End end() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return end_;
  }

 private:
  using Client = actionlib::ActionClient<Action>;
  using Handle = typename Client::GoalHandle;

  void change(Handle& handle, std::uint64_t number) {
    if (handle.getCommState() == actionlib::CommState::WAITING_FOR_GOAL_ACK) return;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (number == sent_) taken_ = true;
    }
    if (handle.getCommState() != actionlib::CommState::DONE) return;
    End end;
    end.state = handle.getTerminalState();
    if (const auto result = handle.getResult()) end.result = *result;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (number != sent_) return;
      end_ = end;
      ended_ = true;
    }
    if (news_) news_();
  }
  // What ends a handle takes actionlib's lock, with which the server is heard: never inside this one.
  void exchange(const Handle& handle) {
    Handle old;  // ends after the lock
    const std::lock_guard<std::mutex> lock(handleMutex_);
    old = handle_;
    handle_ = handle;
  }
  Handle copy() const {
    const std::lock_guard<std::mutex> lock(handleMutex_);
    return handle_;
  }

  std::function<void()> news_;
  mutable std::mutex mutex_, handleMutex_;
  std::uint64_t sent_ = 0;
  bool taken_ = false, ended_ = false;
  std::chrono::steady_clock::time_point sentAt_;
  End end_;
  ros::CallbackQueue queue_;
  Client client_;
  Handle handle_;
  ros::AsyncSpinner hearing_;
};

}  // namespace mm
