#pragma once
#include <cstddef>
#include <deque>
#include <filesystem>
#include <mutex>
#include <string>

namespace mm {

/// Who did what, and when: every action of the workbench, in memory and at the end of a file.
class BenchLog {
 public:
  /// @param file in which it goes on; empty: in memory alone.
  explicit BenchLog(std::filesystem::path file = {}) : file_(std::move(file)) {}

  /// From any thread. What cannot be written is kept in memory all the same, and says so.
  void add(const std::string& who, const std::string& what);
  /// The latest lines as JSON, newest first.
  std::string json() const;

 private:
  struct Line {
    std::string time, who, what;
  };
  static constexpr std::size_t kKept = 400;
  std::filesystem::path file_;
  mutable std::mutex mutex_;
  std::deque<Line> lines_;
};

}  // namespace mm
