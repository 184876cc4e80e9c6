#include "base/version.h"

namespace mm {

const char* const kVersion = MM_VERSION;

}  // namespace mm
