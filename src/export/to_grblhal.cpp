#include <string>

#include "base/format.h"
#include "base/units.h"
#include "export/printer_terms.h"
#include "export/targets.h"

namespace mm {
namespace {

constexpr double kGrblhalLeast = 1e-7;  // m: at 0.0001 mm and below grblHAL leaves backlash off

}  // namespace

Exported toGrblhal(const NeededCorrection& needed, const ExportOptions&) {
  Exported out;
  const std::string order = "xyzabc";
  std::string text;
  for (const auto& [axis, gap] :
       printerTerms(needed, {"grblHAL", order, kGrblhalLeast, false}, out).reversals)
    text += format("$%zu=%s\n", 160 + order.find(axis->letter), fixed(gap / kMillimetre, 4).c_str());
  out.files.push_back({"settings.txt", "backlash of each axis in mm, as $$ prints it", text});
  out.holds = "one reversal a joint";
  out.load = {"Use a build with ENABLE_BACKLASH_COMPENSATION; without it the settings do not exist.",
              "Send the lines of settings.txt; they stay in the controller's memory.",
              "Home: the direction of homing ($23) defines on which side of the backlash the axis is."};
  out.reference = "A reversal has no position; the zero of each axis is that of homing.";
  out.unverified = {
      "That the numbers of the settings are 160 and following is read from the sources; boards whose "
      "driver renames them were not looked at."};
  return out;
}

}  // namespace mm
