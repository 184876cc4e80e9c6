#pragma once
#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <regex>

#include "../support/failing_disk.h"
#include "long_tests.h"
#include "session_folder.h"

namespace mm {

/// One way in which a disk fails.
struct DiskFault {
  using Way = mm_test::FailingDiskControl::Way;
  bool reads = false;
  Way way = Way::kOnce;
  int n = 0;          // which operation; 0 where all reads and writes are uneven
  int cause = EIO;    // errno
  bool anew = false;  // nothing of the outputs is there yet
  std::string inWords() const {
    if (way == Way::kUneven) return "reads and writes are cut short or interrupted";
    return std::string(reads ? "read " : "write ") + std::to_string(n) +
           (way == Way::kOnce ? " once " : " lasting ") + std::strerror(cause) +
           (anew ? ", nothing there before" : "");
  }
};

/// The folder of a session on a disk that fails when it is told to (../support/failing_disk.cpp).
class FailingDisk : public SessionFolder {
 protected:
  static void SetUpTestSuite() {
    SessionFolder::SetUpTestSuite();
    namespace fs = std::filesystem;
    whole_ = fs::canonical(*folder_ / ".").string();
    fs::create_directory(whole_ + "/tmp");
    const std::string file = whole_ + ".control";
    const mm_test::FailingDiskControl none{};
    std::ofstream(file, std::ios::binary).write(reinterpret_cast<const char*>(&none), sizeof none);
    const int opened = ::open(file.c_str(), O_RDWR | O_CLOEXEC);
    void* shared = ::mmap(nullptr, sizeof none, PROT_READ | PROT_WRITE, MAP_SHARED, opened, 0);
    ::close(opened);
    ASSERT_NE(shared, MAP_FAILED);
    control_ = static_cast<mm_test::FailingDiskControl*>(shared);
  }
  static void TearDownTestSuite() {
    ::munmap(control_, sizeof *control_);
    std::filesystem::remove(whole_ + ".control");
    SessionFolder::TearDownTestSuite();
  }

  static void set(const DiskFault& fault) {
    control_->reads = control_->writes = 0;
    control_->at = fault.n;
    control_->way = fault.way;
    control_->cause = fault.cause;
    control_->what = fault.way == DiskFault::Way::kUneven ? 3 : fault.reads ? 1 : 2;
  }
  static void mend() { control_->what = 0; }

  /// Typed inside the folder, whose disk counts, and fails as it was set.
  static Answer typedOnIt(const std::string& arguments) {
    const std::string out = *folder_ / "stdout.txt", error = *folder_ / "stderr.txt";
    const int status =
        std::system(("cd '" + whole_ + "' && TMPDIR='" + whole_ + "/tmp' FAILING_DISK_FOLDER='" + whole_ +
                     "/' FAILING_DISK_CONTROL='" + whole_ +
                     ".control' LD_PRELOAD='" FAILING_DISK_LIBRARY "' '" MM_PROGRAM "' " + arguments + " >'" +
                     out + "' 2>'" + error + "' </dev/null")
                        .c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, textOf(out), textOf(error)};
  }
  static Answer typedOn(const DiskFault& fault, const std::string& arguments) {
    set(fault);
    const Answer answer = typedOnIt(arguments);
    mend();
    return answer;
  }

  /// How many reads and writes the last command made.
  static int reads() { return static_cast<int>(control_->reads); }
  static int writes() { return static_cast<int>(control_->writes); }

  /// Every way to fail of a command that makes so many reads and writes: in a long test each n with each
  /// cause, else one in the middle, in a thorough test of what passes also the first and the last, and the
  /// causes in turn; and once all of them are uneven. Every day a read fails once, and a write once, or from
  /// then on for those that tidy up behind it.
  static std::vector<DiskFault> faults(int reads, int writes) {
    std::vector<DiskFault> all;
    for (const bool reading : {true, false}) {
      const int most = reading ? reads : writes, between = (most + 1) / 2;
      using Way = DiskFault::Way;
      const bool everyWay = mm_test::thoroughTests();
      for (const Way way :
           everyWay || !reading ? std::vector<Way>{Way::kOnce, Way::kLasting} : std::vector<Way>{Way::kOnce})
        for (int n = 1; n <= most; ++n) {
          const bool ends = way == Way::kOnce && (n == 1 || n == most);
          const bool asked = n == between || (ends && everyWay);
          if (!asked && !mm_test::longTests()) continue;
          for (const int cause : reading ? std::vector<int>{EIO} : std::vector<int>{EIO, ENOSPC})
            for (const bool anew : {false, true})
              if (mm_test::longTests() ||
                  ((reading || (n % 2 == 0) == (cause == EIO)) && (n / 2 % 2 == 0) == anew))
                all.push_back({reading, way, n, cause, anew});
        }
    }
    all.push_back({false, DiskFault::Way::kUneven, 0, 0, false});
    return all;
  }

  /// The folder's files as they were; others are removed, with the folders that they leave empty.
  static void putBack(const std::map<std::string, std::string>& files) {
    namespace fs = std::filesystem;
    for (const auto& [name, text] : FailingDisk::files()) {
      if (files.count(name) > 0) continue;
      fs::remove(name);
      const fs::path folder = fs::path(name).parent_path();
      if (fs::is_empty(folder) && folder.filename() != "tmp") fs::remove(folder);
    }
    for (const auto& [name, text] : files) {
      fs::create_directories(fs::path(name).parent_path());
      if (textOf(name) != text) std::ofstream(name, std::ios::binary) << text;
    }
  }

  /// A refusal: status 2 and one line, which says what the system said, or that it is the disk.
  static void expectOneLine(const Answer& answer, const DiskFault& fault) {
    EXPECT_EQ(answer.status, 2) << answer.error;
    EXPECT_EQ(std::count(answer.error.begin(), answer.error.end(), '\n'), 1) << answer.error;
    EXPECT_EQ(answer.error.rfind("mm: error: ", 0), 0u) << answer.error;
    const bool why = answer.error.find(std::strerror(fault.cause)) != std::string::npos ||
                     answer.error.find(" disk") != std::string::npos;
    EXPECT_TRUE(why) << answer.error;
  }

  static inline std::string whole_;  // the folder's whole path
  static inline mm_test::FailingDiskControl* control_ = nullptr;
};

/// What a text of the package says, without when it was and how long it took.
inline std::string withoutTime(const std::string& text) {
  static const std::regex seconds(" in [0-9.]+ s\\b");
  std::istringstream in(std::regex_replace(text, seconds, ""));
  std::string kept;
  for (std::string line; std::getline(in, line);) {
    bool leave = false;
    for (const char* key : {"checksum:", "id:", "created:", "time:", "  - {action", "SHA-256"})
      leave = leave || line.find(key) != std::string::npos;
    if (!leave) kept += line + "\n";
  }
  return kept;
}

}  // namespace mm
