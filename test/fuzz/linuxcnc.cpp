// Lines of linuxcncrsh.
#include <cmath>

#include "drivers/linuxcnc_controller.h"
#include "fuzz_support.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text = mm::fuzz::textOf(data, size);
  if (const auto line = mm::parseLinuxCncLine(text)) {
    if (line->word.empty()) mm::fuzz::broken("a line has a first word");
    for (const double v : mm::parseLinuxCncNumbers(line->rest))
      if (!std::isfinite(v)) mm::fuzz::broken("numbers are finite");
  }
  for (const double v : mm::parseLinuxCncNumbers(text))
    if (!std::isfinite(v)) mm::fuzz::broken("numbers are finite");
  return 0;
}
