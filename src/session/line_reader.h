#pragma once
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace mm {

/// Lines of a file, whatever it is written in.
class LineSource {
 public:
  virtual ~LineSource() = default;
  /// The next line without its line break, valid until the next call. False at the end.
  virtual bool next(std::string_view& line) = 0;
  virtual std::int64_t number() const = 0;  ///< of the last line, from 1
  virtual double fraction() const = 0;      ///< of the file that was read, 0 to 1
};

/// Reads a text file line by line through one buffer, however large the file is.
class LineReader : public LineSource {
 public:
  /// @throw InputError when the file cannot be opened.
  explicit LineReader(const std::filesystem::path& file);
  ~LineReader() override;
  LineReader(const LineReader&) = delete;
  LineReader& operator=(const LineReader&) = delete;

  /// The next line without its line break (LF or CRLF), valid until the next call. False at the end.
  bool next(std::string_view& line) override;
  std::int64_t number() const override { return number_; }
  double fraction() const override;

 private:
  bool fill();
  std::string path_;
  std::FILE* file_;
  std::vector<char> buffer_;
  std::size_t begin_ = 0, end_ = 0;  // what is in the buffer and not yet given out
  std::int64_t number_ = 0;
  double size_ = 0.0, taken_ = 0.0;  // bytes
};

/// Splits a line at its separators; blanks around a cell and quotes around it are taken off. A blank as
/// separator stands for any number of blanks and tabs. The cells point into `line`.
/// @return false when a quote is not closed.
bool splitCells(std::string_view line, std::vector<std::string_view>& cells, char separator = ',');

}  // namespace mm
