#include "drivers/serial_address.h"

#include <cstdlib>
#include <cstring>
#include <filesystem>

#include "base/error.h"

namespace mm {
namespace {

const char* const kPrefix = "serial:";

bool isNumber(const std::string& text) {
  return !text.empty() && text.find_first_not_of("0123456789") == std::string::npos;
}

/// 0: none that a line has.
int baudOf(const std::string& text) {
  if (!isNumber(text) || text.size() > 8) return 0;
  const int value = std::atoi(text.c_str());
  return value >= kSlowestLine && value <= kFastestLine ? value : 0;
}

bool isBits(const std::string& text) {
  return text.size() == 3 && (text[0] == '7' || text[0] == '8') && std::strchr("NEO", text[1]) != nullptr &&
         (text[2] == '1' || text[2] == '2');
}

/// What stands behind the last colon; empty: there is none.
std::string lastOf(const std::string& text) {
  const std::size_t colon = text.rfind(':');
  return colon == std::string::npos ? std::string() : text.substr(colon + 1);
}

void cutLast(std::string& text) { text.resize(text.rfind(':')); }

}  // namespace

bool isSerialAddress(const std::string& address) {
  return address.rfind(kPrefix, 0) == 0 || address.rfind('/', 0) == 0;
}

SerialAddress parseSerialAddress(const std::string& address, bool withBits, const std::string& form) {
  const std::string where = "address '" + address + "'";
  if (!isSerialAddress(address)) throw InputError(where + " is not a serial line; write " + form);
  SerialAddress line;
  std::string rest = address[0] == '/' ? address : address.substr(std::strlen(kPrefix));
  if (rest.empty() || rest[0] != '/')
    throw InputError(where + " names no device, whose path begins with /; write " + form);
  if (std::error_code ignored; !std::filesystem::exists(rest, ignored)) {
    if (withBits && lastOf(rest).size() == 3) {
      std::string before = rest;
      cutLast(before);
      if (isBits(lastOf(rest))) {
        line.bits = lastOf(rest);
        rest = before;
      } else if (baudOf(lastOf(before)) > 0) {
        throw InputError(where + ": '" + lastOf(rest) + "' is not 8N1, 8E1, 8O1, 8N2 or the like; write " +
                         form);
      }
    }
    const std::string speed = lastOf(rest);
    if (isNumber(speed)) {
      line.baud = baudOf(speed);
      if (line.baud == 0)
        throw InputError(where + ": '" + speed + "' is not a number from " + std::to_string(kSlowestLine) +
                         " to " + std::to_string(kFastestLine) +
                         " (baud); behind a path that ends so, write the speed too");
      cutLast(rest);
    } else if (!line.bits.empty()) {
      throw InputError(where + " has a frame format but no baud rate before it; write " + form);
    }
  }
  line.device = rest;
  return line;
}

}  // namespace mm
