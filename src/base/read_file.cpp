#include "base/read_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>

#include "base/error.h"

namespace mm {
namespace {

class Descriptor {
 public:
  explicit Descriptor(const std::filesystem::path& file)
      : number_(::open(file.c_str(), O_RDONLY | O_CLOEXEC)) {}
  ~Descriptor() {
    if (number_ >= 0) ::close(number_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int number() const { return number_; }

 private:
  int number_;
};

}  // namespace

std::string readWholeFile(const std::filesystem::path& file, const std::string& remedy) {
  const auto refuse = [&](const std::string& why) -> InputError {
    return InputError(file.string() + ": cannot be read: " + why + "; " + remedy);
  };
  const Descriptor in(file);
  if (in.number() < 0) throw refuse(std::strerror(errno));
  struct stat about {};
  if (::fstat(in.number(), &about) != 0) throw refuse(std::strerror(errno));
  if (S_ISDIR(about.st_mode)) throw InputError(file.string() + ": is a folder; name a file in it");
  std::string text;
  if (S_ISREG(about.st_mode)) text.reserve(static_cast<std::size_t>(about.st_size));
  std::array<char, 1 << 16> block;
  for (;;) {
    const ssize_t got = ::read(in.number(), block.data(), block.size());
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) throw refuse(std::strerror(errno));
    if (got == 0) return text;
    text.append(block.data(), static_cast<std::size_t>(got));
    if (!S_ISREG(about.st_mode) && text.size() > kLongestStream)
      throw InputError(file.string() + ": does not end, 256 MiB were read; name a file");
  }
}

}  // namespace mm
