#include "drivers/temperature_device.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <fstream>
#include <thread>

#include "base/error.h"
#include "device_double.h"
#include "drivers/modbus_temperature.h"
#include "drivers/sysfs_temperature.h"
#include "session_files.h"

namespace mm {
namespace {

namespace fs = std::filesystem;

std::string refusal(std::vector<TemperatureSetup> sensors) {
  return test::messageOf<InputError>([&] { makeTemperatureDevices(sensors, "/nosuch"); });
}

TEST(TemperatureSetups, WhatIsWrongIsNamed) {
  const std::vector<std::pair<std::map<std::string, std::string>, std::string>> wrong = {
      {{}, "hwmon, iio, file or modbus"},
      {{{"hwmon", "a"}, {"iio", "b"}}, "hwmon, iio, file or modbus"},
      {{{"hwmon", "a"}, {"chanel", "temp1"}}, "'chanel' is unknown; did you mean 'channel'"},
      {{{"hwmon", "a"}, {"channel", "../temp1"}}, "not a path"},
      {{{"hwmon", "a"}, {"scale", "1,5"}}, "'scale' is '1,5', but must be a number from"},
      {{{"iio", ""}}, "need names"},
      {{{"file", "temperature"}}, "begins with /"},
      {{{"modbus", "tcp:localhost"}}, "is not a serial line; write serial:<device>:<baud>:<bits>"},
      {{{"modbus", "serial:ttyUSB0"}}, "names no device"},
      {{{"modbus", "serial:/dev/ttyUSB0:12"}}, "'12' is not a number from 300 to 4000000"},
      {{{"modbus", "serial:/dev/ttyUSB0:9600:8X1"}}, "'8X1' is not 8N1"},
      {{{"modbus", "serial:/dev/ttyUSB0"}, {"unit", "0"}},
       "'unit' is '0', but must be a number from 1 to 247"},
      {{{"modbus", "serial:/dev/ttyUSB0"}, {"register", "65536"}}, "'register' is '65536'"},
      {{{"modbus", "serial:/dev/ttyUSB0"}, {"unit", "1.9"}}, "'unit' is 1.9, but must be a whole number"},
      {{{"modbus", "serial:/dev/ttyUSB0"}, {"register", "65535"}, {"type", "float32"}},
       "'register' is '65535', but must be a number from 0 to 65534"},
      {{{"modbus", "serial:/dev/ttyUSB0"}, {"function", "coil"}}, "must be one of holding, input"},
      {{{"modbus", "serial:/dev/ttyUSB0"}, {"type", "double"}},
       "must be one of int16, uint16, int32, float32"},
  };
  for (const auto& [keys, words] : wrong) {
    const std::string said = refusal({{"bed", keys}});
    EXPECT_EQ(said.rfind("sensor 'bed': ", 0), 0u) << said;
    EXPECT_NE(said.find(words), std::string::npos) << said << " lacks: " << words;
  }
  EXPECT_NE(refusal({{"bed", {{"hwmon", "a"}}}, {"bed", {{"hwmon", "b"}}}}).find("appears twice"),
            std::string::npos);
  EXPECT_NE(refusal({{"", {{"hwmon", "a"}}}}).find("no name"), std::string::npos);
}

TEST(TemperatureSetups, OneDeviceForAllFilesAndOneForEachLine) {
  const auto devices = makeTemperatureDevices({{"a", {{"hwmon", "one"}}},
                                               {"b", {{"modbus", "serial:/dev/nosuch0"}, {"unit", "3"}}},
                                               {"c", {{"iio", "two"}}},
                                               {"d", {{"modbus", "serial:/dev/nosuch0"}, {"unit", "4"}}},
                                               {"e", {{"modbus", "serial:/dev/nosuch1"}}}},
                                              "/nosuch");
  ASSERT_EQ(devices.size(), 3u);
  EXPECT_EQ(devices[0]->names(), (std::vector<std::string>{"a", "c"}));
  EXPECT_EQ(devices[1]->names(), (std::vector<std::string>{"b", "d"}));
  for (const auto& device : devices)
    for (const TemperatureReading& r : device->read()) {
      EXPECT_TRUE(std::isnan(r.value));
      EXPECT_NE(r.wrong, "");
    }
}

// Two ways to write a line are one line: two programs on it would take each other's answers.
TEST(TemperatureSetups, OneLineHasOneSetting) {
  const auto lines = [](std::map<std::string, std::string> one, std::map<std::string, std::string> two) {
    one["modbus"] = "serial:/dev/nosuch0";
    return std::vector<TemperatureSetup>{{"a", one}, {"b", two}};
  };
  EXPECT_EQ(makeTemperatureDevices(lines({}, {{"modbus", "serial:/dev/nosuch0:9600:8N1"}}), "/nosuch").size(),
            1u);
  const std::string baud = refusal(lines({}, {{"modbus", "serial:/dev/nosuch0:19200"}}));
  EXPECT_NE(baud.find("all sensors of a serial line share one setting"), std::string::npos) << baud;
  const std::string time =
      refusal(lines({{"timeout", "0.2"}}, {{"modbus", "serial:/dev/nosuch0"}, {"timeout", "0.3"}}));
  EXPECT_NE(time.find("timeout of 0.2 s for another sensor"), std::string::npos) << time;
}

TEST(SysfsTemperature, NumbersOfTheKernel) {
  EXPECT_EQ(parseSysfsNumber("23125\n"), 23125.0);
  EXPECT_EQ(parseSysfsNumber("-0.5"), -0.5);
  for (const char* bad : {"", "\n", "23 125", "0x10", "nan", "inf", "1e999", "12\n\n", "23125 m"})
    EXPECT_FALSE(parseSysfsNumber(bad)) << bad;
  EXPECT_FALSE(parseSysfsNumber(std::string(100, '1')));
}

class MadeUpTree : public ::testing::Test {
 protected:
  void write(const std::string& file, const std::string& text) {
    const fs::path path = folder_.path(file);
    fs::create_directories(path.parent_path());
    std::ofstream(path) << text;
  }
  TemperatureReading read(const std::map<std::string, std::string>& keys) {
    return makeTemperatureDevices({{"bed", keys}}, folder_.path("").string())[0]->read()[0];
  }
  test::Folder folder_;
};

TEST_F(MadeUpTree, ScaleAndOffsetAsTheKernelDocumentsThem) {
  write("class/hwmon/hwmon0/name", "other\n");
  write("class/hwmon/hwmon3/name", "bench\n");
  write("class/hwmon/hwmon3/temp1_input", "21250\n");
  write("class/hwmon/hwmon4/name", "bench\n");
  write("class/hwmon/hwmon4/temp1_input", "-3000\n");
  EXPECT_EQ(read({{"hwmon", "bench"}}).value, 21.25);
  EXPECT_EQ(read({{"hwmon", "bench"}, {"number", "1"}}).value, -3.0);
  EXPECT_EQ(read({{"hwmon", "bench"}, {"scale", "2"}, {"offset", "-1.5"}}).value, 41.0);
  write("bus/iio/devices/iio:device0/name", "bme280\n");
  write("bus/iio/devices/iio:device0/in_temp_raw", "8700\n");
  EXPECT_NE(read({{"iio", "bme280"}}).wrong.find("in_temp_scale"), std::string::npos);
  write("bus/iio/devices/iio:device0/in_temp_scale", "2.5\n");
  EXPECT_DOUBLE_EQ(read({{"iio", "bme280"}}).value, 21.75);
  write("bus/iio/devices/iio:device0/in_temp_offset", "-200\n");
  EXPECT_DOUBLE_EQ(read({{"iio", "bme280"}}).value, 21.25);
  write("bus/iio/devices/iio:device0/in_temp_input", "22500\n");
  EXPECT_DOUBLE_EQ(read({{"iio", "bme280"}}).value, 22.5) << "what the driver has worked out itself";
  write("w1/temperature", "19875\n");
  EXPECT_DOUBLE_EQ(read({{"file", folder_.path("w1/temperature").string()}}).value, 19.875);
}

TEST_F(MadeUpTree, WhatIsWrongIsSaidAndNotReplaced) {
  write("class/hwmon/hwmon0/name", "bench\n");
  const auto expect = [&](const std::map<std::string, std::string>& keys, const std::string& words) {
    const TemperatureReading r = read(keys);
    EXPECT_TRUE(std::isnan(r.value));
    EXPECT_NE(r.wrong.find(words), std::string::npos) << r.wrong;
  };
  expect({{"hwmon", "bench"}}, "temp1_input: cannot be read: No such file");
  expect({{"hwmon", "bank"}}, "there is no 'bank'; there are: bench");
  expect({{"iio", "bank"}}, "there is no 'bank'; there are: none");
  write("class/hwmon/hwmon0/temp1_input", "2\x01 garbage");
  expect({{"hwmon", "bench"}}, "holds '2? garbage', not a number");
  write("class/hwmon/hwmon0/temp1_input", "20000\n");
  write("class/hwmon/hwmon0/temp1_fault", "1\n");
  expect({{"hwmon", "bench"}}, "reports a fault");
}

TEST(ModbusTemperature, RegistersInEveryLayout) {
  using Type = RegisterLayout::Type;
  EXPECT_EQ(registerValue({0xFFFE, 0}, {Type::kInt16, false}), -2.0);
  EXPECT_EQ(registerValue({0xFFFE, 0}, {Type::kUint16, false}), 65534.0);
  EXPECT_EQ(registerValue({0xFFFF, 0xFFFE}, {Type::kInt32, false}), -2.0);
  EXPECT_EQ(registerValue({0xFFFE, 0xFFFF}, {Type::kInt32, true}), -2.0);
  EXPECT_EQ(registerValue({0x41A8, 0x0000}, {Type::kFloat32, false}), 21.0);
  EXPECT_EQ(registerValue({0x0000, 0x41A8}, {Type::kFloat32, true}), 21.0);
  EXPECT_TRUE(std::isnan(registerValue({0x7F80, 0x0000}, {Type::kFloat32, false})));
}

TEST(ModbusTemperature, TheDoubleUnderEveryFault) {
  DeviceDouble line({"test/doubles/modbus_double.py"});
  const std::string address = line.address() + ":19200:8N1";
  const auto devices = makeTemperatureDevices(
      {{"bed", {{"modbus", address}, {"scale", "0.01"}, {"timeout", "0.2"}}},
       {"motor", {{"modbus", address}, {"register", "2"}, {"type", "float32"}}},
       {"air",
        {{"modbus", address}, {"unit", "2"}, {"register", "5"}, {"function", "input"}, {"offset", "30"}}},
       {"nobody", {{"modbus", address}, {"unit", "9"}}},
       {"wrong", {{"modbus", address}, {"register", "70"}}}},
      "/nosuch");
  ASSERT_EQ(devices.size(), 1u);
  // Three times where the computer held the double up for longer than an answer may take.
  const auto expectReads = [&] {
    auto r = devices[0]->read();
    for (int i = 0; i < 2 && (std::isnan(r[0].value) || std::isnan(r[1].value) || std::isnan(r[2].value));
         ++i)
      r = devices[0]->read();
    ASSERT_EQ(r.size(), 5u);
    EXPECT_NEAR(r[0].value, 20.5, 0.51) << r[0].wrong;
    EXPECT_NEAR(r[1].value, 21.5, 0.51) << r[1].wrong;
    EXPECT_NEAR(r[2].value, 20.5, 0.61) << r[2].wrong;
    EXPECT_NE(r[3].wrong.find("unit 9: cannot be read: no answer in time"), std::string::npos) << r[3].wrong;
    EXPECT_NE(r[4].wrong.find("Illegal data address"), std::string::npos) << r[4].wrong;
  };
  expectReads();
  for (const char* fault : {"off", "garbage", "slow"}) {  // slower than it may be
    line.tell(std::string("fault ") + fault);
    for (const TemperatureReading& r : devices[0]->read()) {
      EXPECT_TRUE(std::isnan(r.value)) << fault << ": " << r.value;
      EXPECT_NE(r.wrong, "");
    }
    line.tell("fault ok");
    // What came late is not taken for the answer to the next question.
    const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(10);
    while (line.tell("line")["waiting"] > 0) ASSERT_LT(std::chrono::steady_clock::now(), until);
    expectReads();
  }
  line.tell("fault wrong");
  EXPECT_NEAR(devices[0]->read()[0].value, 40.5, 0.51) << "who reads cannot know; the node sees the jump";
}

}  // namespace
}  // namespace mm
