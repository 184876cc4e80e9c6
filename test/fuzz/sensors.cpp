// What temperature sensors say: files of the kernel, registers of Modbus, and where the user says that they
// are.
#include <cmath>

#include "drivers/modbus_temperature.h"
#include "drivers/sysfs_temperature.h"
#include "fuzz_support.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text = mm::fuzz::textOf(data, size);
  if (const auto value = mm::parseSysfsNumber(text); value && !std::isfinite(*value))
    mm::fuzz::broken("a number of the kernel is finite");
  mm::fuzz::takes([&] { mm::parseModbusLine(text); });
  mm::fuzz::takes([&] { mm::parseModbusLine("serial:" + text); });
  if (size >= 5) {
    using Type = mm::RegisterLayout::Type;
    const auto word = [&](std::size_t i) { return static_cast<std::uint16_t>(data[i] << 8 | data[i + 1]); };
    const mm::RegisterLayout layout{static_cast<Type>(data[0] % 4), (data[0] & 4) != 0};
    if (std::isinf(mm::registerValue({word(1), word(3)}, layout)))
      mm::fuzz::broken("registers hold a number or NaN");
  }
  // key=value lines of two sensors
  std::vector<mm::TemperatureSetup> sensors(2);
  std::size_t which = 0, at = 0;
  while (at < text.size()) {
    const std::size_t end = std::min(text.find('\n', at), text.size()), equals = text.find('=', at);
    if (equals < end)
      (text.compare(at, equals - at, "name") == 0 ? sensors[which].name
                                                  : sensors[which].keys[text.substr(at, equals - at)]) =
          text.substr(equals + 1, end - equals - 1);
    else
      which = 1;
    at = end + 1;
  }
  mm::fuzz::takes([&] { mm::makeTemperatureDevices(sensors, "/nosuch"); });
  return 0;
}
