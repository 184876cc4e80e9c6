#include "workbench/temporary_file.h"

#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>

#include "base/error.h"

namespace mm {

TemporaryFile::TemporaryFile(const std::string& ending, const std::string& content) {
  std::string name = (std::filesystem::temp_directory_path() / "mm_workbench_XXXXXX").string() + ending;
  const int file = mkstemps(name.data(), static_cast<int>(ending.size()));  // readable by its owner alone
  if (file < 0) throw InputError(name + " cannot be made (" + std::strerror(errno) + ")");
  path_ = name;
  const auto refuse = [this](int cause) {
    std::error_code ignored;
    std::filesystem::remove(path_, ignored);
    throw InputError(path_.string() + " cannot be written (" + std::strerror(cause) + "); is the disk full?");
  };
  std::size_t written = 0;
  while (written < content.size()) {
    const ssize_t more = ::write(file, content.data() + written, content.size() - written);
    if (more < 0 && errno == EINTR) continue;
    if (more <= 0) {
      const int cause = errno;
      ::close(file);
      refuse(cause);
    }
    written += static_cast<std::size_t>(more);
  }
  if (::close(file) != 0) refuse(errno);
}

TemporaryFile::~TemporaryFile() {
  std::error_code ignored;
  std::filesystem::remove(path_, ignored);
}

}  // namespace mm
