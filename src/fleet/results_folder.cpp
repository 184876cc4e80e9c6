#include <fcntl.h>
#include <signal.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>

#include "base/error.h"
#include "calibration_file/atomic_file.h"
#include "fleet/job.h"
#include "fleet/utf8.h"

namespace mm {
namespace {

std::string hostName() {
  char name[256] = "localhost";
  ::gethostname(name, sizeof name - 1);
  std::string text = name;
  for (char& c : text)
    if (c == '.' || c == '/') c = '_';
  return text;
}

/// Of a job's folder while this process works on it.
std::string ownName(const std::string& key) {
  return key + "." + hostName() + "." + std::to_string(static_cast<long>(::getpid()));
}

void makeFolder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error)
    throw InputError(folder.string() + ": cannot be made: " + error.message() +
                     "; check the path and its permissions");
}

void syncPath(const std::filesystem::path& path) {
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return;
  ::fsync(descriptor);  // some file systems cannot: then it is as safe as it gets
  ::close(descriptor);
}

}  // namespace

std::filesystem::path ResultsFolder::jobFolder(const std::string& key) const {
  return folder_ / "jobs" / key.substr(0, 2) / key;
}

bool ResultsFolder::finished(const std::string& key) const {
  std::error_code ignored;
  return std::filesystem::is_regular_file(jobFolder(key) / "result.json", ignored);
}

std::optional<std::string> ResultsFolder::result(const std::string& key) const {
  if (!finished(key)) return std::nullopt;
  return readFile(jobFolder(key) / "result.json");
}

void ResultsFolder::prepare() const {
  if (!isUtf8(std::filesystem::absolute(folder_).string()))
    throw InputError("-o: the path of the results " + readable(folder_.string()) +
                     " is not UTF-8, and the tables hold nothing else; rename the folder, or name another");
  makeFolder(folder_ / "jobs");
  makeFolder(work());
}

std::filesystem::path ResultsFolder::begin(const std::string& key) const {
  const std::filesystem::path begun = work() / ownName(key);
  std::filesystem::remove_all(begun);
  makeFolder(begun);
  return begun;
}

bool ResultsFolder::finish(const std::filesystem::path& begun, const std::string& key) const {
  const std::filesystem::path place = jobFolder(key);
  makeFolder(place.parent_path());
  syncPath(begun / "result.json");
  syncPath(begun);
  bool moved = ::rename(begun.c_str(), place.c_str()) == 0;
  if (!moved && !finished(key)) {  // what is there is no result: a folder that somebody emptied, a file
    forget(key);
    moved = ::rename(begun.c_str(), place.c_str()) == 0;
  }
  if (moved) {
    syncPath(place.parent_path());
    return true;
  }
  const int cause = errno;
  if (finished(key)) {  // another process did the same job
    std::filesystem::remove_all(begun);
    return false;
  }
  throw InputError(place.string() + ": cannot be made: " + std::strerror(cause) +
                   "; make room on the disk, or remove what is in the way, and run again");
}

void ResultsFolder::forget(const std::string& key) const {
  const std::filesystem::path aside = work() / (ownName(key) + ".aside");
  std::error_code ignored;
  std::filesystem::remove_all(aside, ignored);
  ::rename(jobFolder(key).c_str(), aside.c_str());  // at once, so that no half of it is ever seen
  std::filesystem::remove_all(aside, ignored);
}

namespace {

/// Seconds since anything was last made in a folder, at any depth.
double quietFor(const std::filesystem::path& folder) {
  std::error_code ignored;
  auto last = std::filesystem::last_write_time(folder, ignored);
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder, ignored))
    last = std::max(last, entry.last_write_time(ignored));
  return std::chrono::duration<double>(std::filesystem::file_time_type::clock::now() - last).count();
}

/// `<32 digits>.<host>.<process>`: of a job that ran.
bool isOfJob(const std::string& name) {
  return name.size() > 33 && name[32] == '.' && name.find_first_not_of("0123456789abcdef") == 32;
}

}  // namespace

int ResultsFolder::removeLeftovers(double patience) const {
  int removed = 0;
  const std::string host = "." + hostName() + ".";
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator(work(), ignored)) {
    const std::string name = entry.path().filename().string();
    const std::size_t at = name.find(host);
    if (!isOfJob(name)) continue;
    const long pid = at == 32 ? std::atol(name.c_str() + at + host.size()) : 0;
    const bool ended = pid > 0 ? ::kill(static_cast<pid_t>(pid), 0) != 0 && errno == ESRCH
                               : quietFor(entry.path()) > patience;
    if (!ended) continue;
    std::filesystem::remove_all(entry.path(), ignored);
    ++removed;
  }
  return removed;
}

ResultsLock::ResultsLock(const ResultsFolder& folder) {
  const std::filesystem::path file = folder.path() / ".lock";
  descriptor_ = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  if (descriptor_ < 0)
    throw InputError(file.string() + ": cannot be written: " + std::strerror(errno) +
                     "; check the permissions of the folder");
  if (::flock(descriptor_, LOCK_EX | LOCK_NB) == 0) return;
  const int cause = errno;
  ::close(descriptor_);
  if (cause != EWOULDBLOCK)
    throw InputError(file.string() + ": cannot be locked: " + std::strerror(cause) +
                     "; put the results on a file system that has locks (of NFS: mounted without nolock)");
  throw InputError(folder.path().string() +
                   ": another mm batch writes to this folder; wait for it, or name another folder with -o");
}

ResultsLock::~ResultsLock() { ::close(descriptor_); }

}  // namespace mm
