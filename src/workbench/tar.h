#pragma once
#include <string>
#include <vector>

#include "export/export_target.h"

namespace mm {

/// The files in one folder as a tar (POSIX.1-1988 ustar): what every system unpacks. Readable by everybody,
/// of the time of this moment. By hand: all that is needed of the format are files of known size and short
/// names, one fixed header each, for which a library of archives would be one more package on every machine.
/// @throw InputError: a path of more than 100 letters.
std::string tarOf(const std::string& folder, const std::vector<ExportedFile>& files);

}  // namespace mm
