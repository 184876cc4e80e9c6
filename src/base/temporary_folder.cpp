#include "base/temporary_folder.h"

#include <stdlib.h>

#include <cerrno>
#include <cstring>
#include <fstream>

#include "base/error.h"

namespace mm {

namespace fs = std::filesystem;

TemporaryFolder::TemporaryFolder() {
  std::string name = (fs::temp_directory_path() / "mm-folder-XXXXXX").string();
  if (::mkdtemp(name.data()) == nullptr)
    throw InputError(name + ": cannot be made: " + std::strerror(errno) + "; make room, or set TMPDIR");
  path_ = name;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

void TemporaryFolder::write(const std::string& name, const std::string& text) const {
  const fs::path inside(name);
  bool leaves = inside.empty() || inside.is_absolute();
  for (const fs::path& part : inside) leaves = leaves || part == "..";
  if (leaves) throw InputError("'" + name + "' is not a file name inside a folder");
  std::error_code error;
  fs::create_directories((path_ / inside).parent_path(), error);
  errno = 0;  // what fails sets it: a stream does not tell why it failed, and its close forgets it
  std::ofstream out(path_ / inside, std::ios::binary);
  if (out) out << text << std::flush;
  int why = errno;
  out.close();
  if (why == 0) why = errno;
  if (!out)
    throw InputError((path_ / inside).string() + ": cannot be written" +
                     (why != 0 ? std::string(": ") + std::strerror(why) : std::string()) +
                     "; make room, or set TMPDIR");
}

}  // namespace mm
