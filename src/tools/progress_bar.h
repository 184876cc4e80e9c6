#pragma once
#include <chrono>
#include <functional>
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
  /// To hand to a fit: a stage in words and its share. Valid as long as the bar.
  std::function<void(const std::string& stage, double share)> stages();

 private:
  std::string label_;
  bool terminal_;
  bool drawn_ = false;
  std::chrono::steady_clock::time_point last_;
};

/// What `work` returns; a bar shows how far it is, by the progress that `options` tell.
template <class Options, class Work>
auto withBar(const std::string& label, Options& options, const Work& work) {
  ProgressBar bar(label);
  options.progress = bar.stages();
  return work();
}

}  // namespace mm
