#include "estimation/genetic_threads.h"

#include <algorithm>

namespace mm {

GeneticThreads::GeneticThreads(unsigned threads, std::size_t mostTasks) {
  if (threads == 0) threads = std::max(1u, std::thread::hardware_concurrency());
  const std::size_t total = std::min<std::size_t>(threads, std::max<std::size_t>(mostTasks, 1));
  for (std::size_t i = 1; i < total; ++i) threads_.emplace_back([this] { work(); });
}

GeneticThreads::~GeneticThreads() {
  {
    std::lock_guard<std::mutex> lock(mutex_);
    quit_ = true;
  }
  wake_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

void GeneticThreads::run(std::size_t count, const std::function<void(std::size_t)>& task) {
  std::unique_lock<std::mutex> lock(mutex_);
  task_ = &task;
  next_ = 0;
  count_ = count;
  failure_ = nullptr;
  if (count > 1) wake_.notify_all();
  claimTasks(lock);
  done_.wait(lock, [this] { return next_ == count_ && running_ == 0; });
  task_ = nullptr;
  if (failure_) std::rethrow_exception(failure_);
}

void GeneticThreads::work() {
  std::unique_lock<std::mutex> lock(mutex_);
  while (true) {
    wake_.wait(lock, [this] { return quit_ || next_ < count_; });
    if (quit_) return;
    claimTasks(lock);
  }
}

void GeneticThreads::claimTasks(std::unique_lock<std::mutex>& lock) {
  while (next_ < count_) {
    const std::size_t mine = next_++;
    ++running_;
    lock.unlock();
    std::exception_ptr failure;
    try {
      (*task_)(mine);
    } catch (...) {
      failure = std::current_exception();
    }
    lock.lock();
    --running_;
    if (failure) {
      if (!failure_) failure_ = failure;
      next_ = count_;
    }
  }
  if (running_ == 0) done_.notify_all();
}

}  // namespace mm
