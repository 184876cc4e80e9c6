#include "session/text_file.h"

#include <algorithm>
#include <boost/locale/encoding_utf.hpp>

#include "base/error.h"
#include "base/read_file.h"
#include "base/text.h"

namespace mm {
namespace {

std::string fromUtf16(const std::string& bytes, std::size_t begin, bool bigEndian) {
  std::u16string text;
  for (std::size_t i = begin; i + 1 < bytes.size(); i += 2) {
    const auto a = static_cast<unsigned char>(bytes[i]), b = static_cast<unsigned char>(bytes[i + 1]);
    text += static_cast<char16_t>(bigEndian ? a << 8 | b : b << 8 | a);
  }
  return boost::locale::conv::utf_to_utf<char>(text);
}

/// Latin-1, and where it has control characters those of Windows-1252 (dashes, quotes, per mille, euro).
std::string fromLatin1(const std::string& bytes) {
  static constexpr char16_t kWindows[32] = {0x20AC, 0x0081, 0x201A, 0x0192, 0x201E, 0x2026, 0x2020, 0x2021,
                                            0x02C6, 0x2030, 0x0160, 0x2039, 0x0152, 0x008D, 0x017D, 0x008F,
                                            0x0090, 0x2018, 0x2019, 0x201C, 0x201D, 0x2022, 0x2013, 0x2014,
                                            0x02DC, 0x2122, 0x0161, 0x203A, 0x0153, 0x009D, 0x017E, 0x0178};
  std::u16string text;
  for (const char b : bytes) {
    const auto c = static_cast<unsigned char>(b);
    text += c >= 0x80 && c < 0xA0 ? kWindows[c - 0x80] : static_cast<char16_t>(c);
  }
  return boost::locale::conv::utf_to_utf<char>(text);
}

}  // namespace

bool isUtf8(std::string_view text) {
  namespace utf = boost::locale::utf;
  for (auto at = text.begin(); at != text.end();)
    if (!utf::is_valid_codepoint(utf::utf_traits<char>::decode(at, text.end()))) return false;
  return true;
}

TextFile::TextFile(const std::filesystem::path& file)
    : TextFile(file, readWholeFile(file, "name a file of measurements")) {}

TextFile::TextFile(std::filesystem::path name, std::string bytes) : path_(std::move(name)) {
  decode(std::move(bytes));
  split();
}

void TextFile::decode(std::string bytes) {
  const std::string name = path_.string();
  if (bytes.empty()) throw InputError(name + ": is empty; the first line must name the columns");
  if (startsWith(bytes, "#ROSBAG"))
    throw InputError(name + ": is a bag, which is a session already; no import is needed");
  if (startsWith(bytes, "PK\x03\x04") || startsWith(bytes, "\xD0\xCF\x11\xE0"))
    throw InputError(name + ": is a workbook or an archive, not text; save the sheet as CSV and import that");
  encoding_ = "UTF-16";
  if (startsWith(bytes, "\xFF\xFE") || startsWith(bytes, "\xFE\xFF")) {
    text_ = fromUtf16(bytes, 2, bytes[0] == '\xFE');
    return;
  }
  std::size_t zeros[2] = {0, 0};
  const std::size_t looked = std::min<std::size_t>(bytes.size(), 4096);
  for (std::size_t i = 0; i < looked; ++i)
    if (bytes[i] == '\0') ++zeros[i % 2];
  if (zeros[0] + zeros[1] > 0) {  // text of 16 bits without its mark has a zero in every second place
    const bool big = zeros[0] > zeros[1];
    if (zeros[big ? 0 : 1] < looked / 3 || zeros[big ? 1 : 0] > 0)
      throw InputError(name + ": is binary, not text; export it as text or CSV");
    text_ = fromUtf16(bytes, 0, big);
    return;
  }
  const bool mark = startsWith(bytes, "\xEF\xBB\xBF");
  encoding_ = "UTF-8";
  if (isUtf8(bytes)) {
    text_ = mark ? bytes.substr(3) : std::move(bytes);
  } else {
    const bool windows = std::any_of(bytes.begin(), bytes.end(), [](char b) { return (b & 0xE0) == 0x80; });
    encoding_ = windows ? "Windows-1252" : "Latin-1";
    text_ = fromLatin1(bytes);
  }
}

void TextFile::split() {
  const std::string_view text = text_;
  const bool mac = text.find('\n') == std::string_view::npos;  // old Macs end a line with CR alone
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.size(), text.find(mac ? '\r' : '\n', begin));
    std::string_view line = text.substr(begin, end - begin);
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    lines_.push_back(line);
    begin = end + 1;
  }
}

std::string TextFile::place(std::size_t line) const {
  return path_.string() + ":" + std::to_string(line) + ": ";
}

}  // namespace mm
