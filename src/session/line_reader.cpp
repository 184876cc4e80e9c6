#include "session/line_reader.h"

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "base/error.h"
#include "base/text.h"

namespace mm {
namespace {
constexpr std::size_t kBlock = 1 << 20, kSmallBlock = 1 << 12;
}

LineReader::LineReader(const std::filesystem::path& file) : path_(file.string()), file_(nullptr) {
  std::error_code error;
  if (std::filesystem::is_directory(file, error)) throw InputError(path_ + ": is a folder, not a CSV file");
  file_ = std::fopen(path_.c_str(), "rb");
  if (file_ == nullptr) throw InputError(path_ + ": cannot be read: " + std::strerror(errno));
  const auto size = std::filesystem::file_size(file, error);
  size_ = error ? 0.0 : static_cast<double>(size);
}

LineReader::~LineReader() { std::fclose(file_); }

double LineReader::fraction() const { return size_ > 0.0 ? taken_ / size_ : 0.0; }

bool LineReader::fill() {
  if (end_ > begin_) std::memmove(buffer_.data(), buffer_.data() + begin_, end_ - begin_);
  end_ -= begin_;
  begin_ = 0;
  // a small file needs no large buffer; of a pipe the size is not known
  const std::size_t block =
      size_ > 0.0 && size_ < kBlock ? std::max(kSmallBlock, static_cast<std::size_t>(size_) + 1) : kBlock;
  buffer_.resize(end_ + block);
  const std::size_t got = std::fread(buffer_.data() + end_, 1, block, file_);
  if (std::ferror(file_) != 0)
    throw InputError(path_ + ": cannot be read to its end: " + std::strerror(errno));
  end_ += got;
  return got > 0;
}

bool LineReader::next(std::string_view& line) {
  std::size_t searched = begin_;
  for (;;) {
    const char* data = buffer_.data();
    const void* found = end_ > searched ? std::memchr(data + searched, '\n', end_ - searched) : nullptr;
    if (found != nullptr || (searched = end_ - begin_, !fill())) {
      data = buffer_.data();
      if (found == nullptr && begin_ == end_) return false;
      const std::size_t stop = found != nullptr ? static_cast<const char*>(found) - data : end_;
      line = std::string_view(data + begin_, stop - begin_);
      taken_ += static_cast<double>(stop - begin_ + 1);
      begin_ = found != nullptr ? stop + 1 : end_;
      if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
      ++number_;
      if (number_ == 1 && line.substr(0, 3) == "\xEF\xBB\xBF")
        line.remove_prefix(3);  // UTF-8 mark of spreadsheets
      return true;
    }
    searched += begin_;  // fill() moved the rest to the front
  }
}

namespace {

bool splitAtBlanks(std::string_view line, std::vector<std::string_view>& cells) {
  for (line = trim(line); !line.empty(); line = trim(line)) {
    const bool quoted = line.front() == '"';
    const std::size_t end = quoted ? line.find('"', 1) : line.find_first_of(" \t");
    if (quoted && end == std::string_view::npos) return false;
    cells.push_back(line.substr(quoted ? 1 : 0, quoted ? end - 1 : end));
    line.remove_prefix(end == std::string_view::npos ? line.size() : end + 1);
  }
  return true;
}

}  // namespace

bool splitCells(std::string_view line, std::vector<std::string_view>& cells, char separator) {
  cells.clear();
  if (separator == ' ') return splitAtBlanks(line, cells);
  std::size_t begin = 0;
  for (;;) {
    std::size_t start = begin;
    while (start < line.size() && line[start] == ' ') ++start;
    if (start < line.size() && line[start] == '"') {
      const std::size_t close = line.find('"', start + 1);
      if (close == std::string_view::npos) return false;
      const std::size_t next = line.find(separator, close);
      if (!trim(line.substr(close + 1, next == std::string_view::npos ? next : next - close - 1)).empty())
        return false;
      cells.push_back(line.substr(start + 1, close - start - 1));
      if (next == std::string_view::npos) return true;
      begin = next + 1;
      continue;
    }
    const std::size_t next = line.find(separator, begin);
    if (next == std::string_view::npos) {
      cells.push_back(trim(line.substr(begin)));
      return true;
    }
    cells.push_back(trim(line.substr(begin, next - begin)));
    begin = next + 1;
  }
}

}  // namespace mm
