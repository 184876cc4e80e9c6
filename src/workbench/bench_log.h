#pragma once
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <mutex>
#include <string>
#include <thread>

namespace mm {

/// Who did what, and when: every action of the workbench, in memory and at the end of a file. The file is
/// written in a thread of its own: a disk that does not answer holds nobody up.
class BenchLog {
 public:
  BenchLog();
  ~BenchLog();  ///< when what waits is written

  /// The file in which it goes on from here; empty: in memory alone. From any thread.
  void goOnIn(const std::filesystem::path& file);
  /// From any thread, at once. What cannot be written is kept in memory all the same, and says so.
  void add(const std::string& who, const std::string& what);
  /// The latest lines as JSON, newest first.
  std::string json() const;

 private:
  struct Line {
    std::uint64_t number = 0;
    std::string time, who, what;
  };
  struct Waiting {
    Line line;
    std::filesystem::path file;
  };
  void write();
  void markUnwritten(const Waiting& lost);  ///< the caller holds the mutex

  static constexpr std::size_t kKept = 400, kMostWaiting = 4000;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::filesystem::path file_;
  std::deque<Line> lines_;
  std::deque<Waiting> waiting_;
  std::uint64_t numbers_ = 0;
  bool ending_ = false;
  std::thread writer_;
};

}  // namespace mm
