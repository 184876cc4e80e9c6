#pragma once
#include <sys/types.h>

#include <filesystem>
#include <string>
#include <vector>

namespace mm {

/// A program that was started. It ends with this process, however that ends (Linux: PR_SET_PDEATHSIG).
class ChildProcess {
 public:
  /// Starts words[0], looked for on the PATH, in a process group of its own, with nothing on standard input.
  /// @param log takes standard output and error. @throw InputError: it cannot be started.
  ChildProcess(const std::vector<std::string>& words, const std::filesystem::path& log);
  ~ChildProcess();  ///< kills the whole group, and waits
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  bool running();              ///< whether it has not ended yet
  void ask(int signal) const;  ///< sends it to the program alone (not to its group)
  /// Waits for its end, for so many seconds at most. @return whether it has ended.
  bool endsWithin(double seconds);
  int status() const { return status_; }  ///< exit status, or 128 + signal; -1: it runs

 private:
  pid_t pid_ = -1;
  int status_ = -1;
};

/// Whether a program of this name is on the PATH.
bool onPath(const std::string& program);

/// The last line of what a program printed: why it ended. Without the "mm: error:" of this one; empty: none.
std::string lastWordsOf(const std::filesystem::path& log);

}  // namespace mm
