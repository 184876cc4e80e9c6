#include <algorithm>
#include <cmath>

#include "diagnosis/wording.h"
#include "report/symbols_of.h"
#include "report/text_parts.h"

namespace mm {
namespace {

using Point = std::vector<double>;

/// At most so many of `count`, the first and the last among them, at even distances where that can be.
std::vector<std::size_t> evenly(std::size_t count, std::size_t most) {
  std::size_t shown = std::min(count, most);
  for (std::size_t fewer = shown; fewer > 1 && fewer + 2 >= shown; --fewer)
    if ((count - 1) % (fewer - 1) == 0) {
      shown = fewer;
      break;
    }
  std::vector<std::size_t> chosen;
  for (std::size_t i = 0; i < shown; ++i)
    chosen.push_back(shown > 1 ? (i * (count - 1) + (shown - 1) / 2) / (shown - 1) : 0);
  return chosen;
}

std::vector<Point> finitePoints(const ProfileResult& p) {
  std::vector<Point> points;
  for (const Point& point : p.curve)
    if (point.size() == p.variables.size() + 2 &&
        std::all_of(point.begin(), point.end(), [](double v) { return std::isfinite(v); }))
      points.push_back(point);
  return points;
}

std::string heading(const ProfileResult& p, std::size_t variable) {
  const std::string& name = p.variables[variable];
  const std::string unit = variable < p.units.size() ? p.units[variable] : "";
  return (name == "t" ? "time" : name) + (unit.empty() || unit == "1" ? "" : ", " + unit);
}

/// One line a point: its value, the error with its band in figures and drawn.
std::string curveOfOne(const ProfileResult& p, const std::vector<Point>& points, const std::string& unit) {
  constexpr int kColumns = 45;
  double low = 0.0, high = 0.0;
  for (const Point& point : points) {
    low = std::min(low, point[1] - 2.0 * point[2]);
    high = std::max(high, point[1] + 2.0 * point[2]);
  }
  if (!(high > low)) return {};
  const auto column = [&](double v) {
    return static_cast<std::size_t>(std::lround((v - low) / (high - low) * (kColumns - 1)));
  };
  std::string text = "    " + padded(heading(p, 0), 16) + "error, " + unit + " (k = 2)\n";
  for (const std::size_t i : evenly(points.size(), 9)) {
    const Point& point = points[i];
    std::vector<std::string> line(kColumns, " ");
    line[column(0.0)] = "┊";
    for (std::size_t c = column(point[1] - 2.0 * point[2]); c <= column(point[1] + 2.0 * point[2]); ++c)
      line[c] = "─";
    line[column(point[1])] = "●";
    std::string drawn;
    for (const std::string& cell : line) drawn += cell;
    drawn.erase(drawn.find_last_not_of(' ') + 1);
    text += "    " + padded(shortNumber(point[0]), 16) + padded(expanded(point[1], point[2], ""), 18) +
            drawn + "\n";
  }
  return text;
}

/// A table of five values of the one by five of the other; of points that are no grid, nine of them.
std::string curveOfTwo(const ProfileResult& p, const std::vector<Point>& points, const std::string& unit) {
  std::vector<double> first, second;
  for (const Point& point : points) {
    first.push_back(point[0]);
    second.push_back(point[1]);
  }
  for (std::vector<double>* values : {&first, &second}) {
    std::sort(values->begin(), values->end());
    values->erase(std::unique(values->begin(), values->end()), values->end());
  }
  if (first.size() * second.size() != points.size()) {
    std::string text =
        "    " + padded(heading(p, 0), 16) + padded(heading(p, 1), 16) + "error, " + unit + " (k = 2)\n";
    for (const std::size_t i : evenly(points.size(), 9))
      text += "    " + padded(shortNumber(points[i][0]), 16) + padded(shortNumber(points[i][1]), 16) +
              expanded(points[i][2], points[i][3], "") + "\n";
    return text;
  }
  const auto columns = evenly(second.size(), 5);
  std::string text = "    error, " + unit + " (k = 2): down " + heading(p, 0) + "; across " + heading(p, 1) +
                     "\n    " + padded("", 12);
  for (const std::size_t j : columns) text += padded(shortNumber(second[j]), 16);
  text.erase(text.find_last_not_of(' ') + 1);
  for (const std::size_t i : evenly(first.size(), 5)) {
    text += "\n    " + padded(shortNumber(first[i]), 12);
    for (const std::size_t j : columns)
      for (const Point& point : points)
        if (point[0] == first[i] && point[1] == second[j])
          text += padded(expanded(point[2], point[3], ""), 16);
    text.erase(text.find_last_not_of(' ') + 1);
  }
  return text + "\n";
}

}  // namespace

std::string profileText(const Diagnosis& d, const ProfileResult& p) {
  const bool angular = isAngular(d, p.direction);
  const std::string unit = angular ? "arcsec" : "um";
  const std::string symbol = symbolsOf(d).of(p.effect);
  std::string text = "  " + std::string(angular ? "of " : "along ") + p.direction + ", over " +
                     variablesInWords(p) + (symbol.empty() ? "" : " (" + symbol + ")") + ": odds " +
                     oddsInWords(p.odds) + ", held-out RMS " + length(p.heldOutBefore, d.angular) + " -> " +
                     length(p.heldOutAfter, d.angular) + "\n";
  const std::vector<Point> points = finitePoints(p);
  if (points.empty()) return text;
  return text + (p.variables.size() == 1 ? curveOfOne(p, points, unit) : curveOfTwo(p, points, unit));
}

}  // namespace mm
