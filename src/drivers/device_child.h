#pragma once
#include <sys/types.h>

#include <string>
#include <vector>

namespace mm {

/// A program that speaks for a device, on a socket that is its standard input and output. It knows by the end
/// of the socket that this process has ended, or wants it to end.
class DeviceChild {
 public:
  DeviceChild() = default;
  ~DeviceChild() { end(); }
  DeviceChild(const DeviceChild&) = delete;
  DeviceChild& operator=(const DeviceChild&) = delete;

  /// @param words program, by its path, and arguments. @return this side's end of the socket.
  /// @throw Error naming the program and why.
  int start(const std::vector<std::string>& words);
  /// Waits for its end, kills it where it takes too long. After its socket was closed.
  void end();

 private:
  pid_t pid_ = -1;
};

}  // namespace mm
