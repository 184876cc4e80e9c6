#pragma once
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace mm {

/// A text file of somebody else as UTF-8 lines: UTF-8 or UTF-16 with or without its mark, else Latin-1
/// (Windows-1252); line breaks of Unix, Windows and old Macs.
class TextFile {
 public:
  /// @throw InputError when it cannot be read, is empty, or is no text (a workbook, a bag, binary).
  explicit TextFile(const std::filesystem::path& file);
  /// The bytes of a file that is not on this disk. @param name of it, for messages. @throw as above.
  TextFile(std::filesystem::path name, std::string bytes);
  TextFile(const TextFile&) = delete;
  TextFile& operator=(const TextFile&) = delete;

  const std::filesystem::path& path() const { return path_; }
  const std::string& encoding() const { return encoding_; }  ///< "UTF-8", "UTF-16", "Latin-1", "Windows-1252"
  const std::vector<std::string_view>& lines() const { return lines_; }  ///< line n is lines()[n - 1]
  /// "file:line: " for messages.
  std::string place(std::size_t line) const;

 private:
  void decode(std::string bytes);
  void split();
  std::filesystem::path path_;
  std::string text_, encoding_;
  std::vector<std::string_view> lines_;
};

/// Whether a text is UTF-8 (RFC 3629), which is all that JSON and the tables of a fleet hold.
bool isUtf8(std::string_view text);

}  // namespace mm
