#include "import/pointing.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cctype>
#include <cmath>
#include <sstream>

#include "base/error.h"
#include "base/format.h"
#include "base/text.h"
#include "base/units.h"
#include "import/record_table.h"

namespace mm {
namespace {

constexpr double kHour = 15.0 * kDegree;

/// An angle within half a turn of zero.
double wrapped(double angle) { return std::remainder(angle, 2.0 * kPi); }

std::vector<double> numbersOf(std::string_view line, bool& all) {
  std::vector<double> numbers;
  std::istringstream in{std::string(line)};
  all = true;
  for (std::string word; in >> word;) {
    double value = 0.0;
    if (parseNumber(word, false, value))
      numbers.push_back(value);
    else
      all = false;
  }
  return numbers;
}

bool isOption(std::string_view line) { return !trim(line).empty() && trim(line).front() == ':'; }

bool isEnd(std::string_view line) { return lower(trim(line)) == "end"; }

class TPointReader {
 public:
  explicit TPointReader(ImportContext& context) : context_(context) {}

  void read() {
    if (!mount()) return;
    const auto& lines = context_.file.lines();
    std::size_t n = 2;  // the first line is the caption
    while (n <= lines.size() && (trim(lines[n - 1]).empty() || isOption(lines[n - 1]))) ++n;
    bool all = false;
    // the site, and with NODA alone its date or weather: any count of numbers but those of a star
    if (n <= lines.size() && !isStar(numbersOf(lines[n - 1], all))) ++n;
    Session session = emptySession(context_);
    for (; n <= lines.size() && !isEnd(lines[n - 1]); ++n) {
      const std::string_view line = trim(lines[n - 1]);
      if (line.empty() || line.front() == '!' || line.front() == '*') continue;
      const std::vector<double> v = numbersOf(line, all);
      if (!isStar(v)) {
        context_.faults.add(context_.file.place(n) +
                            "a star has 4 numbers (azimuth and elevation of the star, of the "
                            "telescope, in deg) or 14 (right ascension and declination of both, sidereal "
                            "time), this line has " +
                            std::to_string(v.size()) + "; correct it, or leave it out");
        continue;
      }
      if (v.size() == 4)
        horizontal(v, n, session);
      else
        equatorial(lines[n - 1], v, n, session);
    }
    if (!context_.faults.empty()) return;
    context_.imported.how = "'" + std::string(trim(lines.front())) + "'";
    show();
    finishImport(context_, std::move(session));
  }

 private:
  static bool isStar(const std::vector<double>& v) { return v.size() == 4 || v.size() == 14; }

  /// The two rotary joints and the sense in which they turn against azimuth and elevation.
  bool mount() {
    const Machine& machine = context_.machine;
    const std::string name = context_.file.path().string();
    std::vector<int> rotary;
    for (int j = 0; j < machine.jointCount(); ++j)
      if (machine.joints()[j].kind == JointKind::kRotary) rotary.push_back(j);
    if (rotary.size() != 2 || machine.jointCount() != 2) {
      context_.faults.add(name +
                          ": a pointing file is of a mount of two rotary joints and nothing else; machine '" +
                          machine.name() + "' has others; give the mount's URDF with --machine");
      return false;
    }
    std::istringstream said(context_.mapping.setting("sign"));
    double a = 0.0, b = 0.0;
    if (said >> a >> b) {
      if (std::abs(a) != 1.0 || std::abs(b) != 1.0) {
        context_.faults.add(context_.mapping.source + ": sign must be [1, 1], [-1, 1], [1, -1] or [-1, -1]");
        return false;
      }
      sign_[0] = a;
      sign_[1] = b;
      return true;
    }
    // Azimuth runs clockwise seen from above, elevation up; the hour angle runs clockwise seen from the pole.
    const std::vector<double> q(2, 0.0);
    const auto by = machine.jacobian(q.data(), kNotMeasured);
    const Eigen::Vector3d first = by.block<3, 1>(3, 0), second = by.block<3, 1>(3, 1);
    constexpr double kUpright = 0.5;
    if (std::abs(first.z()) < kUpright) {
      context_.faults.add(name + ": the first joint '" + machine.joints()[0].name +
                          "' does not stand upright in the URDF, so the sense of its angle is not seen; "
                          "write into the mapping "
                          "(--columns): sign: [-1, 1]");
      return false;
    }
    const double up = first.z() > 0.0 ? 1.0 : -1.0;
    const Eigen::Vector3d sight = first.cross(second);
    sign_[0] = -up;
    sign_[1] = up * second.cross(sight).dot(first) > 0.0 ? 1.0 : -1.0;
    return true;
  }

  void add(Session& session, std::size_t line, const double star[2], const double telescope[2]) {
    Observation o = blankRow(context_, ObservationKind::kDeviation, line,
                             static_cast<double>(session.observations.size()));
    for (int k = 0; k < 2; ++k) {
      o.position[k] = sign_[k] * (k == 0 ? wrapped(telescope[k]) : telescope[k]);
      o.deviation[k] = sign_[k] * wrapped(star[k] - telescope[k]);
      range_[k].first = std::min(range_[k].first, telescope[k] / kDegree);
      range_[k].second = std::max(range_[k].second, telescope[k] / kDegree);
    }
    session.observations.push_back(std::move(o));
  }

  void horizontal(const std::vector<double>& v, std::size_t n, Session& session) {
    for (const double elevation : {v[1], v[3]})
      if (std::abs(elevation) > 180.0) {
        context_.faults.add(context_.file.place(n) +
                            format("elevation %.6g deg is outside -180 … 180 deg; the order is azimuth, "
                                   "elevation",
                                   elevation));
        return;
      }
    const double star[2] = {v[0] * kDegree, v[1] * kDegree}, telescope[2] = {v[2] * kDegree, v[3] * kDegree};
    add(session, n, star, telescope);
  }

  /// Degrees, minutes, seconds; the sign of -0 12 0 is in the text.
  static double sexagesimal(const std::vector<std::string>& words, const std::vector<double>& v,
                            std::size_t at) {
    const double size = std::abs(v[at]) + v[at + 1] / 60.0 + v[at + 2] / 3600.0;
    return words[at].front() == '-' ? -size : size;
  }

  void equatorial(std::string_view line, const std::vector<double>& v, std::size_t n, Session& session) {
    if (context_.mapping.setting("mount") != "equatorial") {
      context_.faults.add(
          context_.file.path().string() +
          ": the stars are in right ascension and declination; whether these are observed places (with "
          "refraction) of an equatorial mount is not in the file; if they are, write into the mapping "
          "(--columns): mount: equatorial; else give azimuths and elevations");
      return;
    }
    std::vector<std::string> words;
    std::istringstream in{std::string(line)};
    for (std::string word; in >> word;) words.push_back(word);
    const double time = (v[12] + v[13] / 60.0) * kHour;
    const double star[2] = {wrapped(time - sexagesimal(words, v, 0) * kHour),
                            sexagesimal(words, v, 3) * kDegree};
    double telescope[2] = {wrapped(time - sexagesimal(words, v, 6) * kHour),
                           sexagesimal(words, v, 9) * kDegree};
    if (telescope[1] > 90.0 * kDegree) {  // beyond the pole, as the encoder reads it
      const double beyond = wrapped(star[0] - telescope[0]);
      if (std::abs(beyond) < 90.0 * kDegree) telescope[1] = 180.0 * kDegree - telescope[1];
    }
    add(session, n, star, telescope);
    equatorial_ = true;
  }

  void show() {
    const char* const names[2] = {equatorial_ ? "hour angle" : "azimuth",
                                  equatorial_ ? "declination" : "elevation"};
    for (int k = 0; k < 2; ++k) {
      UnderstoodColumn c;
      c.name = std::string("telescope's ") + names[k];
      c.meaning =
          "reading of joint " + context_.machine.joints()[k].name + (sign_[k] < 0.0 ? ", sign changed" : "");
      c.unit = "deg";
      c.lower = range_[k].first;
      c.upper = range_[k].second;
      context_.imported.columns.push_back(std::move(c));
    }
    context_.imported.notes.push_back(
        "deviation = star minus telescope (true minus indicated); no times: the order of the rows");
  }

  ImportContext& context_;
  double sign_[2] = {1.0, 1.0};
  std::pair<double, double> range_[2] = {{INFINITY, -INFINITY}, {INFINITY, -INFINITY}};
  bool equatorial_ = false;
};

}  // namespace

bool isTPoint(const TextFile& file) {
  constexpr std::size_t kHead = 8;
  for (std::size_t i = 1; i < std::min(kHead, file.lines().size()); ++i) {
    const std::string line = lower(trim(file.lines()[i]));
    if (line.empty() || line.front() != ':') continue;
    const std::string option(trim(line.substr(1)));
    for (const char* known : {"noda", "equat", "altaz", "azalt", "allsky", "alazm"})
      if (option == known) return true;
  }
  return false;
}

void readTPoint(ImportContext& context) { TPointReader(context).read(); }

}  // namespace mm
