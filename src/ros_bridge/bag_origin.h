#pragma once
#include <filesystem>
#include <string>

namespace mm {

/// How a bag came about, in words for people: "recorded on a machine", "imported from plate.csv" or
/// "simulated"; "damaged" when its index cannot be read, as a recording that was killed leaves it.
/// @throw UnreadableFile: the disk does not give it.
std::string bagOrigin(const std::filesystem::path& file);

}  // namespace mm
