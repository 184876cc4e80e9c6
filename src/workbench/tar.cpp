#include "workbench/tar.h"

#include <cstdio>
#include <cstring>
#include <ctime>

#include "base/error.h"

namespace mm {
namespace {

constexpr std::size_t kBlock = 512;

struct Header {
  char name[100], mode[8], uid[8], gid[8], size[12], time[12], checksum[8], type, link[100], magic[6],
      version[2], user[32], group[32], major[8], minor[8], prefix[155], unused[12];
};
static_assert(sizeof(Header) == kBlock, "a header of tar is one block");

template <std::size_t Size>
void setOctal(char (&field)[Size], unsigned long long value) {
  std::snprintf(field, Size, "%0*llo", static_cast<int>(Size - 1), value);
}

Header headerOf(const std::string& path, std::size_t size, std::time_t now) {
  Header header{};
  if (path.size() >= sizeof header.name)
    throw InputError("'" + path + "' has " + std::to_string(path.size()) + " characters; a tar allows " +
                     std::to_string(sizeof header.name - 1));
  std::memcpy(header.name, path.data(), path.size());
  setOctal(header.mode, 0644);
  setOctal(header.uid, 0);
  setOctal(header.gid, 0);
  setOctal(header.size, size);
  setOctal(header.time, static_cast<unsigned long long>(now));
  header.type = '0';  // a file
  std::memcpy(header.magic, "ustar", 6);
  std::memcpy(header.version, "00", 2);
  std::memset(header.checksum, ' ', sizeof header.checksum);  // counted as blanks
  unsigned long long sum = 0;
  for (std::size_t i = 0; i < kBlock; ++i) sum += reinterpret_cast<const unsigned char*>(&header)[i];
  std::snprintf(header.checksum, 7, "%06llo", sum);
  return header;
}

}  // namespace

std::string tarOf(const std::string& folder, const std::vector<ExportedFile>& files) {
  const std::time_t now = std::time(nullptr);
  std::string tar;
  for (const ExportedFile& file : files) {
    const Header header = headerOf(folder + "/" + file.path, file.text.size(), now);
    tar.append(reinterpret_cast<const char*>(&header), kBlock);
    tar += file.text;
    tar.resize((tar.size() + kBlock - 1) / kBlock * kBlock, '\0');
  }
  tar.append(2 * kBlock, '\0');  // the end
  return tar;
}

}  // namespace mm
