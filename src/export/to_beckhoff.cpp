#include <cmath>
#include <optional>

#include "base/format.h"
#include "base/tiny.h"
#include "export/fitted_tables.h"
#include "export/targets.h"

namespace mm {
namespace {

constexpr double kBetter = 0.999;       // of the remainder: what a choice of planes must bring
constexpr double kNoRemainder = 1e-18;  // m^2: rounding of a remainder

constexpr int kBeckhoffMostPoints = 241;  // of the leadscrew table; the control allows 1500
constexpr int kPlaneIntervals = 16;       // along the longer of two axes
constexpr double kBeckhoffUnit = 1e-7;    // m: lengths are in 0.1 um
constexpr int kJudged = 256;              // states by which planes are compared
constexpr unsigned kPlaneChoiceSeed = 21;

long units(double metres) { return std::lround(metres / kBeckhoffUnit); }

PlaneTable planeOf(const NeededCorrection& needed, int first, int second) {
  const ExportAxis& a = needed.axis(first);
  const ExportAxis& b = needed.axis(second);
  const auto length = [&](const ExportAxis& axis) {
    const auto [lower, upper] = needed.tabulated(axis.joint);
    return upper - lower;
  };
  const double longer = std::max(length(a), length(b));
  const double step =
      std::ceil(longer / kPlaneIntervals / kBeckhoffUnit) * kBeckhoffUnit;  // one for both axes
  const auto steps = [&](const ExportAxis& axis) {
    const auto [lower, upper] = needed.tabulated(axis.joint);
    const int n = std::max(1, static_cast<int>(std::ceil((upper - lower) / step - kOfAWhole)));
    const double start = std::floor(lower / kBeckhoffUnit + kOfAWhole) * kBeckhoffUnit;
    std::vector<double> at;
    for (int i = 0; i <= n; ++i) at.push_back(start + i * step);
    return at;
  };
  return planeTable(needed, first, second, steps(a), steps(b));
}

/// Takes out of the plane what the position of its two axes alone does to them: their own tables have that.
void leaveToOwn(const NeededCorrection& needed, PlaneTable& plane) {
  const auto own = [&](int joint, const std::vector<double>& at) {
    const double zero = meanCorrection(needed, joint, needed.reference(joint))[joint];
    Eigen::VectorXd curve(at.size());
    for (std::size_t i = 0; i < at.size(); ++i) curve[i] = meanCorrection(needed, joint, at[i])[joint] - zero;
    return curve;
  };
  plane.value[plane.first].colwise() -= own(plane.first, plane.atFirst);
  plane.value[plane.second].rowwise() -= own(plane.second, plane.atSecond).transpose();
}

/// What the tables of one axis add to it.
struct AxisTables {
  const LineTable* own = nullptr;
  const PlaneTable* plane = nullptr;
  const LineTable* cross = nullptr;

  double at(const State& s, int output) const {
    const auto read = [&](int joint) { return s.position[joint]; };
    double sum = 0.0;
    if (own != nullptr) sum += own->value(output, read(output), s.travel[output]);
    if (plane != nullptr) sum += plane->interpolated(output, read(plane->first), read(plane->second));
    if (cross != nullptr) sum += cross->value(output, read(cross->input), 0.0);
    return sum;
  }
};

/// Every table that may be of use, once.
struct Pool {
  std::vector<std::optional<LineTable>> lines;  // a joint
  std::vector<PlaneTable> planes;

  explicit Pool(const NeededCorrection& needed) : lines(needed.axes().size()) {
    const std::vector<int>& linear = needed.linear();
    for (const int joint : linear)
      if (needed.moved(joint)) lines[joint] = lineTable(needed, joint, kBeckhoffMostPoints);
    for (std::size_t a = 0; a < linear.size(); ++a)
      for (std::size_t b = a + 1; b < linear.size(); ++b)
        if (needed.moved(linear[a]) && needed.moved(linear[b])) {
          planes.push_back(planeOf(needed, linear[a], linear[b]));
          leaveToOwn(needed, planes.back());
        }
  }
  const LineTable* line(int joint) const {
    const auto& found = lines[joint];
    return found ? &*found : nullptr;
  }
};

double left(const NeededCorrection& needed, const std::vector<State>& states, const AxisTables& tables,
            int output) {
  double sum = 0.0, squares = 0.0;
  for (const State& s : states) {
    const double e = needed.at(s)[output] - tables.at(s, output);
    sum += e;
    squares += e * e;
  }
  const double n = states.size();
  return squares / n - sum * sum / n / n;
}

/// The plane, and the third axis beside it, by which least is left.
AxisTables chosen(const NeededCorrection& needed, const Pool& pool, int output) {
  AxisTables best;
  best.own = pool.line(output);
  const std::vector<State> states = needed.states(kJudged, kPlaneChoiceSeed);
  double least = left(needed, states, best, output);
  for (const PlaneTable& plane : pool.planes) {
    AxisTables tables;
    tables.own = pool.line(output);
    tables.plane = &plane;
    for (const int joint : needed.linear())
      if (joint != output && joint != plane.first && joint != plane.second && tables.cross == nullptr)
        tables.cross = pool.line(joint);
    const double is = left(needed, states, tables, output);
    if (is < kBetter * least - kNoRemainder) {
      least = is;
      best = tables;
    }
  }
  return best;
}

std::string leadscrew(const LineTable& table, int joint) {
  std::string text = format(
      "kw.ssfk.unit %d\nkw.ssfk.interval %ld\nkw.ssfk.kw_startpos %ld\nkw.ssfk.kw_nr_max %zu\n"
      "kw.ssfk.bilateral 1\nkw.ssfk.modulo 0\n",
      1, units(table.at[1] - table.at[0]), units(table.at.front()), table.at.size());
  // Actual minus command, as the manual's example computes it: the control takes it from the setpoint.
  for (std::size_t i = 0; i < table.at.size(); ++i)
    text += format("kw.ssfk.table[%zu].pos %ld\nkw.ssfk.table[%zu].neg %ld\n", i,
                   -units(table.positive[joint][i]), i, -units(table.negative[joint][i]));
  return text;
}

std::string cross(const LineTable& table, int joint, int master) {
  std::string text =
      format("kw.crosscomp.unit 1\nkw.crosscomp.last_index %zu\nkw.crosscomp.master_ax_nr %d\n",
             table.at.size() - 1, master);
  for (std::size_t i = 0; i < table.at.size(); ++i)
    text += format("kw.crosscomp.table[%zu].setpoint %ld\nkw.crosscomp.table[%zu].correction %ld\n", i,
                   units(table.at[i]), i, units(table.mean(joint, i)));
  return text;
}

std::string planeList(const AxisTables& tables, int joint, int master1, int master2) {
  const PlaneTable& plane = *tables.plane;
  std::string text = format(
      "kw.crosscomp2.unit 1\nkw.crosscomp2.interval %ld\nkw.crosscomp2.last_index_master1 %zu\n"
      "kw.crosscomp2.last_index_master2 %zu\nkw.crosscomp2.start_position_master1 %ld\n"
      "kw.crosscomp2.start_position_master2 %ld\nkw.crosscomp2.master1_ax_nr %d\nkw.crosscomp2.master2_ax_nr "
      "%d\n",
      units(plane.atFirst[1] - plane.atFirst[0]), plane.atFirst.size() - 1, plane.atSecond.size() - 1,
      units(plane.atFirst.front()), units(plane.atSecond.front()), master1, master2);
  for (std::size_t k = 0; k < plane.atSecond.size(); ++k)
    for (std::size_t i = 0; i < plane.atFirst.size(); ++i)
      text += format("kw.crosscomp2.table[%zu][%zu].correction %ld\n", k, i, units(plane.value[joint](i, k)));
  return text;
}

}  // namespace

Exported toBeckhoff(const NeededCorrection& needed, const ExportOptions&) {
  Exported out;
  const Pool pool(needed);
  std::vector<int> number(needed.axes().size(), 0);  // logical axis numbers, from 1
  int count = 0;
  for (const int joint : needed.linear()) number[joint] = ++count;
  for (const int joint : needed.linear()) {
    const ExportAxis& axis = needed.axis(joint);
    if (!needed.changes(joint)) continue;
    out.axes.insert(axis.letter);
    const AxisTables tables = chosen(needed, pool, joint);
    const auto of = [&](int j) { return number[j]; };
    std::string list =
        format("kopf.log_achs_nr %d\nkopf.log_achs_name %s\n", of(joint), capital(axis.letter).c_str());
    std::string set = needed.active() != nullptr ? "lr_param.anwahl_losekomp 0\n" : "";
    if (tables.own != nullptr) {
      addNotFollowed(needed, *tables.own, {joint}, out);
      list += leadscrew(*tables.own, joint);
      set += "lr_param.ssfk 1\n";
    }
    if (tables.cross != nullptr) {
      addNotFollowed(needed, *tables.cross, {joint}, out);
      list += cross(*tables.cross, joint, of(tables.cross->input));
      set += "lr_param.crosscomp 1\n";
    }
    if (tables.plane != nullptr) {
      list += planeList(tables, joint, of(tables.plane->first), of(tables.plane->second));
      set += "lr_param.crosscomp2 1\n";
      out.notes.push_back("Plane compensation of " + capital(axis.letter) + " by " +
                          capital(needed.axis(tables.plane->first).letter) + " and " +
                          capital(needed.axis(tables.plane->second).letter) +
                          ": of the planes that there are it leaves least.");
    }
    out.files.push_back(
        {axis.letter + ".lis", "compensation value list of " + capital(axis.letter) + ", 0.1 um", list});
    out.files.push_back({axis.letter + ".axis.lis",
                         "activation, for the axis parameter list of " + capital(axis.letter), set});
  }
  out.holds =
      "each axis by its own position, upwards and downwards apart; by one plane of two positions; by one "
      "more";
  out.load = {
      "Compare the logical axis numbers (kopf.log_achs_nr, …_ax_nr) with the control's, and change them "
      "where they differ.",
      "Make each <axis>.lis the compensation value list of its axis (TwinCAT System Manager, or achs_kw in "
      "the start-up list).",
      "Take the lines of <axis>.axis.lis over into the axis parameter lists. Where the backlash compensation "
      "of these axes was active while measuring, it is in the bilateral table: switch it off.",
      "Start up, home every axis: plane and cross compensation act when their masters are referenced."};
  out.reference =
      "Positions are those of the referenced axes, in 0.1 um. Each table is zero at position 0, or at the "
      "end of the calibrated range that is nearest to it; beyond its ends the last value holds.";
  out.unverified = {
      "The leadscrew table holds actual minus command, as the manual computes its example. Of cross and "
      "plane compensation the manual gives no example with a sign; values here are what is added to the "
      "slave axis. Check each with one move.",
      "Builds before V3.1.3079.06 allow 1001 entries of cross compensation; kw.crosscomp2 then has no "
      "max_points."};
  return out;
}

}  // namespace mm
