#pragma once

namespace mm {

/// While it lives, Ctrl-C asks the work to stop instead of ending the program; a second Ctrl-C ends it. One
/// lives from the beginning of `mm` to its end; a read that waits (a pipe) returns at once.
class Interrupt {
 public:
  Interrupt();
  ~Interrupt();
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;
  static bool asked();  ///< Ctrl-C came
  /// @throw Cancelled when Ctrl-C was pressed.
  static void check();

 private:
  void (*before_)(int);
  void (*alarmBefore_)(int);
};

}  // namespace mm
