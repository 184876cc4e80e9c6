#include "calibration_file/atomic_file.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>

#include "base/error.h"
#include "base/read_file.h"

namespace mm {
namespace fs = std::filesystem;
namespace {

[[noreturn]] void refuse(const fs::path& file, int cause) {
  std::string remedy = "check the path and its permissions";
  if (cause == ENOSPC || cause == EDQUOT)
    remedy = "free disk space and repeat; the existing file is unchanged";
  if (cause == EFBIG)
    remedy = "raise the file size limit (ulimit -f) and repeat; the existing file is unchanged";
  if (cause == ENOENT) remedy = "create the folder first";
  throw InputError(file.string() + ": cannot be written: " + std::strerror(cause) + "; " + remedy);
}

/// Writing beyond a limit of file sizes raises SIGXFSZ, which would end the process: held back in this
/// thread, so that write() reports EFBIG instead.
class HeldFileSizeSignal {
 public:
  HeldFileSizeSignal() {
    sigemptyset(&signal_);
    sigaddset(&signal_, SIGXFSZ);
    pthread_sigmask(SIG_BLOCK, &signal_, &before_);
  }
  ~HeldFileSizeSignal() {
    const timespec now{0, 0};
    while (sigtimedwait(&signal_, nullptr, &now) > 0) {
    }
    pthread_sigmask(SIG_SETMASK, &before_, nullptr);
  }
  HeldFileSizeSignal(const HeldFileSizeSignal&) = delete;
  HeldFileSizeSignal& operator=(const HeldFileSizeSignal&) = delete;

 private:
  sigset_t signal_, before_;
};

/// @return 0 or the errno.
int writeAll(int descriptor, const std::string& text) {
  const HeldFileSizeSignal held;
  for (std::size_t done = 0; done < text.size();) {
    const ssize_t written = ::write(descriptor, text.data() + done, text.size() - done);
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return errno;
    done += static_cast<std::size_t>(written);
  }
  return 0;
}

fs::path folderOf(const fs::path& file) {
  return file.has_parent_path() ? file.parent_path() : fs::path(".");
}

fs::path temporaryBeside(const fs::path& file) {
  static std::atomic<unsigned> counter{0};
  return folderOf(file) / ("." + file.filename().string() + kTemporaryMark + std::to_string(::getpid()) +
                           "-" + std::to_string(counter++));
}

}  // namespace

void syncPath(const fs::path& path) {
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return;
  ::fsync(descriptor);
  ::close(descriptor);
}

void writeFileAtomically(const fs::path& file, const std::string& text) {
  std::error_code ignored;
  // A link keeps its place: the file it points to is replaced.
  const fs::path target = fs::exists(file, ignored) ? fs::canonical(file) : file;
  if (fs::is_directory(target, ignored)) throw InputError(file.string() + ": is a folder; name a file in it");
  const bool direct = fs::exists(target, ignored) && !fs::is_regular_file(target, ignored);
  const fs::path temporary = direct ? target : temporaryBeside(target);
  const int descriptor = ::open(
      temporary.c_str(), direct ? O_WRONLY | O_CLOEXEC : O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (descriptor < 0) refuse(file, errno);
  int cause = writeAll(descriptor, text);
  if (cause == 0 && !direct && ::fsync(descriptor) != 0) cause = errno;
  if (::close(descriptor) != 0 && cause == 0) cause = errno;
  if (cause == 0 && !direct && ::rename(temporary.c_str(), target.c_str()) != 0) cause = errno;
  if (cause != 0) {
    if (!direct) ::unlink(temporary.c_str());
    refuse(file, cause);
  }
  if (!direct) syncPath(folderOf(target));
}

void linkAtomically(const fs::path& link, const std::string& target) {
  const fs::path temporary = temporaryBeside(link);
  ::unlink(temporary.c_str());
  if (::symlink(target.c_str(), temporary.c_str()) != 0) refuse(link, errno);
  if (::rename(temporary.c_str(), link.c_str()) != 0) {
    const int cause = errno;
    ::unlink(temporary.c_str());
    refuse(link, cause);
  }
  syncPath(folderOf(link));
}

std::string readFile(const fs::path& file) { return readWholeFile(file, "check the path"); }

}  // namespace mm
