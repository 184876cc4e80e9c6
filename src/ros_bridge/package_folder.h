#pragma once
#include <filesystem>
#include <string>

namespace mm {

/// Folder of a package of ROS by its name, as `rospack find`; empty: none of that name, or no environment of
/// ROS. From any thread, one at a time.
std::filesystem::path packageFolder(const std::string& package);

}  // namespace mm
