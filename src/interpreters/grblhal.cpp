// grblHAL: motion_control.c (mc_backlash_init, mc_line), settings.h (Setting_AxisBacklash: 160 and up). The
// whole backlash is added before a move the other way. What stands at the beginning is the pull-off of
// homing, which runs against the search: towards minus where bit n of $23 is 0, towards plus where it is 1.
#include <array>

#include "base/text.h"
#include "interpreters/table_sum.h"
#include "interpreters/targets.h"

namespace mm {
namespace {

constexpr std::array<const char*, 6> kGrblAxes = {"x", "y", "z", "a", "b", "c"};
constexpr int kFirstBacklash = 160, kHomingDirections = 23;
constexpr double kLeastBacklash = 0.0001;  // mm, deg: not above it, none is taken up

struct GrblSetting {
  int number = 0;
  std::string value;
};

/// @return false for a line that is no `$n=value`.
bool readGrblSetting(const TextLine& line, GrblSetting& setting) {
  const std::string_view text = trim(line.text);
  const std::size_t equals = text.find('=');
  if (text.empty() || text[0] != '$' || equals == std::string_view::npos) return false;
  const std::string number(trim(text.substr(1, equals - 1)));
  if (number.empty() || number.find_first_not_of("0123456789") != std::string::npos) return false;
  setting.number = tableInteger(number, line.place, "number of the setting", 0, 100000);
  setting.value = trim(text.substr(equals + 1, text.find_first_of("(;", equals) - equals - 1));
  return true;
}

}  // namespace

std::unique_ptr<Interpreter> interpretGrblhal(const std::filesystem::path& folder) {
  int homing = 0;
  std::array<double, kGrblAxes.size()> backlash{};
  GrblSetting setting;
  for (const TextLine& line : textLines(folder / "settings.txt")) {
    if (!readGrblSetting(line, setting)) continue;
    const std::string field = "$" + std::to_string(setting.number);
    if (setting.number == kHomingDirections) homing = tableInteger(setting.value, line.place, field, 0, 255);
    const int axis = setting.number - kFirstBacklash;
    if (axis >= 0 && axis < static_cast<int>(kGrblAxes.size())) {
      constexpr double kMost = 1e6;
      backlash[axis] = tableNumber(setting.value, line.place, field, 0.0, kMost);
    }
  }
  std::vector<AxisTable> tables;
  for (std::size_t axis = 0; axis < kGrblAxes.size(); ++axis) {
    if (!(backlash[axis] > kLeastBacklash)) continue;
    const double size = backlash[axis] * jointUnit(kGrblAxes[axis]);
    const bool homesToMinus = (homing >> axis & 1) == 1;
    tables.push_back({kGrblAxes[axis], kGrblAxes[axis], Curve(homesToMinus ? 0.0 : size),
                      Curve(homesToMinus ? -size : 0.0)});
  }
  return std::make_unique<TableSum>(std::move(tables));
}

}  // namespace mm
