#pragma once
#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "drivers/device_child.h"

namespace mm {

inline constexpr double kLinkConnect = 3.0;  // s for a connection, and for the first answers
inline constexpr double kLinkSilence = 0.6;  // s without an answer: lost
inline constexpr double kLinkBeat = 0.05;    // s between signs of life to a program that stops what moves
inline constexpr int kLinkDamaged = 20;      // lines in a row that are not the control's language: lost

/// s on the host's steady clock: the one on which lines are stamped.
double steadySeconds();

/// Lines of text to and from a device on a serial line or a TCP port, or a program that speaks for it. A
/// thread of its own reads; whoever writes does not wait: what the device does not take at once is an error.
class DeviceLink {
 public:
  /// Told of each line without its end, and when its last byte came (s, steady clock); in the link's thread.
  using LineHandler = std::function<void(const std::string& line, double time)>;

  /// @param address `tcp:<host>:<port>`, or `serial:<device>` with `:<baud>` behind it (115200), or the
  /// device's path alone.
  /// @throw InputError naming what is wrong with it.
  DeviceLink(std::string address, LineHandler handler);
  /// To a program that each connection starts and whose standard input and output the lines are.
  /// @param address what it is called, for people. @param program its path, and arguments.
  DeviceLink(std::string address, std::vector<std::string> program, LineHandler handler);
  ~DeviceLink();
  DeviceLink(const DeviceLink&) = delete;
  DeviceLink& operator=(const DeviceLink&) = delete;

  /// @param timeout s. @param lent of this process, for a program, as its descriptor 3.
  /// @throw Error naming the address and why.
  void connect(double timeout, int lent = -1);
  int descriptor() const;  ///< of the connection; -1: there is none
  void close();            ///< not from the handler
  bool connected() const { return connected_; }
  /// Why the connection ended, for people; empty: it has not.
  std::string lost() const;
  /// From any thread; never waits. @throw Error when there is no connection, or the device takes nothing.
  void write(const std::string& bytes);
  const std::string& address() const { return address_; }

 private:
  struct Port;
  void readOn();
  void answerAtOnce();
  void take(std::size_t bytes, double time);
  void lose(const std::string& why);

  std::string address_, host_, device_;
  int port_ = 0, baud_ = 115200;
  std::vector<std::string> program_;
  DeviceChild child_;
  LineHandler handler_;
  std::unique_ptr<Port> open_;
  std::thread thread_;
  std::string line_;
  std::atomic<bool> connected_{false};
  mutable std::mutex mutex_;  // of writing and of the reason of a loss
  std::string lost_;
};

}  // namespace mm
