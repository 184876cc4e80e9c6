#pragma once
#include <string>

namespace mm {

/// A serial line as it is written: `serial:<device>`, or the device's path alone, with `:<baud>` behind it,
/// and `:<bits>` (8N1) behind that where bits are asked for.
struct SerialAddress {
  std::string device;  // a path that begins with /
  int baud = 0;        // 0: not given
  std::string bits;    // data bits, parity, stop bits; empty: not given
  bool operator==(const SerialAddress& other) const {
    return device == other.device && baud == other.baud && bits == other.bits;
  }
};
inline constexpr int kSlowestLine = 300, kFastestLine = 4000000;  // baud

/// Paths have colons of their own (/dev/serial/by-path/pci-0000:00:14.0-usb-0:1:1.0-port0): a speed is what
/// stands behind the last one and is a whole number; a path that is there as it is written has none.
/// @param form how an address is written, for people. @throw InputError naming address, value and bound.
SerialAddress parseSerialAddress(const std::string& address, bool withBits, const std::string& form);
/// Whether it is meant as a serial line: `serial:…` or a path.
bool isSerialAddress(const std::string& address);

}  // namespace mm
