#pragma once
#include <sys/types.h>

#include <string>
#include <vector>

namespace mm {

/// Path of a program of the package.
std::string programBeside(const std::string& name);

/// A program that speaks for a device, on a socket that is its standard input and output. It knows by the end
/// of the socket that this process has ended, or wants it to end.
class DeviceChild {
 public:
  DeviceChild() = default;
  ~DeviceChild() { end(); }
  DeviceChild(const DeviceChild&) = delete;
  DeviceChild& operator=(const DeviceChild&) = delete;

  /// @param words program, by its path, and arguments. @param lent a descriptor of this process that is its
  /// number 3; -1: none. It has no other. @return this side's end of the socket.
  /// @throw Error naming the program and why.
  int start(const std::vector<std::string>& words, int lent = -1);
  /// Waits for its end, kills it where it takes too long. After its socket was closed.
  void end();

 private:
  pid_t pid_ = -1;
};

}  // namespace mm
