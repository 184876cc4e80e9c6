#include "drivers/modbus_temperature.h"

#include <modbus/modbus-rtu.h>
#include <modbus/modbus.h>

#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstring>
#include <thread>

#include "base/error.h"
#include "base/format.h"

namespace mm {

double registerValue(const std::array<std::uint16_t, 2>& registers, const RegisterLayout& layout) {
  using Type = RegisterLayout::Type;
  if (layout.type == Type::kUint16) return registers[0];
  if (layout.type == Type::kInt16) return static_cast<std::int16_t>(registers[0]);
  const std::uint32_t bits = static_cast<std::uint32_t>(registers[layout.lowWordFirst ? 1 : 0]) << 16 |
                             registers[layout.lowWordFirst ? 0 : 1];
  if (layout.type == Type::kInt32) return static_cast<std::int32_t>(bits);
  float value = 0.0F;
  std::memcpy(&value, &bits, sizeof value);
  return std::isfinite(value) ? value : std::numeric_limits<double>::quiet_NaN();
}

SerialAddress parseModbusLine(const std::string& address) {
  SerialAddress line =
      parseSerialAddress(address, true, "serial:<device>:<baud>:<bits>, as serial:/dev/ttyUSB0:9600:8N1");
  if (line.baud == 0) line.baud = 9600;
  if (line.bits.empty()) line.bits = "8N1";
  return line;
}

struct ModbusTemperatures::Line {
  explicit Line(modbus_t* made) : context(made) {}
  ~Line() {
    modbus_close(context);
    modbus_free(context);
  }
  Line(const Line&) = delete;
  Line& operator=(const Line&) = delete;
  modbus_t* context;
};

ModbusTemperatures::ModbusTemperatures(std::string address, SensorKeys& keys) : address_(std::move(address)) {
  try {
    settings_ = parseModbusLine(address_);
  } catch (const InputError& e) {
    keys.refuse(e.what());
  }
}

ModbusTemperatures::~ModbusTemperatures() = default;

void ModbusTemperatures::add(const std::string& name, SensorKeys& keys) {
  using Type = RegisterLayout::Type;
  Sensor sensor;
  const std::string address = keys.text("modbus", address_);
  if (!(parseModbusLine(address) == settings_))
    keys.refuse("its line " + address + " is " + address_ +
                " for another sensor; all sensors of a serial line share one setting");
  sensor.unit = keys.wholeNumber("unit", 1, 1, 247);
  sensor.input = keys.word("function", "holding", {"holding", "input"}) == "input";
  const std::string type = keys.word("type", "int16", {"int16", "uint16", "int32", "float32"});
  sensor.layout.type = type == "int16"    ? Type::kInt16
                       : type == "uint16" ? Type::kUint16
                       : type == "int32"  ? Type::kInt32
                                          : Type::kFloat32;
  sensor.first = keys.wholeNumber("register", 0, 0, 65536 - sensor.layout.count());
  sensor.layout.lowWordFirst = keys.word("words", "high", {"high", "low"}) == "low";
  addSensor(name, keys, type == "float32" ? 1.0 : 0.1);
  const double timeout = keys.number("timeout", timeout_, 0.01, 10.0);
  if (keys.has("timeout")) {
    if (timeoutGiven_ && timeout != timeout_)
      keys.refuse("its line has a timeout of " + format("%g", timeout_) +
                  " s for another sensor; give one value for the line");
    timeoutGiven_ = true;
    timeout_ = timeout;
  }
  sensors_.push_back(sensor);
}

double ModbusTemperatures::readOne(std::size_t i) {
  const Sensor& sensor = sensors_[i];
  const auto failed = [&](const char* doing) {
    const int cause = errno;
    const bool late = cause == ETIMEDOUT;
    const bool damaged = late || cause == EMBBADCRC || cause == EMBBADDATA || cause == EMBBADSLAVE;
    if (cause < MODBUS_ENOBASE && !late) {
      line_.reset();  // the device itself is gone
    } else if (line_ != nullptr && damaged) {
      // An answer that comes after its time would be taken for that of the next question: it bears no number.
      std::this_thread::sleep_for(std::chrono::duration<double>(timeout_));
      modbus_flush(line_->context);
    }
    return Error(address_ + ", unit " + std::to_string(sensor.unit) + ": " + doing + ": " +
                 (late ? "no answer in time" : modbus_strerror(cause)));
  };
  if (line_ == nullptr) {
    const std::string& bits = settings_.bits;
    line_ = std::make_unique<Line>(
        modbus_new_rtu(settings_.device.c_str(), settings_.baud, bits[1], bits[0] - '0', bits[2] - '0'));
    if (line_->context == nullptr) throw failed("cannot be opened");
    const double whole = std::floor(timeout_);
    modbus_set_response_timeout(line_->context, static_cast<std::uint32_t>(whole),
                                static_cast<std::uint32_t>(1e6 * (timeout_ - whole)));
    if (modbus_connect(line_->context) != 0) throw failed("cannot be opened");
  }
  modbus_flush(line_->context);
  modbus_set_slave(line_->context, sensor.unit);
  std::array<std::uint16_t, 2> registers{};
  const int count = sensor.layout.count();
  const int got = sensor.input
                      ? modbus_read_input_registers(line_->context, sensor.first, count, registers.data())
                      : modbus_read_registers(line_->context, sensor.first, count, registers.data());
  if (got != count) throw failed("cannot be read");
  const double value = registerValue(registers, sensor.layout);
  if (std::isnan(value)) throw Error(address_ + ": its registers hold no number");
  return value;
}

}  // namespace mm
