#pragma once
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "export/export_target.h"

namespace mm {

/// What the controller would compensate with an export that nobody has been given yet. @throw InputError:
/// full disk.
std::unique_ptr<const LoadedCompensation> triedExport(const std::string& target, const Exported& exported);

/// Whether an export may be written there: nothing is, or an empty folder, or an earlier export for the same
/// target and nothing else. @param force also an export for another target. What no export has written is
/// never replaced.
/// @throw InputError: one line with the folder, why, and the remedy.
void checkExportFolder(const std::filesystem::path& folder, const std::string& target, bool force);

/// Writes all files, or none: beside the folder, to the disk, then renamed; an earlier export goes only when
/// the new one is in its place. @throw InputError: full disk, no permission.
void writeExportFolder(const std::filesystem::path& folder, const std::vector<ExportedFile>& files);

}  // namespace mm
