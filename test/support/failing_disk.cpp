// Preloaded into a program (LD_PRELOAD): its disk fails at a chosen moment, below one folder alone.
//   FAILING_DISK_FOLDER   absolute path; files elsewhere are left alone
//   FAILING_DISK_CONTROL  file with what fails and how (failing_disk.h), shared with whoever tests: it may
//   change while the
//                         program runs, and counts the operations of the program and of all that it starts
// Reads are: opening for reading, read, pread, readv, fread. Writes are: opening for writing, mkstemp,
// mkdtemp, write, pwrite, writev, fsync, fdatasync, ftruncate, rename, symlink, mkdir, and closing what was
// written.
#include "failing_disk.h"

#include <dlfcn.h>
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <climits>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace {

template <typename Function>
Function original(const char* name) {
  return reinterpret_cast<Function>(dlsym(RTLD_NEXT, name));
}

using mm_test::FailingDiskControl;
using Way = FailingDiskControl::Way;

FailingDiskControl& control() {
  static FailingDiskControl* const kControl = [] {
    static FailingDiskControl none;
    const char* file = std::getenv("FAILING_DISK_CONTROL");
    const int opened =
        file == nullptr ? -1 : original<int (*)(const char*, int, ...)>("open")(file, O_RDWR | O_CLOEXEC);
    if (opened < 0) return &none;
    void* shared = ::mmap(nullptr, sizeof none, PROT_READ | PROT_WRITE, MAP_SHARED, opened, 0);
    original<int (*)(int)>("close")(opened);
    return shared == MAP_FAILED ? &none : static_cast<FailingDiskControl*>(shared);
  }();
  return *kControl;
}

/// Whether these operations fail.
bool concerns(bool reading) { return (control().what & (reading ? 1 : 2)) != 0; }

bool below(const char* path) {
  static const char* const kFolder = std::getenv("FAILING_DISK_FOLDER");
  if (kFolder == nullptr || path == nullptr) return false;
  char whole[PATH_MAX];
  if (path[0] != '/') {
    char here[PATH_MAX];
    if (getcwd(here, sizeof here) == nullptr) return false;
    std::snprintf(whole, sizeof whole, "%.2000s/%.2000s", here, path);
    path = whole;
  }
  return std::strncmp(path, kFolder, std::strlen(kFolder)) == 0;
}

bool below(int descriptor) {
  char link[64], path[PATH_MAX];
  std::snprintf(link, sizeof link, "/proc/self/fd/%d", descriptor);
  const ssize_t length = ::readlink(link, path, sizeof path - 1);
  if (length <= 0) return false;
  path[length] = '\0';
  return below(path);
}

bool writable(int descriptor) {
  const int flags = ::fcntl(descriptor, F_GETFL);
  return flags >= 0 && (flags & O_ACCMODE) != O_RDONLY;
}

/// Whether this operation fails; counts it.
bool fails(bool reading) {
  FailingDiskControl& c = control();
  const std::int64_t n = ++(reading ? c.reads : c.writes), at = c.at;
  if (!concerns(reading) || at <= 0) return false;
  const bool now = c.way == Way::kLasting ? n >= at : n == at;
  if (now) errno = c.cause;
  return now;
}

bool uneven(bool reading) { return concerns(reading) && control().way == Way::kUneven; }

bool interrupted(bool reading) {
  static std::atomic<int> count[2];
  const bool now = uneven(reading) && ++count[reading] % 2 == 1;
  if (now) errno = EINTR;
  return now;
}

std::size_t part(bool reading, std::size_t size) { return uneven(reading) && size > 1 ? size / 2 : size; }

int openAs(const char* name, int folder, const char* path, int flags, mode_t mode, bool at) {
  if (below(path) && (flags & O_DIRECTORY) == 0 && fails((flags & O_ACCMODE) == O_RDONLY)) return -1;
  if (at) return original<int (*)(int, const char*, int, ...)>(name)(folder, path, flags, mode);
  return original<int (*)(const char*, int, ...)>(name)(path, flags, mode);
}

}  // namespace

#define MODE_OF(flags)                             \
  mode_t mode = 0;                                 \
  if (((flags) & (O_CREAT | O_TMPFILE)) != 0) {    \
    va_list list;                                  \
    va_start(list, flags);                         \
    mode = static_cast<mode_t>(va_arg(list, int)); \
    va_end(list);                                  \
  }

extern "C" {

int open(const char* path, int flags, ...) {
  MODE_OF(flags)
  return openAs("open", 0, path, flags, mode, false);
}
int open64(const char* path, int flags, ...) {
  MODE_OF(flags)
  return openAs("open64", 0, path, flags, mode, false);
}
int openat(int folder, const char* path, int flags, ...) {
  MODE_OF(flags)
  return openAs("openat", folder, path, flags, mode, true);
}

std::FILE* fopen(const char* path, const char* mode) {
  if (below(path) && fails(std::strchr(mode, 'r') != nullptr)) return nullptr;
  return original<std::FILE* (*)(const char*, const char*)>("fopen")(path, mode);
}
std::FILE* fopen64(const char* path, const char* mode) {
  if (below(path) && fails(std::strchr(mode, 'r') != nullptr)) return nullptr;
  return original<std::FILE* (*)(const char*, const char*)>("fopen64")(path, mode);
}

ssize_t read(int descriptor, void* data, size_t size) {
  const auto real = original<ssize_t (*)(int, void*, size_t)>("read");
  if (!below(descriptor)) return real(descriptor, data, size);
  if (fails(true) || interrupted(true)) return -1;
  return real(descriptor, data, part(true, size));
}
ssize_t pread(int descriptor, void* data, size_t size, off_t at) {
  if (below(descriptor) && fails(true)) return -1;
  return original<ssize_t (*)(int, void*, size_t, off_t)>("pread")(descriptor, data, size, at);
}
ssize_t readv(int descriptor, const iovec* parts, int count) {
  if (below(descriptor) && fails(true)) return -1;
  return original<ssize_t (*)(int, const iovec*, int)>("readv")(descriptor, parts, count);
}
ssize_t pread64(int descriptor, void* data, size_t size, off64_t at) {
  if (below(descriptor) && fails(true)) return -1;
  return original<ssize_t (*)(int, void*, size_t, off64_t)>("pread64")(descriptor, data, size, at);
}
size_t fread(void* data, size_t size, size_t count, std::FILE* file) {
  if (below(fileno(file)) && fails(true)) {
    file->_flags |= 0x20;  // glibc's mark of an error, which ferror reads
    return 0;
  }
  return original<size_t (*)(void*, size_t, size_t, std::FILE*)>("fread")(data, size, count, file);
}

ssize_t write(int descriptor, const void* data, size_t size) {
  const auto real = original<ssize_t (*)(int, const void*, size_t)>("write");
  if (!below(descriptor)) return real(descriptor, data, size);
  if (fails(false) || interrupted(false)) return -1;
  return real(descriptor, data, part(false, size));
}
ssize_t pwrite(int descriptor, const void* data, size_t size, off_t at) {
  if (below(descriptor) && fails(false)) return -1;
  return original<ssize_t (*)(int, const void*, size_t, off_t)>("pwrite")(descriptor, data, size, at);
}
ssize_t pwrite64(int descriptor, const void* data, size_t size, off64_t at) {
  if (below(descriptor) && fails(false)) return -1;
  return original<ssize_t (*)(int, const void*, size_t, off64_t)>("pwrite64")(descriptor, data, size, at);
}
ssize_t writev(int descriptor, const iovec* parts, int count) {
  if (below(descriptor) && fails(false)) return -1;
  return original<ssize_t (*)(int, const iovec*, int)>("writev")(descriptor, parts, count);
}
int fsync(int descriptor) {
  struct stat about {};
  if (below(descriptor) && ::fstat(descriptor, &about) == 0 && !S_ISDIR(about.st_mode) && fails(false))
    return -1;
  return original<int (*)(int)>("fsync")(descriptor);
}
int fdatasync(int descriptor) {
  if (below(descriptor) && fails(false)) return -1;
  return original<int (*)(int)>("fdatasync")(descriptor);
}
int ftruncate(int descriptor, off_t size) noexcept {
  if (below(descriptor) && fails(false)) return -1;
  return original<int (*)(int, off_t)>("ftruncate")(descriptor, size);
}
int ftruncate64(int descriptor, off64_t size) noexcept {
  if (below(descriptor) && fails(false)) return -1;
  return original<int (*)(int, off64_t)>("ftruncate64")(descriptor, size);
}
int close(int descriptor) {
  const bool counts = below(descriptor) && writable(descriptor);
  const int closed = original<int (*)(int)>("close")(descriptor);
  return counts && fails(false) ? -1 : closed;
}
int rename(const char* from, const char* to) noexcept {
  if (below(to) && fails(false)) return -1;
  return original<int (*)(const char*, const char*)>("rename")(from, to);
}
int renameat2(int fromFolder, const char* from, int toFolder, const char* to, unsigned flags) noexcept {
  if (below(to) && fails(false)) return -1;
  return original<int (*)(int, const char*, int, const char*, unsigned)>("renameat2")(fromFolder, from,
                                                                                      toFolder, to, flags);
}
int symlink(const char* target, const char* link) noexcept {
  if (below(link) && fails(false)) return -1;
  return original<int (*)(const char*, const char*)>("symlink")(target, link);
}
int mkdir(const char* path, mode_t mode) noexcept {
  if (below(path) && fails(false)) return -1;
  return original<int (*)(const char*, mode_t)>("mkdir")(path, mode);
}

char* mkdtemp(char* pattern) noexcept {
  if (below(pattern) && fails(false)) return nullptr;
  return original<char* (*)(char*)>("mkdtemp")(pattern);
}
int mkstemps(char* pattern, int ending) {
  if (below(pattern) && fails(false)) return -1;
  return original<int (*)(char*, int)>("mkstemps")(pattern, ending);
}

}  // extern "C"
