#pragma once
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

namespace mm::test {

/// A folder of its own for one test, removed with it.
class Folder {
 public:
  Folder() {
    std::string name = (std::filesystem::temp_directory_path() / "mm_test_XXXXXX").string();
    path_ = ::mkdtemp(name.data());
  }
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  std::filesystem::path path(const std::string& name) const { return path_ / name; }
  std::filesystem::path write(const std::string& name, const std::string& content) const {
    std::ofstream(path(name), std::ios::binary) << content;
    return path(name);
  }

 private:
  std::filesystem::path path_;
};

inline std::string readAll(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

/// What `action` throws, as text; empty when it throws nothing. An exception of another type is not caught.
template <typename Exception, typename Action>
std::string messageOf(Action action) {
  try {
    action();
  } catch (const Exception& e) {
    return e.what();
  }
  return {};
}

/// The shared real measurements, or empty: $MM_SHARED_DATA, else ../shared/data beside the repository or
/// above it.
inline std::filesystem::path sharedData() {
  if (const char* path = std::getenv("MM_SHARED_DATA")) return path;
  for (const char* path : {"../shared/data", "../../shared/data"})
    if (std::filesystem::exists(path)) return path;
  return {};
}

}  // namespace mm::test
