#pragma once
#include <actionlib/server/action_server.h>
#include <ros/node_handle.h>

#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "ros_bridge/node_support.h"
#include "workflow/job.h"

namespace mm {

/// An action whose goal is a server's one long piece of work, and ends as the service of the same name
/// answers: succeeded, aborted with the message, cancelled. A goal that comes while this action works is
/// rejected, one that comes while another task runs aborted, both with what runs and for how long; none takes
/// the place of the one before.
template <typename Action>
class JobAction {
 public:
  using Goal = typename Action::_action_goal_type::_goal_type;
  using Result = typename Action::_action_result_type::_result_type;
  using Feedback = typename Action::_action_feedback_type::_feedback_type;
  /// Fills the result, as a task of the job, in a thread of the action's; what it throws becomes
  /// success: false and a message.
  using Work = std::function<void(const Goal&, Result&)>;

  JobAction(ros::NodeHandle node, const std::string& name, Job& job, Work work)
      : name_(name),
        job_(job),
        work_(std::move(work)),
        server_(
            node, name, [this](Handle goal) { take(goal); }, [this](Handle goal) { cancel(goal); }, false),
        worker_([this] { serve(); }) {
    server_.start();
  }
  ~JobAction() {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      end_ = true;
      askToEnd();
    }
    news_.notify_all();
    worker_.join();
  }
  JobAction(const JobAction&) = delete;
  JobAction& operator=(const JobAction&) = delete;

  /// Where the job is: goes to whoever sent the goal that is under way.
  void tell(const Job::State& state) {
    Handle goal;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (!ours_) return;
      goal = *goal_;
    }
    Feedback feedback;
    feedback.stage = state.stage;
    feedback.share = state.share;
    goal.publishFeedback(feedback);
  }

 private:
  using Server = actionlib::ActionServer<Action>;
  using Handle = typename Server::GoalHandle;

  /// While the job works for the goal: only then a cancel of the goal is one of the job.
  struct Ours {
    explicit Ours(JobAction& a) : action(a) {
      const std::lock_guard<std::mutex> lock(action.mutex_);
      action.ours_ = true;
      if (action.asked_) action.job_.cancel();
    }
    ~Ours() {
      const std::lock_guard<std::mutex> lock(action.mutex_);
      action.ours_ = false;
    }
    JobAction& action;
  };

  void take(Handle goal) {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (!goal_) {
        goal_ = goal;
        asked_ = false;
        news_.notify_all();
        return;
      }
    }
    Result result;
    const std::string why = job_.whyBusy();
    result.message = why.empty() ? "'" + name_ + "' begins; wait for it, or cancel it" : why;
    goal.setRejected(result, result.message);
  }

  void serve() {
    for (;;) {
      std::unique_lock<std::mutex> lock(mutex_);
      news_.wait(lock, [this] { return end_ || goal_; });
      if (end_) return;
      Handle goal = *goal_;
      lock.unlock();
      run(goal);
    }
  }

  void run(Handle goal) {
    goal.setAccepted();
    Result result;
    answer(result, [&] {
      job_.run(name_, [&] {
        const Ours ours(*this);
        work_(*goal.getGoal(), result);
      });
    });
    bool asked;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      asked = asked_;
      goal_.reset();  // who hears of the end may send the next
    }
    if (result.success)
      goal.setSucceeded(result, result.message);
    else if (asked)
      goal.setCanceled(result, result.message);
    else
      goal.setAborted(result, result.message);
  }

  void cancel(Handle goal) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (goal_ && *goal_ == goal) askToEnd();
  }

  void askToEnd() {  // locked
    asked_ = true;
    if (ours_) job_.cancel();
  }

  const std::string name_;
  Job& job_;
  Work work_;
  std::mutex mutex_;
  std::condition_variable news_;
  std::optional<Handle> goal_;  // under way, or about to be
  bool ours_ = false, asked_ = false, end_ = false;
  Server server_;
  std::thread worker_;
};

}  // namespace mm
