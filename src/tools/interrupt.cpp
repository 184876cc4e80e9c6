#include "tools/interrupt.h"

#include <unistd.h>

#include <csignal>
#include <ctime>

#include "base/error.h"

namespace mm {
namespace {

volatile std::sig_atomic_t askedToStop = 0;
timespec askedAt{};

/// Who was about to wait when Ctrl-C came would not hear of it: from then on everybody is woken once a
/// second.
void wakeAgain(int /*signal*/) { ::alarm(1); }

/// `timeout -s INT` and some shells send the signal to the program and to its group: twice at once is once.
void onInterrupt(int signal) {
  constexpr double kAtOnce = 0.5;  // s
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  if (askedToStop == 0) {
    askedAt = now;
    askedToStop = 1;
    wakeAgain(0);
    return;
  }
  const double apart = static_cast<double>(now.tv_sec - askedAt.tv_sec) +
                       1e-9 * static_cast<double>(now.tv_nsec - askedAt.tv_nsec);
  if (apart < kAtOnce) return;
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

}  // namespace

Interrupt::Interrupt() {
  askedToStop = 0;
  struct sigaction ours {
  }, theirs{};
  ours.sa_handler = onInterrupt;  // without SA_RESTART: who waits for a pipe is woken
  sigemptyset(&ours.sa_mask);
  sigaction(SIGINT, &ours, &theirs);
  before_ = theirs.sa_handler;
  ours.sa_handler = wakeAgain;
  sigaction(SIGALRM, &ours, &theirs);
  alarmBefore_ = theirs.sa_handler;
  if (before_ == SIG_IGN) std::signal(SIGINT, SIG_IGN);  // started in the background of a script
}

Interrupt::~Interrupt() {
  ::alarm(0);
  std::signal(SIGALRM, alarmBefore_);
  std::signal(SIGINT, before_);
}

bool Interrupt::asked() { return askedToStop != 0; }

void Interrupt::check() {
  if (asked()) throw Cancelled("stopped by Ctrl-C");
}

}  // namespace mm
