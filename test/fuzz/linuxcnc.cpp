// What linuxcnc_helper tells, line by line.
#include <cmath>
#include <sstream>

#include "base/error.h"
#include "drivers/linuxcnc_state.h"
#include "fuzz_support.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::istringstream lines(mm::fuzz::textOf(data, size));
  for (std::string text; std::getline(lines, text);) {
    mm::LinuxCncLine line;
    try {
      line = mm::parseLinuxCncLine(text);
    } catch (const mm::Error&) {
      continue;
    }
    if (line.kind != mm::LinuxCncLine::Kind::kState) continue;
    const mm::LinuxCncState& state = line.state;
    for (const auto* values : {&state.actual, &state.commanded, &state.probed}) {
      if (values->size() != 6) mm::fuzz::broken("a state has six places");
      for (const double v : *values)
        if (!std::isfinite(v)) mm::fuzz::broken("positions are finite");
    }
    for (const double v : {state.time, state.within, state.linear, state.angular, state.override})
      if (!std::isfinite(v)) mm::fuzz::broken("numbers are finite");
  }
  return 0;
}
