#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <optional>

#include "base/format.h"
#include "base/range.h"
#include "base/text.h"
#include "base/units.h"
#include "import/record_table.h"
#include "session/time_stamp.h"

namespace mm {
namespace {

struct Touch {
  std::size_t line = 0;
  double x = 0.0, y = 0.0, z = 0.0;   // mm
  double speed = kNotMeasured;        // mm/s, of the probing move downwards
  std::optional<std::int64_t> stamp;  // ns since 1970, or of the day
  bool calendar = true;               // stamp has a date
};

/// The time at the beginning of a line of a log, as OctoPrint and other hosts write it: with the date, or of
/// the day alone.
void stamp(std::string_view line, Touch& t) {
  line = trim(line);
  if (!line.empty() && line.front() == '[') line.remove_prefix(1);
  for (const std::size_t length : {26u, 23u, 19u})
    if (line.size() > length)
      if (const auto found = parseCalendar(line.substr(0, length))) {
        t.stamp = found;
        return;
      }
  t.calendar = false;
  t.stamp = parseClock(line.substr(0, line.find_first_of(" ]\t")));
}

/// The number behind `name` in a line (`X:12.5`, `X 12.5`, `X12.5`).
bool after(const std::string& line, const std::string& name, double& value) {
  const std::size_t at = line.find(name);
  if (at == std::string::npos) return false;
  std::size_t begin = at + name.size();
  while (begin < line.size() && (line[begin] == ' ' || line[begin] == ':' || line[begin] == '=')) ++begin;
  const std::size_t end = std::min(line.size(), line.find_first_not_of("+-.0123456789", begin));
  return parseNumber(line.substr(begin, end - begin), false, value);
}

/// The touches that a log tells, a line each. @param told fills one from a line; false: it tells of none.
template <typename Told>
std::vector<Touch> touchesOf(const TextFile& file, const Told& told) {
  std::vector<Touch> touches;
  for (std::size_t n = 1; n <= file.lines().size(); ++n) {
    const std::string line(file.lines()[n - 1]);
    Touch t;
    t.line = n;
    if (!told(line, t)) continue;
    stamp(line, t);
    touches.push_back(t);
  }
  return touches;
}

std::vector<Touch> klipperTouches(const TextFile& file) {
  double speed = kNotMeasured;
  return touchesOf(file, [&](const std::string& line, Touch& t) {
    if (line.find("PROBE_ACCURACY") != std::string::npos) {
      speed = kNotMeasured;
      after(line, " speed", speed);
    }
    t.speed = speed;
    const std::size_t at = line.find("probe at ");
    return at != std::string::npos &&
           std::sscanf(line.c_str() + at, "probe at %lf,%lf is z=%lf", &t.x, &t.y, &t.z) == 3;
  });
}

/// The meshes that SAVE_CONFIG leaves in printer.cfg, behind `#*#`: rows from min_y up, from min_x on.
std::vector<Touch> savedMesh(const TextFile& file) {
  std::vector<Touch> touches;
  std::vector<std::pair<std::size_t, std::vector<double>>> rows;
  std::map<std::string, double> keys;
  const auto finish = [&] {
    const bool all =
        keys.count("min_x") + keys.count("max_x") + keys.count("min_y") + keys.count("max_y") == 4;
    for (std::size_t r = 0; all && r < rows.size(); ++r)
      for (std::size_t c = 0; c < rows[r].second.size(); ++c) {
        const auto part = [](std::size_t i, std::size_t n) {
          return n > 1 ? static_cast<double>(i) / static_cast<double>(n - 1) : 0.0;
        };
        Touch t;
        t.line = rows[r].first;
        t.x = keys["min_x"] + part(c, rows[r].second.size()) * (keys["max_x"] - keys["min_x"]);
        t.y = keys["min_y"] + part(r, rows.size()) * (keys["max_y"] - keys["min_y"]);
        t.z = rows[r].second[c];
        touches.push_back(t);
      }
    rows.clear();
    keys.clear();
  };
  bool inMesh = false, inPoints = false;
  for (std::size_t n = 1; n <= file.lines().size(); ++n) {
    std::string_view line = trim(file.lines()[n - 1]);
    if (line.substr(0, 3) != "#*#") continue;
    line = trim(line.substr(3));
    if (!line.empty() && line.front() == '[') {
      finish();
      inMesh = line.substr(0, 9) == "[bed_mesh";
      inPoints = false;
      continue;
    }
    if (!inMesh || line.empty()) continue;
    if (const std::size_t equals = line.find('='); equals != std::string_view::npos) {
      const std::string key(trim(line.substr(0, equals)));
      inPoints = key == "points";
      double number = 0.0;
      if (parseNumber(line.substr(equals + 1), false, number)) keys[key] = number;
      continue;
    }
    if (!inPoints) continue;
    const std::vector<double> numbers = numbersIn(line, kListMarks);
    if (!numbers.empty()) rows.emplace_back(n, numbers);
  }
  finish();
  return touches;
}

std::vector<Touch> marlinTouches(const TextFile& file, bool& placeUnknown) {
  double x = kNotMeasured, y = kNotMeasured;
  placeUnknown = false;
  return touchesOf(file, [&](const std::string& line, Touch& t) {
    if (const std::size_t at = line.find("M48 ");
        at != std::string::npos && line.find("Repeatability") == std::string::npos) {
      x = y = kNotMeasured;
      after(line.substr(at + 4), "X", x);
      after(line.substr(at + 4), "Y", y);
    }
    if (const std::size_t at = line.find("Bed X:"); at != std::string::npos) {
      const std::string rest = line.substr(at + 4);
      return after(rest, "X:", t.x) && after(rest, "Y:", t.y) && after(rest, "Z:", t.z);
    }
    int index = 0, of = 0;
    const std::size_t sample = line.find(" of ");
    if (sample == std::string::npos || line.find("mean:") == std::string::npos) return false;
    const std::size_t begin = line.find_last_not_of("0123456789", sample - (sample > 0 ? 1 : 0));
    const std::string text = line.substr(begin == std::string::npos ? 0 : begin + 1);
    if (std::sscanf(text.c_str(), "%d of %d: z: %lf", &index, &of, &t.z) != 3) return false;
    t.x = x;
    t.y = y;
    placeUnknown = placeUnknown || std::isnan(x) || std::isnan(y);
    return true;
  });
}

class BedSession {
 public:
  BedSession(ImportContext& context, std::vector<Touch> touches)
      : context_(context), touches_(std::move(touches)) {}

  void make() {
    const Machine& machine = context_.machine;
    x_ = jointOf(machine, "x");
    y_ = jointOf(machine, "y");
    z_ = jointOf(machine, "z");
    if (x_ < 0 || y_ < 0 || z_ < 0) {
      context_.refuse("bed probing needs a machine with joints x, y and z; '" + machine.name() +
                      "' lacks at least one");
      return;
    }
    if (touches_.empty()) {
      context_.refuse("it contains no probing of the bed");
      return;
    }
    const std::string surface = context_.mapping.setting("surface");
    if (!surface.empty() && surface != "flat" && surface != "unknown") {
      context_.faults.add(context_.mapping.place("surface") + "surface is '" + surface +
                          "', but must be flat or unknown");
      return;
    }
    const bool flat = surface == "flat";
    if (flat || repeated()) session(flat);
  }

 private:
  static std::pair<long, long> place(const Touch& t) {
    return {std::lround(t.x * 1000.0), std::lround(t.y * 1000.0)};
  }

  /// A bed of unknown form tells something only where one place was touched again.
  bool repeated() {
    std::map<std::pair<long, long>, int> counts;
    for (const Touch& t : touches_) ++counts[place(t)];
    const auto again =
        std::count_if(counts.begin(), counts.end(), [](const auto& c) { return c.second > 1; });
    if (again > 0) {
      context_.note(
          format("%zu points on the bed, %ld of them probed again; the form of the bed is unknown, so each "
                 "point has its own unknown height: the data show repeatability and drift, not the geometry "
                 "of the machine (surface: flat, if the bed is a reference)",
                 counts.size(), static_cast<long>(again)));
      return true;
    }
    context_.refuse(
        format("%zu points on the bed, each probed once: the form of the bed cannot be separated from the "
               "error of the machine; if the bed is a flat reference (a glass or granite plate), ",
               counts.size()) +
        context_.ask("surface", "flat") + "; otherwise probe points repeatedly");
    return false;
  }

  /// Whether all touches have times of one kind; times of the day are made to go on after midnight.
  bool clocked() {
    RowClock clock;
    for (Touch& t : touches_) {
      if (!t.stamp || t.calendar != touches_.front().calendar) return false;
      if (!t.calendar) t.stamp = clock.afterMidnight(*t.stamp);
      clock.saw(*t.stamp);
    }
    return true;
  }

  void session(bool flat) {
    const bool stamped = clocked(), dated = stamped && touches_.front().calendar;
    Session session = emptySession(context_, !dated);
    if (dated) session.epoch = secondsBetween(0, *touches_.front().stamp);
    Range heights;
    for (const Touch& t : touches_) heights.add(t.z);
    for (std::size_t i = 0; i < touches_.size(); ++i) {
      const Touch& t = touches_[i];
      Observation o =
          blankRow(context_, ObservationKind::kDeviation, t.line,
                   stamped ? secondsBetween(*touches_.front().stamp, *t.stamp) : static_cast<double>(i));
      o.position[x_] = t.x * kMillimetre;
      o.position[y_] = t.y * kMillimetre;
      // the surface is at one height, and z stands there at every touch: what it reads, with the sign
      // changed, is true minus indicated, and not a way that it went
      o.position[z_] = 0.5 * (heights.lower + heights.upper) * kMillimetre;
      o.deviation[z_] = -t.z * kMillimetre;
      if (!std::isnan(t.speed)) o.velocity[z_] = -t.speed * kMillimetre;
      o.travel[z_] = -1.0;  // a probe touches on its way down
      o.setup = setupIndex(session, flat ? "bed" : format("bed at %.3f,%.3f", t.x, t.y));
      session.observations.push_back(std::move(o));
    }
    context_.imported.columns.push_back(
        {"z at the trigger", "with opposite sign, the deviation of z from the bed", "mm", heights.lower,
         heights.upper, format("%.6g", touches_.front().z), ""});
    if (flat)
      context_.note(
          "the bed is assumed flat, with unknown height: its tilt appears as squareness of z to x and y, its "
          "form as straightness");
    if (!stamped) session.timesAssumed = kTimesInOrder;
    if (!stamped)
      context_.note("no times: rows are taken in the order of probing; no effect of time can be told");
    finishImport(context_, std::move(session));
  }

  ImportContext& context_;
  std::vector<Touch> touches_;
  int x_ = -1, y_ = -1, z_ = -1;
};

bool anyLine(const TextFile& file, const char* words, const char* more = "") {
  return std::any_of(file.lines().begin(), file.lines().end(), [&](std::string_view line) {
    const std::size_t at = line.find(words);
    return at != std::string_view::npos && line.find(more, at) != std::string_view::npos;
  });
}

}  // namespace

bool isKlipperLog(const TextFile& file) {
  return anyLine(file, "probe at ", " is z=") || anyLine(file, "#*# [bed_mesh") ||
         anyLine(file, "Mesh Leveling Probed Z");
}

void readKlipperLog(ImportContext& context) {
  std::vector<Touch> touches = klipperTouches(context.file);
  if (touches.empty()) touches = savedMesh(context.file);
  if (touches.empty()) {
    context.refuse(
        "it contains the heights of a mesh but not the probed positions; give the log of the calibration "
        "(`probe at x,y is z=`), or printer.cfg with the saved mesh");
    return;
  }
  context.imported.how = std::to_string(touches.size()) + " touches of the bed by Klipper";
  BedSession(context, std::move(touches)).make();
}

bool isMarlinLog(const TextFile& file) {
  return anyLine(file, "Bed X:", "Z:") || (anyLine(file, " of ", "mean:") && anyLine(file, "z:", "sigma"));
}

void readMarlinLog(ImportContext& context) {
  bool placeUnknown = false;
  std::vector<Touch> touches = marlinTouches(context.file, placeUnknown);
  if (placeUnknown) {
    const std::vector<double> place = numbersIn(context.mapping.setting("position_mm"));
    if (place.size() < 2) {
      context.refuse("the log does not contain the position of M48 (no line `M48 … X Y`); " +
                     context.ask("position_mm", "[100, 100]"));
      return;
    }
    for (Touch& t : touches)
      if (std::isnan(t.x) || std::isnan(t.y)) t.x = place[0], t.y = place[1];
  }
  context.imported.how = std::to_string(touches.size()) + " touches of the bed by Marlin";
  BedSession(context, std::move(touches)).make();
}

}  // namespace mm
