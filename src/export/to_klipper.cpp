#include <cmath>

#include "base/format.h"
#include "base/units.h"
#include "export/printer_terms.h"
#include "export/targets.h"

namespace mm {
namespace {

constexpr int kMeshPoints = 17;
constexpr double kSide = 100.0;        // mm, of the square whose diagonals SET_SKEW is told
constexpr double kMeshLeast = 1e-8;    // m: less is no mesh
constexpr double kLeastByHeat = 1e-9;  // m/K

/// The diagonals of a rhombus of that side whose angle is off by atan(factor), and its side: AC, BD, AD.
std::string lengths(double factor) {
  const double s = std::sin(std::atan(factor));
  return format("%.9f,%.9f,%.9f", kSide * std::sqrt(2.0 + 2.0 * s), kSide * std::sqrt(2.0 - 2.0 * s), kSide);
}

/// The mesh of z over x and y. What of z is straight over x or y is the angle between axes, which skew holds
/// already.
/// @param adds of the calibration: the mesh that was active is kept as it is.
std::string mesh(const NeededCorrection& needed, const StraightPart& adds, const ExportAxis& x,
                 const ExportAxis& y, const ExportAxis& z, bool& changes) {
  const auto along = [&](const ExportAxis& axis) {
    const auto [lower, upper] = needed.tabulated(axis.joint);
    return evenSteps(lower, upper, kMeshPoints - 1);
  };
  const PlaneTable added = planeTable(needed, x.joint, y.joint, along(x), along(y), &NeededCorrection::adds);
  const PlaneTable plane =
      needed.active() == nullptr ? added : planeTable(needed, x.joint, y.joint, along(x), along(y));
  std::string points;
  double largest = 0.0;
  const Eigen::MatrixXd& value = plane.value[z.joint];
  for (int k = 0; k < kMeshPoints; ++k) {
    points += "\n  ";
    for (int i = 0; i < kMeshPoints; ++i) {
      const double straight =
          adds.byPosition(z.joint, x.joint) * (plane.atFirst[i] - needed.reference(x.joint)) +
          adds.byPosition(z.joint, y.joint) * (plane.atSecond[k] - needed.reference(y.joint));
      const double height = value(i, k) - straight;
      largest = std::max(largest, std::abs(height));
      const double change = added.value[z.joint](i, k) - straight;
      changes = changes || std::abs(change) > kMeshLeast;
      points += (i == 0 ? "" : ", ") + fixed(height / kMillimetre, 6);
    }
  }
  if (largest < kMeshLeast) return {};
  const auto mm = [](double v) { return fixed(v / kMillimetre, 4); };
  const std::string ends = mm(plane.atFirst.front()) + ", " + mm(plane.atSecond.front());
  return "[bed_mesh]\nspeed: 50\nhorizontal_move_z: 5\nsplit_delta_z: 0.01\nmove_check_distance: "
         "3\nmesh_min: " +
         ends + "\nmesh_max: " + mm(plane.atFirst.back()) + ", " + mm(plane.atSecond.back()) +
         format("\nprobe_count: %d, %d\nmesh_pps: 0, 0\nalgorithm: bicubic\n\n", kMeshPoints, kMeshPoints) +
         "[bed_mesh calibration]\nversion: 1\npoints:" + points +
         format("\nx_count: %d\ny_count: %d\nmesh_x_pps: 0\nmesh_y_pps: 0\nalgo: direct\ntension: 0.2\n",
                kMeshPoints, kMeshPoints) +
         "min_x: " + mm(plane.atFirst.front()) + "\nmax_x: " + mm(plane.atFirst.back()) +
         "\nmin_y: " + mm(plane.atSecond.front()) + "\nmax_y: " + mm(plane.atSecond.back()) + "\n\n";
}

/// The sensor by which most of z's growth can be told; -1: z does not grow.
/// What was active goes first: there is a place for one.
int hottest(const NeededCorrection& needed, const PrinterTerms& terms, int z) {
  const Domain& d = needed.model().domain();
  int best = -1;
  double most = kMeshLeast;
  for (std::size_t k = 0; k < d.sensors.size(); ++k) {
    if (std::abs(terms.active.bySensor(z, k)) > kLeastByHeat) return k;
    const double by = std::abs(terms.adds.bySensor(z, k));
    const double range = d.sensorUpper[k] - d.sensorLower[k];
    if (by < kLeastByHeat || !(by * range > most)) continue;
    most = by * range;
    best = k;
  }
  return best;
}

}  // namespace

Exported toKlipper(const NeededCorrection& needed, const ExportOptions&) {
  Exported out;
  const ExportAxis *x = needed.findAxis("x"), *y = needed.findAxis("y"), *z = needed.findAxis("z");
  const PrinterTerms terms = printerTerms(needed, {"Klipper", "", 0.0}, out);
  std::string config, start, skew, zConfig, zStart;
  // Klipper subtracts: x - xy y - (xz - xy yz) z, y - yz z.
  const double xy = -terms.xy.value_or(0.0), yz = -terms.yz.value_or(0.0);
  const double xz = -terms.xz.value_or(0.0) + xy * yz;
  if (terms.xy) skew += " XY=" + lengths(xy);
  if (terms.xz || xy * yz != 0.0) skew += " XZ=" + lengths(xz);
  if (terms.yz) skew += " YZ=" + lengths(yz);
  if (!skew.empty()) {
    config += "[skew_correction]\n\n";
    start += "SET_SKEW" + skew + "\n";
  }
  out.holds = "the angles between the axes";
  bool changesZ = false, meshed = false;
  if (z != nullptr && x != nullptr && y != nullptr && needed.moved(x->joint) && needed.moved(y->joint)) {
    const std::string text = mesh(needed, terms.adds, *x, *y, *z, changesZ);
    meshed = !text.empty();
    if (meshed) {
      zConfig += text;
      zStart += "BED_MESH_PROFILE LOAD=calibration\n";
    }
    out.holds += "; z over x and y";
  }
  const int sensor = z == nullptr ? -1 : hottest(needed, terms, z->joint);
  if (sensor >= 0) {
    const Domain& d = needed.model().domain();
    const double added = terms.adds.bySensor(z->joint, sensor);
    changesZ = changesZ || std::abs(added) > kLeastByHeat;
    zConfig += format(
        "[z_thermal_adjust]\ntemp_coeff: %.9f\nsmooth_time: 2\nsensor_type: Generic 3950\n"
        "sensor_pin: PF3\nmin_temp: 0\nmax_temp: 100\n",
        -(added + terms.active.bySensor(z->joint, sensor)) / kMillimetre);
    zStart += "SET_Z_THERMAL_ADJUST ENABLE=1 REF_TEMP=" +
              fixed(0.5 * (d.sensorLower[sensor] + d.sensorUpper[sensor]), 3) + "\n";
  }
  if (changesZ) {
    out.axes.insert("z");
    config += zConfig;
    start += zStart;
    if (meshed)
      out.notes.push_back(
          "The figure of the mesh is for the end points of moves. Klipper splits a move, looking every "
          "move_check_distance (3 mm, its least), only where the mesh has changed by split_delta_z (0.01 mm, "
          "its least): within a move over a mesh that changes less, z goes straight. Break long moves up in "
          "the G-code.");
    if (sensor >= 0) {
      const std::string& name = needed.model().domain().sensors[sensor];
      out.sensors["z_thermal_adjust"] = name;
      out.notes.push_back("[z_thermal_adjust] takes the temperature of sensor '" + name +
                          "' of the calibration; sensor_type and sensor_pin are those of your board, and "
                          "stand there only because Klipper requires them.");
    }
  }
  out.holds += "; z by one temperature";
  out.files.push_back({"printer.cfg", "sections for printer.cfg", config});
  if (start.empty()) start = "; nothing\n";
  out.files.push_back({"start.gcode", "commands for the start of every job", start});
  out.load = {
      "Copy the sections of printer.cfg into the machine's own; drop another [bed_mesh], or merge it by "
      "hand.",
      "Put the lines of start.gcode into the macro that begins a job, behind homing: homing in z sets the "
      "reference temperature anew, so that SET_Z_THERMAL_ADJUST must come after it.",
      "Do not probe a bed mesh over this one: a probed mesh follows the bed, this one the guideways.",
      "Do not use [axis_twist_compensation] with it: that corrects a probe which stands beside the nozzle, "
      "and acts on probed heights, never on a move."};
  out.reference =
      "Skew counts from position 0 of x, y and z; the mesh is zero at x = y = 0, or at the nearest "
      "calibrated position; the temperature counts from REF_TEMP, the middle of the calibrated range.";
  out.unverified = {
      "In which order Klipper applies skew, mesh and thermal adjustment depends on the order in which "
      "its modules start; between corrections of micrometres that is beyond the last digit.",
      "Klipper does not hold a thermal change smaller than one step of z."};
  out.notes.push_back("Backlash is left out: Klipper has no compensation of it.");
  out.notes.push_back(kSquarenessNote);
  return out;
}

}  // namespace mm
