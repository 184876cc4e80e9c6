#include "export/export_folder.h"

#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/read_file.h"
#include "base/temporary_folder.h"
#include "calibration_file/atomic_file.h"

namespace mm {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void refuse(const fs::path& folder, int cause) {
  throw InputError(folder.string() + ": cannot be written: " + std::strerror(cause) +
                   "; free disk space or choose another folder");
}

fs::path withoutSlash(const fs::path& folder) {
  return folder.filename().empty() ? folder.parent_path() : folder;
}

fs::path parentOf(const fs::path& folder) {
  const fs::path parent = withoutSlash(folder).parent_path();
  return parent.empty() ? fs::path(".") : parent;
}

/// What an earlier export says of itself; without a target: it is none.
ExportDescription earlierExport(const fs::path& folder) {
  try {
    return describeExport(folder);
  } catch (const UnreadableFile&) {
    throw;
  } catch (const InputError&) {
    return {};  // not one of ours
  }
}

}  // namespace

std::unique_ptr<const LoadedCompensation> triedExport(const std::string& target, const Exported& exported) {
  const TemporaryFolder folder;
  for (const ExportedFile& file : exported.files) folder.write(file.path, file.text);
  const nlohmann::json says{{"target", target}, {"sensors", exported.sensors}, {"touched", exported.axes}};
  folder.write(ExportDescription::kFile, says.dump());
  return std::make_unique<const LoadedCompensation>(target, folder.path());
}

void checkExportFolder(const fs::path& folder, const std::string& target, bool force) {
  std::error_code error;
  const std::string name = folder.string();
  if (!fs::is_directory(parentOf(folder), error))
    throw InputError("-o " + name + ": the folder '" + parentOf(folder).string() +
                     "' does not exist; make it, or name another");
  if (!fs::exists(fs::symlink_status(folder, error))) return;
  if (fs::is_symlink(withoutSlash(folder), error) || !fs::is_directory(folder, error))
    throw InputError("-o " + name + ": is not a folder; name a new one");
  const ExportDescription earlier = earlierExport(folder);
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string file = entry.path().filename().string();
    if (earlier.target.empty() || earlier.files.count(file) == 0)
      throw InputError("-o " + name + ": holds '" + file +
                       "', which is not from an export; name a new folder, or move it away");
  }
  if (!earlier.target.empty() && earlier.target != target && !force)
    throw InputError("-o " + name + ": holds an export for " + earlier.target + ", not for " + target +
                     "; name another folder, or replace it with --force");
}

void writeExportFolder(const fs::path& folder, const std::vector<ExportedFile>& files) {
  const fs::path parent = parentOf(folder), target = withoutSlash(folder);
  std::string own = parent / ("." + target.filename().string() + kTemporaryMark + "XXXXXX");
  if (::mkdtemp(own.data()) == nullptr) refuse(parent, errno);
  const fs::path made = own;
  std::error_code ignored;
  try {
    for (const ExportedFile& file : files) {
      if (const fs::path inside(file.path); inside.begin()->string() == ExportDescription::kKept)
        fs::create_directories((made / inside).parent_path());
      writeFileAtomically(made / file.path, file.text);
    }
    fs::permissions(made, fs::perms(0755));
    syncPath(made);
    if (!fs::exists(target)) {
      if (::rename(made.c_str(), target.c_str()) != 0) refuse(folder, errno);
    } else {
      // The two change names in one step; what was there goes afterwards.
      if (::renameat2(AT_FDCWD, made.c_str(), AT_FDCWD, target.c_str(), RENAME_EXCHANGE) != 0)
        refuse(folder, errno);
      fs::remove_all(made, ignored);
    }
  } catch (...) {
    fs::remove_all(made, ignored);
    throw;
  }
  syncPath(parent);
}

}  // namespace mm
