#pragma once
#include <cstddef>
#include <filesystem>
#include <string>

#include "base/error.h"

namespace mm {

/// A file that is there but cannot be read now: a failing disk, no permission. What it holds is not known, so
/// that nothing may be concluded from it.
class UnreadableFile : public InputError {
 public:
  using InputError::InputError;
};

/// What a pipe or a device may give; one that gives more has no end (/dev/zero).
inline constexpr std::size_t kLongestStream = std::size_t{1} << 28;  // bytes

/// All bytes of a file, or none: what can be read only in part is refused, since half a model or half a table
/// is another one. Also of a pipe.
/// @param remedy ends the message: "check --artifact". @throw InputError naming file, cause and remedy: a
/// folder, no such file, a device without an end; UnreadableFile: a failing disk, no permission; Cancelled,
/// when a signal ends the wait for a pipe and the CancelScope was asked to stop.
std::string readWholeFile(const std::filesystem::path& file, const std::string& remedy);

/// At most `size` bytes of a regular file from `begin` on; fewer where it ends. @throw as readWholeFile.
std::string readPartOfFile(const std::filesystem::path& file, std::size_t begin, std::size_t size,
                           const std::string& remedy);

}  // namespace mm
