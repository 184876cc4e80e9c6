#pragma once
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace mm {

/// `mm` itself as a function: what stands behind `main`.
using MmProgram = int (*)(int argc, char** argv);

/// How a step ended.
struct StepEnd {
  int status = 0;         // exit status; 128 + signal where one ended it
  bool timedOut = false;  // took longer than it may
  double seconds = 0.0;
};

/// Runs work() in a process of its own (a fork without exec: no program is loaded, and a crash takes nothing
/// with it). Its standard output and error go to the ends of these files. Killed when this process ends, or
/// when Ctrl-C comes. To be called while this process has one thread.
/// @param limit s. @throw InputError: no process can be made.
StepEnd inProcessOfItsOwn(const std::function<int()>& work, const std::filesystem::path& out,
                          const std::filesystem::path& error, int limit);

/// The same for one command of mm. @param words "check", "s.bag", …
StepEnd runStep(MmProgram program, const std::vector<std::string>& words, const std::filesystem::path& out,
                const std::filesystem::path& error, int limit);

}  // namespace mm
