#pragma once
#include <filesystem>
#include <string>

#include "session/session.h"

namespace mm {

/// Reads an artifact file: balls and points (mm), their uncertainty (um), the probe, whether pose and
/// positions are known. @throw InputError naming file, line and key for unknown or doubled keys and names,
/// wrong units, values that are not numbers, and bounds (radius > 0, standard deviations >= 0).
Artifact loadArtifact(const std::filesystem::path& file);

/// The same from text. @param source what messages call it.
Artifact parseArtifact(const std::string& yaml, const std::string& source);

}  // namespace mm
