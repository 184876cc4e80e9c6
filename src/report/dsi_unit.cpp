#include "report/dsi_unit.h"

#include <map>
#include <sstream>

namespace mm {
namespace {

std::optional<std::string> dsiFactor(const std::string& name) {
  static const std::map<std::string, std::string> kNames = {
      {"1", ""},           {"um", "\\micro\\metre"},    {"mm", "\\milli\\metre"}, {"m", "\\metre"},
      {"deg", "\\degree"}, {"arcsec", "\\arcsecond"},   {"rad", "\\radian"},      {"mrad", "\\milli\\radian"},
      {"K", "\\kelvin"},   {"degC", "\\degreecelsius"}, {"s", "\\second"},        {"min", "\\minute"},
      {"h", "\\hour"},     {"%", "\\percent"}};
  const auto found = kNames.find(name);
  if (found == kNames.end()) return std::nullopt;
  return found->second;
}

}  // namespace

std::optional<std::string> dsiUnit(const std::string& unit) {
  std::istringstream parts(unit);
  std::string text;
  bool below = false;  // a fraction line
  for (std::string part; std::getline(parts, part, '/'); below = true) {
    const std::size_t raised = part.find('^');
    const std::string power = raised == std::string::npos ? "1" : part.substr(raised + 1);
    const std::optional<std::string> factor = dsiFactor(part.substr(0, raised));
    if (!factor || power.size() != 1 || power < "1" || power > "9") return std::nullopt;
    if (factor->empty()) continue;
    text += *factor;
    if (below || power != "1") text += "\\tothe{" + std::string(below ? "-" : "") + power + "}";
  }
  if (unit.empty() || unit.back() == '/') return std::nullopt;
  return text.empty() ? "\\one" : text;
}

}  // namespace mm
