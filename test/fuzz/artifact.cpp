// Artifact files: what is read can be written, and is then read again.
#include "fuzz_support.h"
#include "session/artifact_file.h"
#include "session/plan_writer.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  mm::Artifact artifact;
  const auto parse = [&] { artifact = mm::parseArtifact(mm::fuzz::textOf(data, size), "artifact.yaml"); };
  if (!mm::fuzz::takes(parse)) return 0;
  const std::string written = mm::artifactYaml(artifact);
  mm::fuzz::mustTake([&] { mm::parseArtifact(written, "written.yaml"); }, written.c_str());
  return 0;
}
