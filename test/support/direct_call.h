#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace mm {

/// Four bytes, the lowest first, as ROS counts on the wire.
inline std::string lengthBytes(std::uint32_t value) {
  std::string bytes;
  for (int shift = 0; shift < 32; shift += 8) bytes += static_cast<char>(value >> shift);
  return bytes;
}

inline std::string block(const std::string& bytes) {
  return lengthBytes(static_cast<std::uint32_t>(bytes.size())) + bytes;
}

/// The fields with which a connection of TCPROS begins.
inline std::string greeting(const std::vector<std::string>& fields) {
  std::string all;
  for (const std::string& field : fields) all += block(field);
  return block(all);
}

}  // namespace mm
