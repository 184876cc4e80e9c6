#pragma once
#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
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

/// Runs the built `mm`. @param arguments as typed in a shell.
inline Answer mmRun(const TestFolder& folder, const std::string& arguments) {
  const std::string out = folder / "stdout.txt", error = folder / "stderr.txt";
  const int status =
      std::system(("'" MM_PROGRAM "' " + arguments + " >'" + out + "' 2>'" + error + "'").c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, textOf(out), textOf(error)};
}

}  // namespace mm
