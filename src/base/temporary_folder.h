#pragma once
#include <filesystem>
#include <string>

namespace mm {

/// A folder of this process, which goes with it.
class TemporaryFolder {
 public:
  /// @throw InputError: no permission, full disk.
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  /// Where it is.
  const std::filesystem::path& path() const { return path_; }
  /// Writes a file in it, with the folders that its name asks for. @throw InputError: the name leads out of
  /// the folder; full disk.
  void write(const std::string& name, const std::string& text) const;

 private:
  std::filesystem::path path_;
};

}  // namespace mm
