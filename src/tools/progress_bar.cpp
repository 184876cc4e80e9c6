#include "tools/progress_bar.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>

#include "tools/interrupt.h"

namespace mm {

ProgressBar::ProgressBar(std::string label)
    : label_(std::move(label)), terminal_(isatty(STDERR_FILENO) == 1) {}

ProgressBar::~ProgressBar() {
  if (drawn_) std::fputs("\r\033[K", stderr);
}

void ProgressBar::show(double fraction, const std::string& note) {
  if (!terminal_) return;
  const auto now = std::chrono::steady_clock::now();
  if (drawn_ && now - last_ < std::chrono::milliseconds(100)) return;
  last_ = now;
  drawn_ = true;
  constexpr int kWidth = 30;
  const double part = std::clamp(fraction, 0.0, 1.0);
  const int full = static_cast<int>(part * kWidth);
  const std::string bar = std::string(full, '#') + std::string(kWidth - full, '.');
  std::fprintf(stderr, "\r%s [%s] %3d %% %s\033[K", label_.c_str(), bar.c_str(), static_cast<int>(100 * part),
               note.c_str());
  std::fflush(stderr);
}

ProgressCallback ProgressBar::callback() {
  return [this](double fraction) {
    Interrupt::check();
    show(fraction);
  };
}

std::function<void(const std::string&, double)> ProgressBar::stages() {
  return [this](const std::string& stage, double share) { show(share, stage); };
}

}  // namespace mm
