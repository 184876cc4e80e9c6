#include "drivers/device_child.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <thread>

#include "base/error.h"

namespace mm {
namespace {

constexpr auto kPatience = std::chrono::milliseconds(500);  // until it is killed
constexpr int kLent = STDERR_FILENO + 1;                    // the program's number of what it is lent

}  // namespace

// Beside the program that runs, where the package has them all.
std::string programBeside(const std::string& name) {
  std::error_code failed;
  return std::filesystem::read_symlink("/proc/self/exe", failed).replace_filename(name);
}

int DeviceChild::start(const std::vector<std::string>& words, int lent) {
  if (::access(words.front().c_str(), X_OK) != 0)
    throw Error(words.front() + ": cannot be started: " + std::strerror(errno));
  int ends[2];
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0)
    throw Error(words.front() + ": cannot be started: " + std::strerror(errno));
  std::vector<char*> arguments;
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  pid_ = ::fork();
  if (pid_ == 0) {  // only what is safe between fork and exec
    ::dup2(ends[1], STDIN_FILENO);
    ::dup2(ends[1], STDOUT_FILENO);
    if (lent >= 0) ::dup2(lent, kLent);
    // What this process leaves open would live on with a program that stays for a moment.
    ::close_range(lent >= 0 ? kLent + 1 : kLent, ~0U, 0);
    sigset_t none;
    ::sigemptyset(&none);
    ::sigprocmask(SIG_SETMASK, &none, nullptr);
    ::execv(arguments[0], arguments.data());
    ::_exit(127);
  }
  const int cause = errno;
  ::close(ends[1]);
  if (pid_ > 0) return ends[0];
  ::close(ends[0]);
  throw Error(words.front() + ": cannot be started: " + std::strerror(cause));
}

void DeviceChild::end() {
  if (pid_ <= 0) return;
  const auto until = std::chrono::steady_clock::now() + kPatience;
  while (::waitpid(pid_, nullptr, WNOHANG) == 0) {
    if (std::chrono::steady_clock::now() > until) ::kill(pid_, SIGKILL);
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  pid_ = -1;
}

}  // namespace mm
