// URDFs of machines.
#include "fuzz_support.h"
#include "machine/machine.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static mm::fuzz::MemoryFile file;
  const auto& path = file.write(data, size);
  mm::fuzz::takes([&] { mm::Machine::load(path.string()); });
  return 0;
}
