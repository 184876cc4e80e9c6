#pragma once
#include <string>
#include <string_view>

namespace mm {

/// CRC-64 of the bytes, as 16 hexadecimal digits: finds damage, is no protection against forgery.
std::string checksumOf(std::string_view bytes);

/// Bytes as hexadecimal digits, two each.
std::string hexDigits(const unsigned char* bytes, std::size_t count);

}  // namespace mm
