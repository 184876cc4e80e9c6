#include "base/checksum.h"

#include <boost/crc.hpp>
#include <cstdio>

namespace mm {

std::string checksumOf(std::string_view bytes) {
  // CRC-64/XZ: polynomial of ECMA-182, reflected, all ones at both ends.
  boost::crc_optimal<64, 0x42F0E1EBA9EA3693ull, ~0ull, ~0ull, true, true> crc;
  crc.process_bytes(bytes.data(), bytes.size());
  char digits[17];
  std::snprintf(digits, sizeof digits, "%016llx", static_cast<unsigned long long>(crc.checksum()));
  return digits;
}

std::string hexDigits(const unsigned char* bytes, std::size_t count) {
  std::string digits;
  for (std::size_t i = 0; i < count; ++i)
    for (const int digit : {bytes[i] >> 4, bytes[i] & 15}) digits += "0123456789abcdef"[digit];
  return digits;
}

}  // namespace mm
