#pragma once
#include <condition_variable>
#include <cstddef>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace mm {

/// Threads that live as long as a run and share out numbered tasks; the caller's thread is one of them.
class GeneticThreads {
 public:
  /// `threads`: in total; 0 means one a core. No more than `mostTasks` are started.
  GeneticThreads(unsigned threads, std::size_t mostTasks);
  ~GeneticThreads();
  GeneticThreads(const GeneticThreads&) = delete;
  GeneticThreads& operator=(const GeneticThreads&) = delete;

  /// Calls task(0) … task(count - 1), each once, in any order, and returns when all are done.
  /// Rethrows the first exception of a task.
  void run(std::size_t count, const std::function<void(std::size_t)>& task);

 private:
  void work();
  void claimTasks(std::unique_lock<std::mutex>& lock);

  std::mutex mutex_;
  std::condition_variable wake_, done_;
  const std::function<void(std::size_t)>* task_ = nullptr;
  std::size_t next_ = 0, count_ = 0, running_ = 0;
  bool quit_ = false;
  std::exception_ptr failure_;
  std::vector<std::thread> threads_;
};

}  // namespace mm
