#include "import/unit.h"

#include "base/text.h"
#include "base/units.h"
#include "session/csv_cells.h"

namespace mm {
namespace {

constexpr double kInch = 25.4e-3;

using K = UnitKind;

struct Named {
  UnitKind kind;
  double factor, offset;
  const char* symbol;
  std::string_view names;  // normalised
};

constexpr Named kUnits[] = {
    {K::kLength, kMillimetre, 0.0, "mm", "mm|millimetre|millimetres|millimeter|millimeters"},
    {K::kLength, kMicrometre, 0.0, "um",
     "um|micron|microns|micrometre|micrometres|micrometer|micrometers|mikrometer"},
    {K::kLength, 1e-9, 0.0, "nm", "nm|nanometre|nanometres|nanometer|nanometers"},
    {K::kLength, 1e-2, 0.0, "cm", "cm"},
    {K::kLength, 1.0, 0.0, "m", "m|metre|metres|meter|meters"},
    {K::kLength, kInch, 0.0, "inch", "inch|in|inches|zoll|\""},
    {K::kLength, kInch * 1e-6, 0.0, "uin", "uin|uinch|microinch|microinches|mikrozoll"},
    {K::kLength, kInch * 1e-3, 0.0, "mil", "mil|mils|thou"},
    {K::kAngle, kDegree, 0.0, "deg", "deg|degs|degree|degrees"},
    {K::kAngle, 1.0, 0.0, "rad", "rad|radian|radians"},
    {K::kAngle, 1e-3, 0.0, "mrad", "mrad|milliradian|milliradians"},
    {K::kAngle, 1e-6, 0.0, "urad", "urad|microradian|microradians"},
    {K::kAngle, kArcsecond, 0.0, "arcsec", "arcsec|arcsecs|arcsecond|arcseconds|asec|\""},
    {K::kAngle, 60.0 * kArcsecond, 0.0, "arcmin", "arcmin|arcmins|arcminute|arcminutes|amin|'"},
    {K::kTime, 1.0, 0.0, "s", "s|sec|secs|second|seconds|sek|sekunden"},
    {K::kTime, 1e-3, 0.0, "ms", "ms|msec|millisecond|milliseconds"},
    {K::kTime, 1e-6, 0.0, "us", "us|usec|microsecond|microseconds"},
    {K::kTime, 1e-9, 0.0, "ns", "ns|nsec|nanosecond|nanoseconds"},
    {K::kTime, 60.0, 0.0, "min", "min|mins|minute|minutes|m"},
    {K::kTime, 3600.0, 0.0, "h", "h|hr|hrs|hour|hours|std"},
    {K::kTemperature, 1.0, 0.0, "degC", "degc|c|celsius"},
    {K::kTemperature, 1.0, -273.15, "K", "k|degk|kelvin"},
    {K::kTemperature, 1.0 / 1.8, -32.0 / 1.8, "degF", "degf|f|fahrenheit"},
    {K::kSpeed, kMillimetre, 0.0, "mm/s", "mm/s|mm_s|mm/sec"},
    {K::kSpeed, kMillimetre / 60.0, 0.0, "mm/min", "mm/min|mm_min"},
    {K::kSpeed, 1.0, 0.0, "m/s", "m/s|m_s"},
    {K::kSpeed, 1.0 / 60.0, 0.0, "m/min", "m/min|m_min"},
    {K::kSpeed, kMicrometre, 0.0, "um/s", "um/s|um_s"},
    {K::kSpeed, kInch, 0.0, "inch/s", "in/s|inch/s|in_s|inch_s|ips"},
    {K::kSpeed, kInch / 60.0, 0.0, "inch/min", "in/min|inch/min|in_min|inch_min|ipm"},
    {K::kTurning, kDegree, 0.0, "deg/s", "deg/s|deg_s"},
    {K::kTurning, 1.0, 0.0, "rad/s", "rad/s|rad_s"},
    {K::kTurning, 2.0 * kPi / 60.0, 0.0, "rpm", "rpm|1/min|rev/min"},
};

void replaceAll(std::string& text, const std::string& from, const std::string& to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
    text.replace(at, from.size(), to);
}

/// Small letters, u for micro, deg for the sign of degrees, no blanks and points.
std::string normalised(std::string_view text) {
  std::string t = lower(trim(text));
  replaceAll(t, "\xC2\xB5", "u");
  replaceAll(t, "\xCE\xBC", "u");
  replaceAll(t, "\xC2\xB0", "deg");
  replaceAll(t, "\xC2\xBA", "deg");  // the ordinal sign, as some keyboards write it
  replaceAll(t, "\xE2\x80\xB3", "\"");
  replaceAll(t, "\xE2\x80\xB2", "'");
  replaceAll(t, "''", "\"");
  std::string plain;
  for (const char c : t)
    if (c != ' ' && c != '.') plain += c;
  return plain;
}

}  // namespace

std::optional<Unit> parseUnit(std::string_view text, std::optional<UnitKind> kind) {
  const std::string name = normalised(text);
  for (const Named& n : kUnits)
    if ((!kind || n.kind == *kind) && isOneOf(name, n.names))
      return Unit{n.kind, n.factor, n.offset, n.symbol};
  return std::nullopt;
}

const UnitKindFacts& factsOf(UnitKind kind) {
  static const UnitKindFacts kFacts[] = {
      {"a length (mm, um, m, inch)", {"mm", "um", "inch", "m"}},
      {"an angle (deg, rad, mrad, arcmin, arcsec)", {"deg", "arcsec", "rad"}},
      {"a time (s, ms, us, ns, min, h)", {"s", "ms", "min"}},
      {"a temperature (degC, K, degF)", {"degC", "K", "degF"}},
      {"a speed (mm/s, mm/min, m/s, inch/s)", {"mm_s", "mm_min", "m_min"}},
      {"a turning speed (deg/s, rad/s, rpm)", {"deg_s", "rad_s", "rpm"}}};
  return kFacts[static_cast<std::size_t>(kind)];
}

}  // namespace mm
