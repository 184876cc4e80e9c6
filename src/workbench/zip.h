#pragma once
#include <string>
#include <vector>

#include "export/export_target.h"

namespace mm {

/// The files in one folder as a ZIP archive, which every system opens; readable by everybody, of the time of
/// this moment. @throw InputError: it cannot be written, with libarchive's reason.
std::string zipOf(const std::string& folder, const std::vector<ExportedFile>& files);

}  // namespace mm
