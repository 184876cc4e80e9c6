#pragma once
#include <cstddef>
#include <filesystem>
#include <string>

namespace mm {

/// What a pipe or a device may give; one that gives more has no end (/dev/zero).
inline constexpr std::size_t kLongestStream = std::size_t{1} << 28;  // bytes

/// All bytes of a file, or none: what can be read only in part is refused, since half a model or half a table
/// is another one. Also of a pipe.
/// @param remedy ends the message: "check --artifact". @throw InputError naming file, cause and remedy: a
/// folder, no such file, a failing disk, a device without an end.
std::string readWholeFile(const std::filesystem::path& file, const std::string& remedy);

}  // namespace mm
