#include "import/unit.h"

#include <cctype>
#include <vector>

#include "base/text.h"
#include "base/units.h"
#include "session/text_file.h"

namespace mm {
namespace {

constexpr double kInch = 25.4e-3;

struct Named {
  Unit unit;
  std::vector<const char*> names;  // normalised
};

const std::vector<Named>& units() {
  const auto u = [](UnitKind kind, double factor, const char* symbol, double offset = 0.0) {
    return Unit{kind, factor, offset, symbol};
  };
  static const std::vector<Named> kAll = {
      {u(UnitKind::kLength, kMillimetre, "mm"),
       {"mm", "millimetre", "millimetres", "millimeter", "millimeters"}},
      {u(UnitKind::kLength, kMicrometre, "um"),
       {"um", "micron", "microns", "micrometre", "micrometres", "micrometer", "micrometers", "mikrometer"}},
      {u(UnitKind::kLength, 1e-9, "nm"), {"nm", "nanometre", "nanometres", "nanometer", "nanometers"}},
      {u(UnitKind::kLength, 1e-2, "cm"), {"cm"}},
      {u(UnitKind::kLength, 1.0, "m"), {"m", "metre", "metres", "meter", "meters"}},
      {u(UnitKind::kLength, kInch, "inch"), {"inch", "in", "inches", "zoll", "\""}},
      {u(UnitKind::kLength, kInch * 1e-6, "uin"), {"uin", "uinch", "microinch", "microinches", "mikrozoll"}},
      {u(UnitKind::kLength, kInch * 1e-3, "mil"), {"mil", "mils", "thou"}},
      {u(UnitKind::kAngle, kDegree, "deg"), {"deg", "degs", "degree", "degrees"}},
      {u(UnitKind::kAngle, 1.0, "rad"), {"rad", "radian", "radians"}},
      {u(UnitKind::kAngle, 1e-3, "mrad"), {"mrad", "milliradian", "milliradians"}},
      {u(UnitKind::kAngle, 1e-6, "urad"), {"urad", "microradian", "microradians"}},
      {u(UnitKind::kAngle, kArcsecond, "arcsec"),
       {"arcsec", "arcsecs", "arcsecond", "arcseconds", "asec", "\""}},
      {u(UnitKind::kAngle, 60.0 * kArcsecond, "arcmin"),
       {"arcmin", "arcmins", "arcminute", "arcminutes", "amin", "'"}},
      {u(UnitKind::kTime, 1.0, "s"), {"s", "sec", "secs", "second", "seconds", "sek", "sekunden"}},
      {u(UnitKind::kTime, 1e-3, "ms"), {"ms", "msec", "millisecond", "milliseconds"}},
      {u(UnitKind::kTime, 1e-6, "us"), {"us", "usec", "microsecond", "microseconds"}},
      {u(UnitKind::kTime, 1e-9, "ns"), {"ns", "nsec", "nanosecond", "nanoseconds"}},
      {u(UnitKind::kTime, 60.0, "min"), {"min", "mins", "minute", "minutes", "m"}},
      {u(UnitKind::kTime, 3600.0, "h"), {"h", "hr", "hrs", "hour", "hours", "std"}},
      {u(UnitKind::kTemperature, 1.0, "degC"), {"degc", "c", "celsius"}},
      {u(UnitKind::kTemperature, 1.0, "K", -273.15), {"k", "degk", "kelvin"}},
      {u(UnitKind::kTemperature, 1.0 / 1.8, "degF", -32.0 / 1.8), {"degf", "f", "fahrenheit"}},
      {u(UnitKind::kSpeed, kMillimetre, "mm/s"), {"mm/s", "mm_s", "mm/sec"}},
      {u(UnitKind::kSpeed, kMillimetre / 60.0, "mm/min"), {"mm/min", "mm_min"}},
      {u(UnitKind::kSpeed, 1.0, "m/s"), {"m/s", "m_s"}},
      {u(UnitKind::kSpeed, 1.0 / 60.0, "m/min"), {"m/min", "m_min"}},
      {u(UnitKind::kSpeed, kMicrometre, "um/s"), {"um/s", "um_s"}},
      {u(UnitKind::kSpeed, kInch, "inch/s"), {"in/s", "inch/s", "in_s", "inch_s", "ips"}},
      {u(UnitKind::kSpeed, kInch / 60.0, "inch/min"), {"in/min", "inch/min", "in_min", "inch_min", "ipm"}},
      {u(UnitKind::kTurning, kDegree, "deg/s"), {"deg/s", "deg_s"}},
      {u(UnitKind::kTurning, 1.0, "rad/s"), {"rad/s", "rad_s"}},
      {u(UnitKind::kTurning, 2.0 * kPi / 60.0, "rpm"), {"rpm", "1/min", "rev/min"}},
  };
  return kAll;
}

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
  if (name.empty()) return std::nullopt;
  for (const Named& n : units()) {
    if (kind && n.unit.kind != *kind) continue;
    for (const char* known : n.names)
      if (name == known) return n.unit;
  }
  return std::nullopt;
}

std::string unitsOf(UnitKind kind) {
  switch (kind) {
    case UnitKind::kLength:
      return "a length (mm, um, m, inch)";
    case UnitKind::kAngle:
      return "an angle (deg, rad, mrad, arcmin, arcsec)";
    case UnitKind::kTime:
      return "a time (s, ms, us, ns, min, h)";
    case UnitKind::kTemperature:
      return "a temperature (degC, K, degF)";
    case UnitKind::kSpeed:
      return "a speed (mm/s, mm/min, m/s, inch/s)";
    case UnitKind::kTurning:
      return "a turning speed (deg/s, rad/s, rpm)";
    case UnitKind::kOther:
      break;
  }
  return "a unit";
}

}  // namespace mm
