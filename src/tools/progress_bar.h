#pragma once
#include <chrono>
#include <string>

#include "session/progress.h"

namespace mm {

/// A progress bar on standard error when that is a terminal; nothing in a pipe or a file.
class ProgressBar {
 public:
  explicit ProgressBar(std::string label);
  ~ProgressBar();  ///< clears the line
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  /// Draws at most ten times a second. @param fraction from 0 to 1. @param note a few words behind the bar.
  void show(double fraction, const std::string& note = {});
  /// To hand to a reader or a simulation; valid as long as the bar. It throws Cancelled after Ctrl-C.
  ProgressCallback callback();

 private:
  std::string label_;
  bool terminal_;
  bool drawn_ = false;
  std::chrono::steady_clock::time_point last_;
};

}  // namespace mm
