#pragma once
#include <string>
#include <vector>

#include "export/export_target.h"

namespace mm {

/// The files in one folder as a tar (POSIX.1-1988 ustar): what every system unpacks. Readable by everybody,
/// of the time of this moment. @throw InputError: a path of more than 100 letters.
std::string tarOf(const std::string& folder, const std::vector<ExportedFile>& files);

}  // namespace mm
