#include "workflow/job.h"

#include <malloc.h>

#include <cmath>

#include "base/error.h"

namespace mm {

Job::State Job::state() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  State state = state_;
  if (!state.task.empty())
    state.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - began_).count();
  return state;
}

std::string Job::whyBusy() const {
  const State now = state();
  if (now.task.empty()) return {};
  return "'" + now.task + "' has been running for " + std::to_string(std::lround(now.seconds)) + " s (" +
         (now.stage.empty() ? "begins" : now.stage) + ", " + std::to_string(std::lround(100.0 * now.share)) +
         " %); wait for it, or call cancel";
}

void Job::run(const std::string& task, const std::function<void()>& work) {
  {
    const std::string why = whyBusy();
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!state_.task.empty())
      throw InputError(why.empty() ? "'" + state_.task + "' begins; wait for it, or call cancel" : why);
    state_ = State();
    state_.task = task;
    began_ = std::chrono::steady_clock::now();
    cancel_ = false;
  }
  struct End {
    Job& job;
    ~End() {
      ::malloc_trim(
          0);  // what each thread of a diagnosis kept goes back to the system: a server runs for weeks
      {
        const std::lock_guard<std::mutex> lock(job.mutex_);
        job.state_ = State();
      }
      if (job.changed_) job.changed_(State());
    }
  } end{*this};
  step("", 0.0);
  work();
}

void Job::step(const std::string& stage, double share) {
  if (cancel_)
    throw Cancelled("cancelled" + (stage.empty() ? "" : " while " + stage) + "; nothing was changed");
  tell(stage, share);
}

void Job::tell(const std::string& stage, double share) {
  State now;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    state_.stage = stage;
    state_.share = share;
    now = state_;
  }
  if (changed_) changed_(now);
}

Job::State Job::cancel() {
  cancel_ = true;
  return state();
}

}  // namespace mm
