#pragma once

namespace mm {

extern const char* const kVersion;  ///< of the package, as package.xml has it

}  // namespace mm
