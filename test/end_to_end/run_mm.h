#pragma once
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>

namespace mm {

/// A folder of its own for one test, removed with it.
class TestFolder {
 public:
  TestFolder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "mm_end_to_end_XXXXXX").string();
    path_ = mkdtemp(pattern.data());
  }
  ~TestFolder() { std::filesystem::remove_all(path_); }
  TestFolder(const TestFolder&) = delete;
  TestFolder& operator=(const TestFolder&) = delete;

  std::string operator/(const std::string& name) const { return (path_ / name).string(); }
  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(path_ / name) << text;
    return *this / name;
  }

 private:
  std::filesystem::path path_;
};

inline std::string textOf(const std::string& file) {
  std::ifstream in(file);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

/// What `mm` answered.
struct Answer {
  int status = -1;
  std::string out, error;
  nlohmann::json json() const { return nlohmann::json::parse(out); }
};

/// Whether a process is where a test waits for it to be.
using ProcessState = std::function<bool(pid_t)>;

/// It has worked for so long: in the middle of its work, however busy the computer is.
/// @param seconds of the processor.
inline ProcessState workedFor(double seconds) {
  return [seconds](pid_t process) {
    std::string text = textOf("/proc/" + std::to_string(process) + "/stat");
    text.erase(0, text.rfind(')') + 1);  // the name of the program may have spaces
    std::istringstream fields(text);
    std::string skipped;
    double user = 0.0, system = 0.0;
    for (int i = 0; i < 11; ++i) fields >> skipped;
    fields >> user >> system;
    return (user + system) / static_cast<double>(::sysconf(_SC_CLK_TCK)) >= seconds;
  };
}

/// `mm` has opened a file; before it runs, the process is still a copy of the test.
inline ProcessState opened(const std::string& file) {
  return [file](pid_t process) {
    namespace fs = std::filesystem;
    std::error_code gone;
    const fs::path program = fs::read_symlink("/proc/" + std::to_string(process) + "/exe", gone);
    if (program != fs::canonical(MM_PROGRAM, gone)) return false;
    for (const auto& entry : fs::directory_iterator("/proc/" + std::to_string(process) + "/fd", gone))
      if (fs::read_symlink(entry.path(), gone) == fs::canonical(file, gone)) return true;
    return false;
  };
}

/// What a shell runs: the built `mm`, or `mm-benchmark` where the line begins with it.
inline std::string programAnd(const std::string& arguments) {
  const std::string benchmark = "mm-benchmark ";
  return arguments.rfind(benchmark, 0) == 0 ? "'" BENCHMARK_PROGRAM "' " + arguments.substr(benchmark.size())
                                            : "'" MM_PROGRAM "' " + arguments;
}

/// Runs the built `mm` in a folder and types Ctrl-C when it is somewhere; it is killed where it does not end.
inline Answer stoppedWhen(const ProcessState& there, const TestFolder& folder, const std::string& arguments) {
  const std::string out = folder / "stdout.txt", error = folder / "stderr.txt";
  const std::string command =
      "cd '" + folder / "." + "' && exec " + programAnd(arguments) + " >'" + out + "' 2>'" + error + "'";
  const pid_t process = ::fork();
  if (process == 0) {
    std::signal(SIGINT, SIG_DFL);  // ignored in what a script runs in the background
    ::execl("/bin/sh", "sh", "-c", command.c_str(), nullptr);
    ::_exit(127);
  }
  constexpr double kMost = 300.0, kMostAfter = 60.0;  // s until it is there, and from Ctrl-C to its end
  using Clock = std::chrono::steady_clock;
  auto began = Clock::now();
  int status = 0;
  bool stopped = false, killed = false;
  while (::waitpid(process, &status, WNOHANG) == 0) {
    if (!stopped && there(process)) {
      stopped = ::kill(process, SIGINT) == 0;
      began = Clock::now();
    }
    if (!killed &&
        std::chrono::duration<double>(Clock::now() - began).count() > (stopped ? kMostAfter : kMost))
      killed = ::kill(process, SIGKILL) == 0;
    ::usleep(5000);
  }
  EXPECT_FALSE(killed) << "it did not end: " << arguments;
  EXPECT_TRUE(stopped) << "it ended by itself: " << arguments;
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, textOf(out), textOf(error)};
}

/// Runs the built `mm`. @param arguments as typed in a shell.
inline Answer mmRun(const TestFolder& folder, const std::string& arguments) {
  const std::string out = folder / "stdout.txt", error = folder / "stderr.txt";
  const int status = std::system((programAnd(arguments) + " >'" + out + "' 2>'" + error + "'").c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, textOf(out), textOf(error)};
}

}  // namespace mm
