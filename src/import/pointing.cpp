#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "base/format.h"
#include "base/range.h"
#include "base/text.h"
#include "base/units.h"
#include "import/record_table.h"

namespace mm {
namespace {

constexpr double kHour = 15.0 * kDegree;

/// An angle within half a turn of zero.
double wrapped(double angle) { return std::remainder(angle, 2.0 * kPi); }

bool isOption(std::string_view line) { return startsWith(trim(line), ":"); }

bool isEnd(std::string_view line) { return lower(trim(line)) == "end"; }

class TPointReader {
 public:
  explicit TPointReader(ImportContext& context) : context_(context) {}

  void read() {
    if (!mount()) return;
    const auto& lines = context_.file.lines();
    std::size_t n = 2;  // the first line is the caption
    while (n <= lines.size() && (trim(lines[n - 1]).empty() || isOption(lines[n - 1]))) ++n;
    // the site, and with NODA alone its date or weather: any count of numbers but those of a star
    if (n <= lines.size() && !isStar(numbersIn(lines[n - 1]))) ++n;
    Session session = emptySession(context_);
    session.timesAssumed = kTimesInOrder;
    for (; n <= lines.size() && !isEnd(lines[n - 1]); ++n) {
      const std::string_view line = trim(lines[n - 1]);
      if (line.empty() || line.front() == '!' || line.front() == '*') continue;
      const std::vector<double> v = numbersIn(line);
      if (!isStar(v)) {
        context_.refuse(n,
                        "a star has 4 numbers (azimuth and elevation of the star, of the telescope, in deg) "
                        "or 14 (right ascension and declination of both, sidereal time), this line has " +
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
    const auto turns = [](const Joint& joint) { return joint.kind == JointKind::kRotary; };
    if (machine.jointCount() != 2 || !turns(machine.joints()[0]) || !turns(machine.joints()[1])) {
      context_.refuse("a pointing file needs a mount with two rotary joints and no others; machine '" +
                      machine.name() + "' has other joints; give the mount's URDF with --machine");
      return false;
    }
    if (const auto said = numbersIn(context_.mapping.setting("sign")); said.size() >= 2) {
      if (std::abs(said[0]) != 1.0 || std::abs(said[1]) != 1.0) {
        context_.faults.add(context_.mapping.source + ": sign must be [1, 1], [-1, 1], [1, -1] or [-1, -1]");
        return false;
      }
      std::copy_n(said.begin(), 2, sign_);
      return true;
    }
    // Azimuth runs clockwise seen from above, elevation up; the hour angle runs clockwise seen from the pole.
    const std::vector<double> q(2, 0.0);
    const auto by = machine.jacobian(q.data(), kNotMeasured);
    const Eigen::Vector3d first = by.block<3, 1>(3, 0), second = by.block<3, 1>(3, 1);
    constexpr double kUpright = 0.5;
    if (std::abs(first.z()) < kUpright) {
      context_.refuse("the first joint '" + machine.joints()[0].name +
                      "' is not vertical in the URDF, so the sense of its angle is unknown; " +
                      context_.ask("sign", "[-1, 1]"));
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
      range_[k].add(telescope[k] / kDegree);
    }
    session.observations.push_back(std::move(o));
  }

  void horizontal(const std::vector<double>& v, std::size_t n, Session& session) {
    for (const double elevation : {v[1], v[3]})
      if (std::abs(elevation) > 180.0) {
        context_.refuse(
            n, format("elevation %.6g deg is outside -180 … 180 deg; the order is azimuth, elevation",
                      elevation));
        return;
      }
    const double star[2] = {v[0] * kDegree, v[1] * kDegree}, telescope[2] = {v[2] * kDegree, v[3] * kDegree};
    add(session, n, star, telescope);
  }

  /// Degrees, minutes, seconds; the sign of -0 12 0 is in the text.
  static double sexagesimal(const std::vector<std::string_view>& words, const std::vector<double>& v,
                            std::size_t at) {
    const double size = std::abs(v[at]) + v[at + 1] / 60.0 + v[at + 2] / 3600.0;
    return words[at].front() == '-' ? -size : size;
  }

  void equatorial(std::string_view line, const std::vector<double>& v, std::size_t n, Session& session) {
    if (context_.mapping.setting("mount") != "equatorial") {
      context_.refuse(
          "the stars are in right ascension and declination; the file does not state whether these are "
          "observed places (with refraction) of an equatorial mount; if they are, " +
          context_.ask("mount", "equatorial") + "; otherwise give azimuths and elevations");
      return;
    }
    const std::vector<std::string_view> words = wordsIn(line);
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
      context_.imported.columns.push_back(
          {std::string("telescope's ") + names[k],
           "reading of joint " + context_.machine.joints()[k].name + (sign_[k] < 0.0 ? ", sign changed" : ""),
           "deg", range_[k].lower, range_[k].upper, "", ""});
    }
    context_.note("deviation = star minus telescope (true minus indicated); no times: the order of the rows");
  }

  ImportContext& context_;
  double sign_[2] = {1.0, 1.0};
  Range range_[2];  // deg
  bool equatorial_ = false;
};

}  // namespace

bool isTPoint(const TextFile& file) {
  constexpr std::size_t kHead = 8;
  for (std::size_t i = 1; i < std::min(kHead, file.lines().size()); ++i) {
    const std::string line = lower(trim(file.lines()[i]));
    if (isOption(line) && isOneOf(trim(line.substr(1)), "noda|equat|altaz|azalt|allsky|alazm")) return true;
  }
  return false;
}

void readTPoint(ImportContext& context) { TPointReader(context).read(); }

}  // namespace mm
