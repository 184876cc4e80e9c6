// Anybody's table or log, without a word from the user.
#include "fuzz_support.h"
#include "import/import_file.h"
#include "session/artifact_file.h"

namespace {

const char* const kBalls =
    "name: two\npose: free\nprobe: {tip_radius_mm: 1.0}\nballs:\n"
    "  - {name: b1, centre_mm: [0, 0, 0], radius_mm: 3.9685}\n"
    "  - {name: b2, centre_mm: [12, 3, -1], radius_mm: 3.9685}\n";

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const mm::Machine three = mm::Machine::load("three_axis"), five = mm::Machine::load("five_axis");
  static const mm::Artifact artifact = mm::parseArtifact(kBalls, "balls.yaml");
  static mm::fuzz::MemoryFile file;
  mm::ImportRequest request;
  request.file = file.write(data, size);
  for (const mm::Machine* machine : {&three, &five}) {
    mm::Imported imported;
    mm::fuzz::takes([&] { mm::importFile(request, *machine, &artifact, imported); });
    mm::understoodText(imported);  // also of what was refused
  }
  return 0;
}
