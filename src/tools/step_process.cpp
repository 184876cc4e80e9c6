#include "tools/step_process.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <iostream>

#include "base/error.h"
#include "tools/interrupt.h"

namespace mm {
namespace {

constexpr int kCrashed = 125;  // an exception that nobody caught

/// What a step says goes there; opened before the step is a process, so that a disk that fails is said.
class OutputOfStep {
 public:
  explicit OutputOfStep(const std::filesystem::path& file)
      : descriptor_(::open(file.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0666)) {
    if (descriptor_ < 0)
      throw InputError(file.string() + ": cannot be written: " + std::strerror(errno) +
                       "; make room on the disk and run again");
  }
  ~OutputOfStep() { ::close(descriptor_); }
  OutputOfStep(const OutputOfStep&) = delete;
  OutputOfStep& operator=(const OutputOfStep&) = delete;
  void becomes(int descriptor) const { ::dup2(descriptor_, descriptor); }

 private:
  int descriptor_;
};

[[noreturn]] void workAndEnd(const std::function<int()>& work, const OutputOfStep& out,
                             const OutputOfStep& error, int limit) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  out.becomes(STDOUT_FILENO);
  error.becomes(STDERR_FILENO);
  ::signal(SIGALRM, SIG_DFL);
  ::alarm(static_cast<unsigned>(limit));
  int status = kCrashed;
  try {
    status = work();
  } catch (const std::exception& e) {
    std::cerr << "mm: error: " << e.what() << std::endl;
  }
  std::cout.flush();
  std::fflush(nullptr);
  ::_exit(status);  // without the destructors of what belongs to the parent
}

}  // namespace

StepEnd inProcessOfItsOwn(const std::function<int()>& work, const std::filesystem::path& out,
                          const std::filesystem::path& error, int limit) {
  std::cout.flush();
  std::fflush(nullptr);
  const OutputOfStep outFile(out), errorFile(error);
  const auto begun = std::chrono::steady_clock::now();
  const pid_t pid = ::fork();
  if (pid == 0) workAndEnd(work, outFile, errorFile, limit);
  if (pid < 0)
    throw InputError(std::string("no process can be made for a step: ") + std::strerror(errno) +
                     "; end other programs, or take fewer --jobs");
  int wait = 0;
  while (::waitpid(pid, &wait, 0) < 0 && errno == EINTR)
    if (Interrupt::asked()) ::kill(pid, SIGKILL);
  StepEnd end;
  end.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  end.status = WIFEXITED(wait) ? WEXITSTATUS(wait) : 128 + WTERMSIG(wait);
  end.timedOut = WIFSIGNALED(wait) && WTERMSIG(wait) == SIGALRM;
  return end;
}

StepEnd runStep(MmProgram program, const std::vector<std::string>& words, const std::filesystem::path& out,
                const std::filesystem::path& error, int limit) {
  return inProcessOfItsOwn(
      [&] {
        std::vector<std::string> all{"mm"};
        all.insert(all.end(), words.begin(), words.end());
        std::vector<char*> arguments;
        for (std::string& word : all) arguments.push_back(word.data());
        arguments.push_back(nullptr);
        return program(static_cast<int>(all.size()), arguments.data());
      },
      out, error, limit);
}

}  // namespace mm
