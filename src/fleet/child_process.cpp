#include "fleet/child_process.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <sstream>
#include <thread>

#include "base/error.h"
#include "base/text.h"
#include "calibration_file/atomic_file.h"

namespace mm {
namespace {

constexpr int kNotStarted = 127;

/// What a child does between fork and exec: only what is safe there.
[[noreturn]] void become(char* const* arguments, int in, int out) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  ::setpgid(0, 0);
  ::dup2(in, STDIN_FILENO);
  ::dup2(out, STDOUT_FILENO);
  ::dup2(out, STDERR_FILENO);
  ::signal(SIGINT, SIG_DFL);
  ::signal(SIGXFSZ, SIG_DFL);
  ::execvp(arguments[0], arguments);
  ::_exit(kNotStarted);
}

}  // namespace

ChildProcess::ChildProcess(const std::vector<std::string>& words, const std::filesystem::path& log) {
  std::vector<char*> arguments;
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  const int in = ::open("/dev/null", O_RDONLY | O_CLOEXEC);
  const int out = ::open(log.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  pid_ = out < 0 ? -1 : ::fork();
  if (pid_ == 0) become(arguments.data(), in, out);
  const int cause = errno;
  if (in >= 0) ::close(in);
  if (out >= 0) ::close(out);
  if (pid_ < 0)
    throw InputError(words.front() + ": cannot be started: " + std::strerror(cause) +
                     "; close other programs, or free disk space");
}

ChildProcess::~ChildProcess() {
  if (!running()) return;
  if (::kill(-pid_, SIGKILL) != 0) ::kill(pid_, SIGKILL);  // before it has a group of its own
  while (::waitpid(pid_, nullptr, 0) < 0 && errno == EINTR) {
  }
}

bool ChildProcess::running() {
  int wait = 0;
  if (status_ < 0 && ::waitpid(pid_, &wait, WNOHANG) == pid_)
    status_ = WIFEXITED(wait) ? WEXITSTATUS(wait) : 128 + WTERMSIG(wait);
  return status_ < 0;
}

void ChildProcess::ask(int signal) const {
  if (status_ < 0) ::kill(pid_, signal);
}

bool ChildProcess::endsWithin(double seconds) {
  const auto until = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  while (running() && std::chrono::steady_clock::now() < until)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  return status_ >= 0;
}

bool onPath(const std::string& program) {
  const char* path = std::getenv("PATH");
  std::istringstream folders(path == nullptr ? "/usr/bin:/bin" : path);
  for (std::string folder; std::getline(folders, folder, ':');)
    if (::access((folder + "/" + program).c_str(), X_OK) == 0) return true;
  return false;
}

std::string lastWordsOf(const std::filesystem::path& log) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(log, ignored) || std::filesystem::file_size(log, ignored) == 0)
    return {};
  const std::string text = readFile(log), trimmed(trim(text));
  std::string line = trimmed.substr(trimmed.find_last_of('\n') + 1);
  for (const char* head : {"mm: error: ", "mm: "})
    if (startsWith(line, head)) line = line.substr(std::string(head).size());
  return line;
}

}  // namespace mm
