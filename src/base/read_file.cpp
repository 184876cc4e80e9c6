#include "base/read_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>

#include "base/cancel_scope.h"
#include "base/error.h"

namespace mm {
namespace {

class Descriptor {
 public:
  explicit Descriptor(const std::filesystem::path& file) {
    while ((number_ = ::open(file.c_str(), O_RDONLY | O_CLOEXEC)) < 0 && errno == EINTR)
      CancelScope::check();  // nobody may ever write to a pipe
  }
  ~Descriptor() {
    if (number_ >= 0) ::close(number_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int number() const { return number_; }

 private:
  int number_;
};

[[noreturn]] void refuse(const std::filesystem::path& file, int cause, const std::string& remedy) {
  const std::string why = file.string() + ": cannot be read: " + std::strerror(cause) + "; " + remedy;
  if (cause == ENOENT || cause == ENOTDIR) throw InputError(why);
  throw UnreadableFile(why);
}

}  // namespace

std::string readWholeFile(const std::filesystem::path& file, const std::string& remedy) {
  const Descriptor in(file);
  if (in.number() < 0) refuse(file, errno, remedy);
  struct stat about {};
  if (::fstat(in.number(), &about) != 0) refuse(file, errno, remedy);
  if (S_ISDIR(about.st_mode)) throw InputError(file.string() + ": is a folder; name a file in it");
  std::string text;
  if (S_ISREG(about.st_mode)) text.reserve(static_cast<std::size_t>(about.st_size));
  std::array<char, 1 << 16> block;
  for (;;) {
    const ssize_t got = ::read(in.number(), block.data(), block.size());
    if (got < 0 && errno == EINTR) {
      CancelScope::check();  // a pipe may never give anything
      continue;
    }
    if (got < 0) refuse(file, errno, remedy);
    if (got == 0) return text;
    text.append(block.data(), static_cast<std::size_t>(got));
    if (!S_ISREG(about.st_mode) && text.size() > kLongestStream)
      throw InputError(file.string() + ": does not end, 256 MiB were read; name a file");
  }
}

std::string readPartOfFile(const std::filesystem::path& file, std::size_t begin, std::size_t size,
                           const std::string& remedy) {
  const Descriptor in(file);
  if (in.number() < 0) refuse(file, errno, remedy);
  std::string text(size, '\0');
  std::size_t done = 0;
  while (done < size) {
    const ssize_t got =
        ::pread(in.number(), text.data() + done, size - done, static_cast<off_t>(begin + done));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) refuse(file, errno, remedy);
    if (got == 0) break;
    done += static_cast<std::size_t>(got);
  }
  text.resize(done);
  return text;
}

}  // namespace mm
