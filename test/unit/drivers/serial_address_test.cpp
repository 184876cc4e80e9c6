#include "drivers/serial_address.h"

#include <gtest/gtest.h>

#include "base/error.h"
#include "drivers/device_link.h"
#include "drivers/modbus_temperature.h"
#include "session_files.h"

namespace mm {
namespace {

const char* const kByPath = "/dev/serial/by-path/pci-0000:00:14.0-usb-0:1:1.0-port0";

SerialAddress parsed(const std::string& address) { return parseSerialAddress(address, true, "so"); }

TEST(SerialAddress, APathMayHaveColonsOfItsOwn) {
  const std::string path = kByPath;
  for (const std::string prefix : {"serial:", ""}) {
    EXPECT_EQ(parsed(prefix + path).device, path);
    EXPECT_EQ(parsed(prefix + path).baud, 0);
    EXPECT_EQ(parsed(prefix + path + ":115200").device, path);
    EXPECT_EQ(parsed(prefix + path + ":115200").baud, 115200);
    const SerialAddress whole = parsed(prefix + path + ":19200:8E1");
    EXPECT_EQ(whole.device + " " + whole.bits, path + " 8E1");
    EXPECT_EQ(whole.baud, 19200);
  }
  EXPECT_EQ(parsed("/dev/ttyUSB0:9600").device, "/dev/ttyUSB0");
  EXPECT_EQ(parsed("/dev/ttyUSB0").device, "/dev/ttyUSB0");
}

TEST(SerialAddress, APathThatIsThereIsTakenAsItIsWritten) {
  const test::Folder folder;
  const std::string there = folder.write("line:9600", "").string();
  EXPECT_EQ(parsed(there).device, there);
  EXPECT_EQ(parsed(there).baud, 0);
  EXPECT_EQ(parsed(there + ":19200").device, there);
  EXPECT_EQ(parsed(there + ":19200").baud, 19200);
}

TEST(SerialAddress, WhatIsNoSpeedIsNamedWithItsBoundAndRemedy) {
  const auto refusal = [](const std::string& address) {
    return test::messageOf<InputError>([&] { parsed(address); });
  };
  EXPECT_EQ(refusal("serial:/dev/nosuch:12"),
            "address 'serial:/dev/nosuch:12': '12' is not a number from 300 to 4000000 (baud); behind a path "
            "that ends so, write the speed too");
  EXPECT_EQ(parsed("serial:/dev/nosuch:12:9600").device, "/dev/nosuch:12");
  EXPECT_NE(refusal("serial:/dev/nosuch:99999999999999999999").find("is not a number"), std::string::npos);
  EXPECT_NE(refusal("serial:/dev/nosuch:8N1").find("has a frame format but no baud rate before it"),
            std::string::npos);
  EXPECT_NE(refusal("serial:ttyUSB0").find("names no device, whose path begins with /"), std::string::npos);
  EXPECT_NE(refusal("serial:").find("names no device"), std::string::npos);
  EXPECT_NE(refusal("tcp:localhost:7").find("is not a serial line; write so"), std::string::npos);
}

TEST(SerialAddress, OfAControllerAndOfAModule) {
  const std::string path = kByPath;
  for (const std::string& address : {"serial:" + path, path + ":115200"}) {
    DeviceLink link(address, [](const std::string&, double) {});
    EXPECT_EQ(test::messageOf<Error>([&] { link.connect(1.0); }),
              address + ": cannot be opened: No such file or directory");
  }
  const SerialAddress line = parseModbusLine("serial:" + path + ":19200:7O2");
  EXPECT_EQ(line.device + " " + line.bits, path + " 7O2");
  EXPECT_EQ(line.baud, 19200);
  for (const char* bad : {"tcp:localhost", "tcp:localhost:", "tcp:localhost:0", "tcp:localhost:65536",
                          "tcp:localhost:99999999999", "usb:1", ""})
    EXPECT_NE(test::messageOf<InputError>([&] { DeviceLink(bad, [](const std::string&, double) {}); }), "")
        << bad;
}

}  // namespace
}  // namespace mm
