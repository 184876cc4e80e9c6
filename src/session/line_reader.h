#pragma once
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace mm {

/// Reads a text file line by line through one buffer, however large the file is.
class LineReader {
 public:
  /// @throw InputError when the file cannot be opened.
  explicit LineReader(const std::filesystem::path& file);
  ~LineReader();
  LineReader(const LineReader&) = delete;
  LineReader& operator=(const LineReader&) = delete;

  /// The next line without its line break (LF or CRLF), valid until the next call. False at the end.
  bool next(std::string_view& line);
  std::int64_t number() const { return number_; }  ///< of the last line, from 1
  double fraction() const;                         ///< of the file that was read, 0 to 1

 private:
  bool fill();
  std::string path_;
  std::FILE* file_;
  std::vector<char> buffer_;
  std::size_t begin_ = 0, end_ = 0;  // what is in the buffer and not yet given out
  std::int64_t number_ = 0;
  double size_ = 0.0, taken_ = 0.0;  // bytes
};

/// Splits a line at its commas; blanks around a cell and quotes around it are taken off. The cells point into
/// `line`.
/// @return false when a quote is not closed.
bool splitCells(std::string_view line, std::vector<std::string_view>& cells);

}  // namespace mm
