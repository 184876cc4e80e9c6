#include "tools/interrupt.h"

#include <csignal>

namespace mm {
namespace {

volatile std::sig_atomic_t askedToStop = 0;

void onInterrupt(int signal) {
  askedToStop = 1;
  std::signal(signal, SIG_DFL);
}

}  // namespace

Interrupt::Interrupt() {
  askedToStop = 0;
  before_ = std::signal(SIGINT, onInterrupt);
  if (before_ == SIG_IGN) std::signal(SIGINT, SIG_IGN);  // started in the background of a script
}

Interrupt::~Interrupt() { std::signal(SIGINT, before_); }

bool Interrupt::asked() { return askedToStop != 0; }

}  // namespace mm
