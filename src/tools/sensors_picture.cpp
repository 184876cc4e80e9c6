#include "tools/sensors_picture.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/format.h"
#include "base/number_text.h"
#include "base/range.h"
#include "report/report_page.h"
#include "session/csv_cells.h"
#include "session/text_file.h"

namespace mm {
namespace {

constexpr double kNoSpan = 1e-9;  // of what is drawn: sensors at one place, or all of one worth

constexpr double kLeft = 40, kTop = 70, kWidth = 480, kHeight = 340;  // of the left panel, px
constexpr double kRight = 610, kRightWidth = 300;
constexpr const char* kAccent = "#c2410c";

std::string label(double x, double y, const std::string& words, const char* anchor = "start",
                  const char* colour = "#333", int size = 12) {
  return format(
             "<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"%s\" fill=\"%s\" font-size=\"%d\" stroke=\"#fff\" "
             "stroke-width=\"3\" paint-order=\"stroke\">",
             x, y, anchor, colour, size) +
         escapedHtml(words) + "</text>\n";
}

std::string line(double x1, double y1, double x2, double y2, const char* colour, double width = 1.0) {
  return format(
      "<line x1=\"%.1f\" y1=\"%.1f\" x2=\"%.1f\" y2=\"%.1f\" stroke=\"%s\" stroke-width=\"%.1f\"/>\n", x1, y1,
      x2, y2, colour, width);
}

/// From pale to dark blue.
std::string shade(double share) {
  const double s = std::clamp(share, 0.0, 1.0);
  return format("#%02x%02x%02x", static_cast<int>(219 - 189 * s), static_cast<int>(234 - 176 * s),
                static_cast<int>(254 - 116 * s));
}

std::string tooltip(const std::string& name, double information) {
  return "<title>" + escapedHtml(name) + format(": %.3f nat</title>", information);
}

/// The sensors as points in space, seen at an angle from above.
class Scene {
 public:
  explicit Scene(const Eigen::MatrixXd& positions)
      : box_(positions.colwise().minCoeff().transpose(), positions.colwise().maxCoeff().transpose()) {
    Range across, down;
    for (int corner = 0; corner < 8; ++corner) {
      const Eigen::Vector2d p = flat(cornerOf(corner));
      across.add(p.x());
      down.add(p.y());
    }
    scale_ = std::min(kWidth / std::max(across.size(), kNoSpan), kHeight / std::max(down.size(), kNoSpan));
    offset_ = {kLeft + 0.5 * (kWidth - scale_ * (across.lower + across.upper)),
               kTop + 0.5 * (kHeight - scale_ * (down.lower + down.upper))};
  }
  Eigen::Vector2d at(const Eigen::Vector3d& p) const { return scale_ * flat(p) + offset_; }
  std::string box() const {
    std::string out;
    for (int a = 0; a < 8; ++a)
      for (int axis = 0; axis < 3; ++axis) {
        if ((a >> axis & 1) != 0) continue;
        const Eigen::Vector2d from = at(cornerOf(a)), to = at(cornerOf(a | 1 << axis));
        out += line(from.x(), from.y(), to.x(), to.y(), "#ccc");
      }
    return out;
  }

 private:
  static Eigen::Vector2d flat(const Eigen::Vector3d& p) {
    return {0.94 * p.x() - 0.5 * p.y(), -0.9 * p.z() - 0.2 * p.x() - 0.38 * p.y()};
  }
  /// @param corner bit k set: the upper end along k.
  Eigen::Vector3d cornerOf(int corner) const {
    return box_.corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner));
  }
  Eigen::AlignedBox3d box_;
  double scale_ = 1.0;
  Eigen::Vector2d offset_ = Eigen::Vector2d::Zero();
};

std::string inSpace(const SensorSelection& selection, const SensorCandidates& candidates,
                    const Eigen::MatrixXd& positions, double least, double most,
                    const std::vector<int>& chosen) {
  const Scene scene(positions);
  std::string out = scene.box();
  for (auto s = selection.singles.rbegin(); s != selection.singles.rend(); ++s) {
    const Eigen::Vector2d p = scene.at(positions.row(s->sensor).transpose());
    out +=
        format("<circle cx=\"%.1f\" cy=\"%.1f\" r=\"6\" fill=\"%s\" stroke=\"#64748b\" stroke-width=\"0.5\">",
               p.x(), p.y(), shade((s->information - least) / std::max(most - least, kNoSpan)).c_str()) +
        tooltip(candidates.name(s->sensor), s->information) + "</circle>\n";
  }
  for (const int c : chosen) {
    const Eigen::Vector2d p = scene.at(positions.row(c).transpose());
    out +=
        format("<circle cx=\"%.1f\" cy=\"%.1f\" r=\"9\" fill=\"none\" stroke=\"%s\" stroke-width=\"2.5\"/>\n",
               p.x(), p.y(), kAccent);
    out += label(p.x() + 12, p.y() - 8, candidates.name(c), "start", kAccent, 13);
  }
  return out;
}

std::string asBars(const SensorSelection& selection, const SensorCandidates& candidates, double most,
                   const std::vector<int>& chosen) {
  std::string out;
  std::vector<std::size_t> shown;
  for (std::size_t i = 0; i < selection.singles.size(); ++i)
    if (i < 18 || std::find(chosen.begin(), chosen.end(), selection.singles[i].sensor) != chosen.end())
      shown.push_back(i);
  const double step = std::min(24.0, kHeight / static_cast<double>(shown.size()));
  for (std::size_t row = 0; row < shown.size(); ++row) {
    const SensorScore& s = selection.singles[shown[row]];
    const bool taken = std::find(chosen.begin(), chosen.end(), s.sensor) != chosen.end();
    const double y = kTop + step * static_cast<double>(row);
    out +=
        label(kLeft + 150, y + 0.65 * step, candidates.name(s.sensor), "end", taken ? kAccent : "#333", 12);
    out += format("<rect x=\"%.1f\" y=\"%.1f\" width=\"%.1f\" height=\"%.1f\" fill=\"%s\">", kLeft + 158,
                  y + 0.1 * step, std::max(1.0, (kWidth - 160) * std::max(0.0, s.information) / most),
                  0.75 * step, taken ? kAccent : "#3b82f6") +
           tooltip(candidates.name(s.sensor), s.information) + "</rect>\n";
    if (step >= 14.0)
      out += label(kLeft + 163, y + 0.65 * step, format("%.2f", s.information), "start", "#111", 11);
  }
  if (shown.size() < selection.singles.size())
    out += label(kLeft, kTop + kHeight + 18,
                 format("and %zu more with less information", selection.singles.size() - shown.size()),
                 "start", "#666");
  return out;
}

/// 1, 2 or 5 times a power of ten: four to nine steps to `most`.
double roundStep(double most) {
  const double decade = std::pow(10.0, std::floor(std::log10(most / 4.0)));
  for (const double factor : {5.0, 2.0})
    if (factor * decade <= most / 4.0) return factor * decade;
  return decade;
}

/// Information (left scale) and held-out error (right scale) against m.
std::string againstSize(const SensorSelection& selection, double micrometres) {
  double most = kNoSpan, worst = kNoSpan;
  for (const SensorSet& set : selection.sets) {
    most = std::max(most, set.information);
    worst = std::max(worst, set.heldOutRms * micrometres);
  }
  const double bottom = kTop + kHeight;
  const std::size_t count = selection.sets.size();
  const auto x = [&](std::size_t i) {
    return kRight + kRightWidth * (static_cast<double>(i) + 0.5) / static_cast<double>(count);
  };
  std::string out = line(kRight, bottom, kRight + kRightWidth, bottom, "#888") +
                    line(kRight, kTop, kRight, bottom, "#1d4ed8") +
                    line(kRight + kRightWidth, kTop, kRight + kRightWidth, bottom, kAccent);
  const double left = roundStep(most), right = roundStep(worst);
  for (int tick = 0; tick * left <= 1.1 * most; ++tick)
    out += label(kRight - 6, bottom - kHeight * tick * left / most / 1.1 + 4, format("%g", tick * left),
                 "end", "#1d4ed8", 11);
  for (int tick = 0; tick * right <= 1.1 * worst; ++tick)
    out += label(kRight + kRightWidth + 6, bottom - kHeight * tick * right / worst / 1.1 + 4,
                 format("%g", tick * right), "start", kAccent, 11);
  for (const bool error : {false, true}) {
    std::string points;
    for (std::size_t i = 0; i < count; ++i) {
      const SensorSet& set = selection.sets[i];
      const double value =
          error ? set.heldOutRms * micrometres / worst : std::max(0.0, set.information) / most;
      const double y = bottom - kHeight * value / 1.1;
      points += format("%.1f,%.1f ", x(i), y);
      out += format("<circle cx=\"%.1f\" cy=\"%.1f\" r=\"4\" fill=\"%s\"/>\n", x(i), y,
                    error ? kAccent : "#1d4ed8");
    }
    out += "<polyline points=\"" + points + "\" fill=\"none\" stroke=\"" + (error ? kAccent : "#1d4ed8") +
           "\" stroke-width=\"2\"" + (error ? " stroke-dasharray=\"6 4\"" : "") + "/>\n";
  }
  for (std::size_t i = 0; i < count; ++i)
    out +=
        label(x(i), bottom + 18, format("%zu", i + 1) + (i == selection.recommended ? " (recommended)" : ""),
              "middle", "#333");
  out += label(kRight, kTop - 12, "information, nat", "start", "#1d4ed8");
  out += label(kRight + kRightWidth, kTop - 12, "held-out error, \u00b5m (dashed)", "end", kAccent);
  return out + label(kRight + 0.5 * kRightWidth, bottom + 38, "sensors m", "middle");
}

}  // namespace

Eigen::MatrixXd readSensorPositions(const std::string& file, const std::vector<std::string>& sensors) {
  const TextFile written(file);
  std::vector<std::string_view> cells;
  Eigen::MatrixXd positions =
      Eigen::MatrixXd::Constant(static_cast<Eigen::Index>(sensors.size()), 3, std::nan(""));
  bool header = false;
  for (std::size_t n = 1; n <= written.lines().size(); ++n) {
    const std::string_view current = written.lines()[n - 1];
    if (current.empty() || current[0] == '#') continue;
    const std::string where = written.place(n);
    if (!splitCells(current, cells) || cells.size() != 4)
      throw InputError(where + "a row needs four cells: sensor,x_mm,y_mm,z_mm");
    if (!header) {
      if (cells[0] != "sensor" || cells[1] != "x_mm" || cells[2] != "y_mm" || cells[3] != "z_mm")
        throw InputError(where + "the columns must be sensor,x_mm,y_mm,z_mm");
      header = true;
      continue;
    }
    const auto found = std::find(sensors.begin(), sensors.end(), cells[0]);
    for (int k = 0; k < 3; ++k) {
      double value = 0.0;
      if (!parseNumber(std::string(cells[static_cast<std::size_t>(k) + 1]), value) || !std::isfinite(value))
        throw InputError(where + "'" + std::string(cells[static_cast<std::size_t>(k) + 1]) +
                         "' is not a finite number");
      if (found != sensors.end()) positions(found - sensors.begin(), k) = value;
    }
  }
  for (std::size_t s = 0; s < sensors.size(); ++s)
    if (std::isnan(positions(static_cast<Eigen::Index>(s), 0)))
      throw InputError(file + ": sensor '" + sensors[s] + "' has no position; add a row for it");
  return positions;
}

std::string sensorsPicture(const SensorSelection& selection, const SensorCandidates& candidates,
                           const std::optional<Eigen::MatrixXd>& positions, const std::string& target) {
  const SensorSet& best = selection.sets[selection.recommended];
  const double micrometres = candidates.micrometres;
  double least = INFINITY, most = kNoSpan;
  for (const SensorScore& s : selection.singles) {
    least = std::min(least, s.information);
    most = std::max(most, s.information);
  }
  std::string out =
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 980 470\" font-family=\"sans-serif\" "
      "role=\"img\">\n"
      "<rect width=\"980\" height=\"470\" fill=\"#fff\"/>\n";
  out += label(kLeft, 30,
               "Measure " + candidates.namesOf(best.sensors) +
                   format(": held-out error %.3g \u00b5m", best.heldOutRms * micrometres),
               "start", "#111", 16);
  out += label(kLeft, 52,
               "Information of each sensor with " + target +
                   (positions ? format(": %.2f (pale) to %.2f nat (dark)", least, most) : ", nat"),
               "start", "#666");
  out += positions ? inSpace(selection, candidates, *positions, least, most, best.sensors)
                   : asBars(selection, candidates, most, best.sensors);
  return out + againstSize(selection, micrometres) + "</svg>\n";
}

}  // namespace mm
