#pragma once
#include <sys/types.h>

#include <filesystem>
#include <string>
#include <vector>

namespace mm {

/// A program that was started. It ends with this process, however that ends (Linux: PR_SET_PDEATHSIG).
class ChildProcess {
 public:
  ChildProcess() = default;
  /// Starts words[0], looked for on the PATH, in a process group of its own, with nothing on standard input.
  /// @param log takes standard output and error. @throw InputError: it cannot be started.
  ChildProcess(const std::vector<std::string>& words, const std::filesystem::path& log);
  ~ChildProcess();  ///< kills it
  ChildProcess(ChildProcess&& other) noexcept;
  ChildProcess& operator=(ChildProcess&& other) noexcept;

  bool running();        ///< whether it has not ended yet
  void end(int signal);  ///< sends it to the whole group and waits
  /// Sends it to the program alone (not to its group), and waits for its end for so many seconds at most.
  /// @return whether it has ended.
  bool ask(int signal, double seconds);
  int status() const { return status_; }                     ///< exit status, or 128 + signal; -1: it runs
  const std::filesystem::path& log() const { return log_; }  ///< of what it printed

 private:
  pid_t pid_ = -1;
  int status_ = -1;
  std::filesystem::path log_;
};

/// Runs a program to its end. @return what it printed on standard output. @param status its exit status.
std::string outputOf(const std::vector<std::string>& words, int& status);

/// Whether a program of this name is on the PATH.
bool onPath(const std::string& program);

/// The last line of what a program printed: why it ended. Without the "mm: error:" of this one; empty: none.
std::string lastWordsOf(const std::filesystem::path& log);

}  // namespace mm
