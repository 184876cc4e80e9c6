// grblHAL: motion_control.c (mc_backlash_init, mc_line), settings.h (Setting_AxisBacklash: 160 and up). The
// whole backlash is added before a move the other way. What stands at the beginning is the pull-off of
// homing, which runs against the search: towards minus where bit n of $23 is 0, towards plus where it is 1.
#include "base/text.h"
#include "interpreters/table_sum.h"
#include "interpreters/targets.h"

namespace mm {
namespace {

constexpr int kFirstBacklash = 160;
constexpr double kLeastBacklash = 0.0001;  // mm, deg: not above it, none is taken up
constexpr double kMostBacklash = 1e6;

}  // namespace

std::unique_ptr<Interpreter> interpretGrblhal(const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / "settings.txt";
  KeyedValues settings({file, 0});
  for (const TextLine& line : textLines(file)) {
    const std::string_view text = trim(line.text);
    const std::size_t equals = text.find('=');
    if (startsWith(text, "$") && equals != std::string_view::npos)
      settings.set(std::string(trim(text.substr(0, equals))),
                   trim(text.substr(equals + 1, text.find_first_of("(;", equals) - equals - 1)), line.place);
  }
  const int homing = settings.integer("$23", 0, 255, 0);
  std::vector<AxisTable> tables;
  for (int axis = 0; axis < 6; ++axis) {
    const double size = settings.number("$" + std::to_string(kFirstBacklash + axis), 0.0, 0.0, kMostBacklash);
    if (!(size > kLeastBacklash)) continue;
    const std::string joint(1, "xyzabc"[axis]);
    const double added = size * jointUnit(joint);
    const bool homesToMinus = (homing >> axis & 1) == 1;
    tables.push_back(reversal(joint, homesToMinus ? 0.0 : added, homesToMinus ? -added : 0.0));
  }
  return std::make_unique<TableSum>(std::move(tables));
}

}  // namespace mm
