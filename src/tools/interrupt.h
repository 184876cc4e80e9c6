#pragma once

namespace mm {

/// While it lives, Ctrl-C asks the work to stop instead of ending the program; a second Ctrl-C ends it.
class Interrupt {
 public:
  Interrupt();
  ~Interrupt();
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;
  static bool asked();  ///< Ctrl-C or SIGTERM came

 private:
  void (*before_)(int);
};

}  // namespace mm
