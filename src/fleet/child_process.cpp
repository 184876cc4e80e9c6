#include "fleet/child_process.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <sstream>
#include <thread>
#include <utility>

#include "base/error.h"
#include "base/text.h"
#include "calibration_file/atomic_file.h"

namespace mm {
namespace {

constexpr int kNotStarted = 127;

int statusOf(int wait) { return WIFEXITED(wait) ? WEXITSTATUS(wait) : 128 + WTERMSIG(wait); }

std::vector<char*> argumentsOf(const std::vector<std::string>& words) {
  std::vector<char*> arguments;
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  return arguments;
}

/// What a child does between fork and exec: only what is safe there.
[[noreturn]] void become(char* const* arguments, int in, int out, int error) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  ::setpgid(0, 0);
  ::dup2(in, STDIN_FILENO);
  ::dup2(out, STDOUT_FILENO);
  ::dup2(error, STDERR_FILENO);
  ::signal(SIGINT, SIG_DFL);
  ::signal(SIGXFSZ, SIG_DFL);
  ::execvp(arguments[0], arguments);
  ::_exit(kNotStarted);
}

}  // namespace

ChildProcess::ChildProcess(const std::vector<std::string>& words, const std::filesystem::path& log)
    : log_(log) {
  const std::vector<char*> arguments = argumentsOf(words);
  const int in = ::open("/dev/null", O_RDONLY | O_CLOEXEC);
  const int out = ::open(log.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  pid_ = out < 0 ? -1 : ::fork();
  if (pid_ == 0) become(arguments.data(), in, out, out);
  const int cause = errno;
  if (in >= 0) ::close(in);
  if (out >= 0) ::close(out);
  if (pid_ < 0)
    throw InputError(words.front() + ": cannot be started: " + std::strerror(cause) +
                     "; end other programs, or make room on the disk");
}

ChildProcess::~ChildProcess() {
  if (pid_ > 0 && status_ < 0) end(SIGKILL);
}

ChildProcess::ChildProcess(ChildProcess&& other) noexcept
    : pid_(std::exchange(other.pid_, -1)), status_(other.status_), log_(std::move(other.log_)) {}

ChildProcess& ChildProcess::operator=(ChildProcess&& other) noexcept {
  std::swap(pid_, other.pid_);
  std::swap(status_, other.status_);
  std::swap(log_, other.log_);
  return *this;
}

bool ChildProcess::running() {
  if (pid_ < 0 || status_ >= 0) return false;
  int wait = 0;
  const pid_t ended = ::waitpid(pid_, &wait, WNOHANG);
  if (ended == pid_) status_ = statusOf(wait);
  return status_ < 0;
}

void ChildProcess::end(int signal) {
  if (!running()) return;
  if (::kill(-pid_, signal) != 0) ::kill(pid_, signal);  // before it has a group of its own
  int wait = 0;
  while (::waitpid(pid_, &wait, 0) < 0 && errno == EINTR) {
  }
  status_ = statusOf(wait);
}

bool ChildProcess::ask(int signal, double seconds) {
  if (!running()) return true;
  ::kill(pid_, signal);
  const auto until = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  while (running() && std::chrono::steady_clock::now() < until)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  return status_ >= 0;
}

std::string outputOf(const std::vector<std::string>& words, int& status) {
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) throw InputError(words.front() + ": cannot be started: no pipe is left");
  const std::vector<char*> arguments = argumentsOf(words);
  const int null = ::open("/dev/null", O_RDWR | O_CLOEXEC);
  const pid_t pid = ::fork();
  if (pid == 0) become(arguments.data(), null, ends[1], null);
  ::close(ends[1]);
  ::close(null);
  std::string text;
  char buffer[4096];
  for (ssize_t n = 0; (n = ::read(ends[0], buffer, sizeof buffer)) > 0 || (n < 0 && errno == EINTR);)
    if (n > 0) text.append(buffer, static_cast<std::size_t>(n));
  ::close(ends[0]);
  int wait = 0;
  while (pid > 0 && ::waitpid(pid, &wait, 0) < 0 && errno == EINTR) {
  }
  status = pid > 0 ? statusOf(wait) : kNotStarted;
  return text;
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
