// What a module on a line of Modbus RTU answers: bytes of anything, on a pty, with a true CRC or without.
#include <fcntl.h>
#include <poll.h>
#include <sched.h>
#include <stdlib.h>
#include <sys/ioctl.h>
#include <sys/select.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <termios.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>

#include "drivers/modbus_temperature.h"
#include "fuzz_support.h"

namespace {

/// The module's end of the line, and what it says next.
struct Module {
  int line = -1;
  std::string device, answer, said;  // said: to the last question
  std::string question;
  int end = -1;        // the device's, for how much of the answer is there
  dev_t number{};      // of the device
  bool asked = false;  // something was written to the device that was not heard yet

  Module() {
    line = ::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC);
    if (line < 0 || ::grantpt(line) != 0 || ::unlockpt(line) != 0) mm::fuzz::broken("a pty");
    device = ::ptsname(line);
    termios raw{};
    ::tcgetattr(line, &raw);
    ::cfmakeraw(&raw);
    ::tcsetattr(line, TCSANOW, &raw);
    end = ::open(device.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC | O_NONBLOCK);
    struct stat status {};
    ::fstat(end, &status);
    number = status.st_rdev;
  }
  /// Takes the question that was just asked, if one was, and answers it: then all of the answer is at the
  /// device's end, and nobody need wait for what does not come.
  void hear() {
    constexpr timespec kThroughThePty{1, 0};
    if (!asked) return;
    asked = false;
    char bytes[8];
    std::size_t got = 0;
    pollfd here{line, POLLIN, 0};
    while (got < sizeof bytes && ::ppoll(&here, 1, &kThroughThePty, nullptr) == 1) {
      const ssize_t more = ::read(line, bytes + got, sizeof bytes - got);
      if (more <= 0) break;
      got += static_cast<std::size_t>(more);
    }
    if (got == 0) return;
    question.assign(bytes, got);
    said = answer;
    for (std::size_t sent = 0; sent < said.size();) {  // libFuzzer's clock interrupts it now and then
      const ssize_t more = ::write(line, said.data() + sent, said.size() - sent);
      if (more < 0 && errno != EINTR) mm::fuzz::broken("the pty");
      sent += static_cast<std::size_t>(std::max<ssize_t>(0, more));
    }
    for (int turn = 0; turn < 10000 && unread() < said.size(); ++turn) ::sched_yield();
  }
  std::size_t unread() const {
    int bytes = 0;
    if (::ioctl(end, FIONREAD, &bytes) != 0) mm::fuzz::broken("the pty's other end");
    return static_cast<std::size_t>(bytes);
  }
};

Module& module() {
  static Module kModule;
  return kModule;
}

/// CRC-16 of Modbus over Serial Line V1.02, 6.2.2.
std::string checksum(const std::string& frame) {
  unsigned value = 0xFFFF;
  for (const char c : frame) {
    value ^= static_cast<unsigned char>(c);
    for (int bit = 0; bit < 8; ++bit) value = (value & 1U) != 0 ? value >> 1 ^ 0xA001U : value >> 1;
  }
  return {static_cast<char>(value & 0xFF), static_cast<char>(value >> 8)};
}

std::vector<mm::TemperatureSetup> sensors(const std::string& line) {
  const auto one = [&](const char* name, const char* type, const char* function, const char* words) {
    mm::TemperatureSetup setup;
    setup.name = name;
    setup.keys = {{"modbus", line},       {"unit", "1"},    {"register", "2"},  {"type", type},
                  {"function", function}, {"words", words}, {"timeout", "0.01"}};
    return setup;
  };
  return {one("a", "int16", "holding", "high"), one("b", "float32", "input", "low"),
          one("c", "int32", "holding", "low")};
}

}  // namespace

extern "C" {

/// Of libmodbus: no module thinks, so that what has not come will not come.
int select(int count, fd_set* readable, fd_set* /*writable*/, fd_set* /*odd*/, timeval* /*patience*/) {
  module().hear();
  pollfd here{count - 1, POLLIN, 0};
  const int ready = ::poll(&here, 1, 0);
  if (ready == 0) FD_ZERO(readable);
  return ready;
}

/// Of libmodbus: a question is on its way.
ssize_t write(int to, const void* bytes, std::size_t count) {
  const ssize_t written = ::syscall(SYS_write, to, bytes, count);
  struct stat status {};
  if (written > 0 && ::fstat(to, &status) == 0 && S_ISCHR(status.st_mode) &&
      status.st_rdev == module().number)
    module().asked = true;
  return written;
}

int nanosleep(const timespec* /*wanted*/, timespec* /*left*/) { return 0; }

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const auto devices =
      mm::makeTemperatureDevices(sensors("serial:" + module().device + ":9600:8N1"), "/nosuch");
  constexpr std::size_t kLongestAnswer = 300;  // a frame has 256 bytes at most
  if (size < 1 || size > kLongestAnswer) return 0;
  Module& m = module();
  m.answer = mm::fuzz::textOf(data + 1, size - 1);
  if ((data[0] & 1) != 0) m.answer += checksum(m.answer);
  for (const auto& device : devices)
    for (const mm::TemperatureReading& reading : device->read()) {
      if (std::isinf(reading.value)) mm::fuzz::broken("a reading is a number");
      if (std::isnan(reading.value) == reading.wrong.empty()) mm::fuzz::broken("what is no number says why");
      if (!reading.wrong.empty()) continue;
      const std::string frame =
          m.said.substr(0, m.said.size() < 2 ? 0 : 3 + static_cast<unsigned char>(m.said[2]));
      if (m.said.size() < frame.size() + 2 || m.said.substr(frame.size(), 2) != checksum(frame))
        mm::fuzz::broken("a frame without its CRC is no temperature");
      if (frame[0] != m.question[0]) mm::fuzz::broken("another unit's answer is no temperature");
    }
  return 0;
}

}  // extern "C"
