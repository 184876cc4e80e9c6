#pragma once
#include <filesystem>
#include <string>

namespace mm {

/// Writes a file so that whoever is killed or runs out of disk at any moment leaves either the old file or
/// the new one, complete and on the disk: temporary file beside it, fsync, rename, fsync of the folder. What
/// is not a regular file (a pipe, /dev/stdout) is written directly. @throw InputError naming the file, the
/// cause and the remedy.
void writeFileAtomically(const std::filesystem::path& file, const std::string& text);

/// Makes what was renamed in a folder, or written to a file, survive a power cut. Some file systems cannot
/// sync: then it is as safe as it gets.
void syncPath(const std::filesystem::path& path);

/// Points the symbolic link to `target` (relative to the link's folder) in one step. @throw InputError.
void linkAtomically(const std::filesystem::path& link, const std::string& target);

/// @throw InputError when it cannot be read.
std::string readFile(const std::filesystem::path& file);

/// Part of the name of every temporary file, which starts with a dot.
inline constexpr const char* kTemporaryMark = ".mm-tmp-";

}  // namespace mm
