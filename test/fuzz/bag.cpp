// Bags, as a session.
#include <ros/console.h>

#include "fuzz_support.h"
#include "ros_bridge/bag_session.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const mm::Machine machine = mm::Machine::load("three_axis");
  static mm::fuzz::MemoryFile file;
  const auto& path = file.write(data, size);
  mm::fuzz::takes([&] { mm::readSessionBag(path, {}, &machine); });
  mm::fuzz::takes([&] { mm::bagSpace(path); });
  return 0;
}
