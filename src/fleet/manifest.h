#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "fleet/job.h"

namespace mm {

/// What `mm batch` is to do: the jobs of a manifest, in its order, with their keys.
struct Manifest {
  std::vector<BatchJob> jobs;
  std::vector<std::string> remarks;  // a line each: what is there twice, and is done once
};

/// Reads a manifest (docs/formats.md): sessions by name or glob, models, steps. Every file is read once, for
/// the keys. @throw InputError naming file, line and key: unknown keys and steps, a pattern that fits no
/// file, a file that is missing, a step that lacks its model or calibration, one session of two machines.
Manifest loadManifest(const std::filesystem::path& file);

}  // namespace mm
