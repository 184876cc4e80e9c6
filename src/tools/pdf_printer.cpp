#include "tools/pdf_printer.h"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <vector>

#include "base/error.h"
#include "calibration_file/atomic_file.h"
#include "tools/interrupt.h"

extern char** environ;  // NOLINT(readability-redundant-declaration)

namespace mm {
namespace {

namespace fs = std::filesystem;

constexpr int kPatience = 120000, kLook = 100;  // ms

/// A folder of its own that goes with it.
class PrintFolder {
 public:
  PrintFolder() {
    std::string pattern = (fs::temp_directory_path() / "mm_print_XXXXXX").string();
    if (mkdtemp(pattern.data()) == nullptr)
      throw InputError(pattern + ": no folder can be made for printing (" + std::strerror(errno) +
                       "); free the disk or set TMPDIR");
    path_ = pattern;
  }
  ~PrintFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  PrintFolder(const PrintFolder&) = delete;
  PrintFolder& operator=(const PrintFolder&) = delete;
  fs::path operator/(const char* name) const { return path_ / name; }

 private:
  fs::path path_;
};

/// Starts a program in a group of its own, its output thrown away. @return its process.
pid_t startedProcess(const std::vector<std::string>& words) {
  std::vector<char*> arguments;
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  for (const int descriptor : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    posix_spawn_file_actions_addopen(&files, descriptor, "/dev/null", O_RDWR, 0);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
  posix_spawnattr_setpgroup(&attributes, 0);
  pid_t process = -1;
  const int failure = posix_spawnp(&process, arguments[0], &files, &attributes, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&files);
  posix_spawnattr_destroy(&attributes);
  if (failure != 0)
    throw InputError(words.front() + " cannot be started (" + std::strerror(failure) +
                     "); write a page instead (-o certificate.html)");
  return process;
}

/// Waits for the end of a process, asked every tenth of a second whether to stop. @param status as of
/// waitpid.
/// @return false: it took too long.
bool endedInTime(pid_t process, int& status) {
  for (int waited = 0; waited < kPatience; waited += kLook) {
    if (waitpid(process, &status, WNOHANG) == process) return true;
    if (Interrupt::asked()) break;
    poll(nullptr, 0, kLook);
  }
  kill(-process, SIGKILL);
  waitpid(process, nullptr, 0);
  Interrupt::check();
  return false;
}

}  // namespace

std::string findBrowser() {
  if (const char* named = std::getenv("MM_CHROMIUM"); named != nullptr && *named != '\0') return named;
  const char* path = std::getenv("PATH");
  if (path == nullptr) return {};
  for (const char* name : {"chromium", "chromium-browser", "google-chrome", "google-chrome-stable"}) {
    const std::string folders = path;
    for (std::size_t from = 0; from <= folders.size();) {
      const std::size_t end = std::min(folders.find(':', from), folders.size());
      const fs::path file = fs::path(folders.substr(from, end - from)) / name;
      if (access(file.c_str(), X_OK) == 0 && fs::is_regular_file(file)) return file.string();
      from = end + 1;
    }
  }
  return {};
}

std::string printedPdf(const std::string& browser, const std::string& html) {
  const PrintFolder folder;
  const fs::path page = folder / "certificate.html", pdf = folder / "certificate.pdf";
  writeFileAtomically(page, html);
  std::vector<std::string> words = {browser,
                                    "--headless",
                                    "--disable-gpu",
                                    "--no-first-run",
                                    "--no-pdf-header-footer",
                                    "--user-data-dir=" + (folder / "profile").string(),
                                    "--print-to-pdf=" + pdf.string()};
  // The page is this program's own, without scripts; as root the browser refuses its sandbox.
  if (geteuid() == 0) words.emplace_back("--no-sandbox");
  words.push_back("file://" + page.string());
  int status = 0;
  const bool inTime = endedInTime(startedProcess(words), status);
  // On a full disk it leaves the half of a document.
  if (inTime && !(WIFEXITED(status) && WEXITSTATUS(status) == 0))
    throw InputError(browser +
                     " failed to print; is the disk full? Write a page instead (-o certificate.html)");
  std::error_code error;
  if (!inTime || !fs::is_regular_file(pdf, error) || fs::file_size(pdf, error) == 0)
    throw InputError(browser +
                     (inTime ? " printed nothing; is the disk full?" : " did not end within two minutes") +
                     "; write a page (-o certificate.html) and print it from any browser");
  return readFile(pdf);
}

}  // namespace mm
