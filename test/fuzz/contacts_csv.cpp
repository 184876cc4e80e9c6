// The package's own table: as a session, and as states.
#include "fuzz_support.h"
#include "read_contacts.h"
#include "session/artifact_file.h"

namespace {

const char* const kBalls =
    "name: two\npose: free\nprobe: {tip_radius_mm: 1.0}\nballs:\n"
    "  - {name: b1, centre_mm: [0, 0, 0], radius_mm: 3.9685}\n"
    "  - {name: b2, centre_mm: [12, 3, -1], radius_mm: 3.9685}\n";

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const mm::Machine machine = mm::Machine::load("five_axis");
  static const mm::Artifact artifact = mm::parseArtifact(kBalls, "balls.yaml");
  static mm::fuzz::MemoryFile file;
  const auto& path = file.write(data, size);
  mm::fuzz::takes([&] { mm::readContactsCsv(path, machine, &artifact); });
  mm::fuzz::takes([&] { mm::readStatesCsv(path, machine, nullptr); });
  return 0;
}
