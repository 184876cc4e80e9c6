#pragma once
#include <array>
#include <cstdint>

#include "drivers/serial_address.h"
#include "drivers/temperature_device.h"

namespace mm {

/// How a temperature stands in registers of 16 bits.
struct RegisterLayout {
  enum class Type { kInt16, kUint16, kInt32, kFloat32 };
  Type type = Type::kInt16;
  bool lowWordFirst = false;                                                           // of two registers
  int count() const { return type == Type::kInt16 || type == Type::kUint16 ? 1 : 2; }  ///< registers
};
/// The number in as many registers as the layout has; NaN where a float is none.
double registerValue(const std::array<std::uint16_t, 2>& registers, const RegisterLayout& layout);

/// Where a line is: `serial:<device>:<baud>:<data bits><parity><stop bits>`, as serial:/dev/ttyUSB0:9600:8N1;
/// 9600 and 8N1 where they are not given. @throw InputError naming what is wrong with it.
SerialAddress parseModbusLine(const std::string& address);

/// Temperature modules on one line of Modbus RTU (libmodbus), several units, each with its registers. Keys of
/// a sensor: `modbus` (the line), `unit` (1 … 247), `register` (from 0), `function` (holding, input), `type`
/// (int16, uint16, int32, float32), `words` (high, low: which comes first), `scale`, `offset`, and of the
/// line `timeout` (s for an answer, 0.5). The line is opened when it is first read and after a failure.
class ModbusTemperatures final : public TemperatureDevice {
 public:
  /// @throw InputError naming what is wrong with the address.
  ModbusTemperatures(std::string address, SensorKeys& keys);
  ~ModbusTemperatures() override;
  /// @throw InputError naming the sensor: its keys, or a line that another sensor has with other settings.
  void add(const std::string& name, SensorKeys& keys);
  const std::string& device() const { return settings_.device; }  ///< `/dev/ttyUSB0`

 private:
  struct Line;
  struct Sensor {
    int unit = 1, first = 0;
    bool input = false;  // input registers, function 4; else holding registers, function 3
    RegisterLayout layout;
  };
  double readOne(std::size_t sensor) override;

  std::string address_;
  SerialAddress settings_;
  double timeout_ = 0.5;       // s
  bool timeoutGiven_ = false;  // by a sensor
  std::unique_ptr<Line> line_;
  std::vector<Sensor> sensors_;
};

}  // namespace mm
