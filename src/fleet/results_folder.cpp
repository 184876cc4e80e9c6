#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "calibration_file/atomic_file.h"
#include "fleet/job.h"
#include "fleet/readable.h"
#include "session/text_file.h"

namespace mm {
namespace {

void makeFolder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error)
    throw InputError(folder.string() + ": cannot be made: " + error.message() +
                     "; check the path and its permissions");
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
                     " is not UTF-8, as the tables require; rename the folder, or name another");
  makeFolder(folder_ / "jobs");
}

void ResultsFolder::clearWork() const {
  std::error_code ignored;
  std::filesystem::remove_all(work(), ignored);
}

void ResultsFolder::begin(const BatchJob& job) const {
  forget(job.key);
  makeFolder(work() / job.key);
  writeFileAtomically(work() / job.key / "job.json", jobJson(job).dump(1) + "\n");
}

void ResultsFolder::finish(const std::string& key) const {
  const std::filesystem::path place = jobFolder(key), begun = work() / key;
  makeFolder(place.parent_path());
  syncPath(begun);
  if (::rename(begun.c_str(), place.c_str()) != 0)
    throw InputError(place.string() + ": cannot be made: " + std::strerror(errno) +
                     "; make room on the disk, or remove what is in the way, and run again");
  syncPath(place.parent_path());
}

void ResultsFolder::forget(const std::string& key) const {
  const std::filesystem::path aside = work() / (key + ".aside");
  std::error_code ignored;
  std::filesystem::create_directories(work(), ignored);
  ::rename(jobFolder(key).c_str(), aside.c_str());  // at once, so that no half of it is ever seen
  std::filesystem::remove_all(aside, ignored);
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
