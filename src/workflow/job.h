#pragma once
#include <atomic>
#include <chrono>
#include <functional>
#include <mutex>
#include <string>

namespace mm {

/// The one long piece of work that a server does at a time: who works, how far, and whether to cancel it.
/// Thread-safe.
class Job {
 public:
  struct State {
    std::string task, stage;  // task empty: idle
    double share = 0.0;       // of the stage, 0 to 1
    double seconds = 0.0;     // since it began
  };

  /// @param changed told after every step, from the worker's thread; may be empty.
  explicit Job(std::function<void(const State&)> changed) : changed_(std::move(changed)) {}

  /// Runs `work` in this thread. @throw InputError at once when another piece of work is running (names it
  /// and what to do), and what `work` throws.
  void run(const std::string& task, const std::function<void()>& work);
  /// For the work: tells where it is. @throw Cancelled when cancel was asked.
  void step(const std::string& stage, double share);
  /// The same without looking at cancel: for work that asks for itself.
  void tell(const std::string& stage, double share);
  /// For work that asks instead: whether cancel was asked.
  bool cancelled() const { return cancel_; }
  /// Asks the running work to stop. @return its state; an empty task: nothing runs.
  State cancel();
  State state() const;
  /// What runs, for how long, and what to do about it; empty: nothing runs.
  std::string whyBusy() const;

 private:
  std::function<void(const State&)> changed_;
  mutable std::mutex mutex_;
  State state_;
  std::chrono::steady_clock::time_point began_;
  std::atomic<bool> cancel_{false};
};

}  // namespace mm
