// What linuxcncrsh answers: lines, and the round of questions that they belong to.
#include <cmath>
#include <sstream>

#include "drivers/linuxcnc_protocol.h"
#include "fuzz_support.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::istringstream lines(mm::fuzz::textOf(data, size));
  mm::LinuxCncRound round;
  round.asked = 1.0;  // else it is never complete
  for (std::string text; std::getline(lines, text);) {
    if (const auto line = mm::parseLinuxCncLine(text)) {
      if (line->word.empty()) mm::fuzz::broken("a line has a first word");
      round.take(*line);
      mm::LinuxCncRound::isLast(*line);
    }
    for (const double v : mm::parseLinuxCncNumbers(text))
      if (!std::isfinite(v)) mm::fuzz::broken("numbers are finite");
  }
  for (const auto* values : {&round.absolute, &round.commanded})
    for (const double v : *values)
      if (!std::isfinite(v)) mm::fuzz::broken("positions are finite");
  if (!std::isfinite(round.feedOverride)) mm::fuzz::broken("the override is finite");
  if (round.complete() && round.absolute.empty()) mm::fuzz::broken("a complete round has positions");
  return 0;
}
