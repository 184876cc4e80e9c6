// Lines of grbl and grblHAL.
#include <cmath>

#include "drivers/grbl_protocol.h"
#include "fuzz_support.h"

namespace {

void allFinite(const std::vector<double>& values) {
  for (const double v : values)
    if (!std::isfinite(v)) mm::fuzz::broken("positions are finite");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string line = mm::fuzz::textOf(data, size);
  if (const auto report = mm::parseGrblReport(line)) {
    allFinite(report->machine);
    allFinite(report->work);
    allFinite(report->offset);
    if (report->machine.empty() && report->work.empty()) mm::fuzz::broken("a report has a position");
    const mm::GrblShows shows = report->shows();
    const bool rests =
        shows == mm::GrblShows::kRest || shows == mm::GrblShows::kHeld || shows == mm::GrblShows::kHeldByDoor;
    if (rests && report->moves()) mm::fuzz::broken("what rests does not move");
    mm::grblAlarm(report->substate);
  }
  if (const auto probe = mm::parseGrblProbe(line)) allFinite(probe->machine);
  if (const auto setting = mm::parseGrblSetting(line)) allFinite({setting->second});
  if (const auto answer = mm::parseGrblAnswer(line); answer && mm::grblError(*answer).text.empty())
    mm::fuzz::broken("every error has words");
  if (const auto alarm = mm::parseGrblAlarm(line); alarm && mm::grblAlarm(*alarm).text.empty())
    mm::fuzz::broken("every alarm has words");
  mm::isGrblWelcome(line);
  return 0;
}
