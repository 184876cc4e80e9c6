#pragma once
#include <filesystem>
#include <string>

namespace mm {

/// A file in the system's folder of temporary files that is gone when this is. Its name is made here.
class TemporaryFile {
 public:
  /// @param ending of its name, with the point. @throw InputError: it cannot be written.
  TemporaryFile(const std::string& ending, const std::string& content);
  ~TemporaryFile();
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  const std::filesystem::path& path() const { return path_; }  ///< whole

 private:
  std::filesystem::path path_;
};

}  // namespace mm
