#include <Eigen/Geometry>
#include <limits>

#include "base/dense.h"
#include "base/grid_values.h"
#include "base/rotation.h"
#include "base/units.h"
#include "export/fitted_tables.h"
#include "export/hat_functions.h"
#include "export/targets.h"

namespace mm {
namespace {

constexpr int kCsvMostPoints = 241;
constexpr int kCsvOthers = 24;
constexpr unsigned kCsvSeed = 31;
constexpr double kArms = 1e-4;  // m: arms that differ less tell no rotation

/// Errors of one carriage at one place: translation (m) and rotation (rad) against those at the reference.
using CarriageError = Eigen::Matrix<double, 6, 1>;

/// The kinematic chain in the axes of the workpiece, all joints at zero.
struct Chain {
  std::vector<Eigen::Vector3d> direction, origin;  // a joint; origin in workpiece, of its fixed side
  Eigen::Vector3d tip = Eigen::Vector3d::Zero();

  explicit Chain(const NeededCorrection& needed) {
    const Machine& machine = needed.model().machine();
    const std::vector<double> zero(machine.joints().size(), 0.0);
    const double beam = std::numeric_limits<double>::quiet_NaN();
    const auto jacobian = machine.jacobian(zero.data(), beam);
    tip = machine.nominal(zero.data(), beam).position;
    Eigen::Vector3d last = Eigen::Vector3d::Zero();
    for (std::size_t j = 0; j < zero.size(); ++j) {
      const bool linear = machine.joints()[j].kind == JointKind::kLinear;
      const Eigen::Vector3d v = jacobian.block<3, 1>(0, j), about = jacobian.block<3, 1>(3, j);
      direction.push_back(linear ? v : about);
      // A linear joint may stand anywhere; of a rotary one the point of its axis that is nearest to the tip.
      if (!linear) last = tip - v.cross(about);
      origin.push_back(last);
    }
  }
};

/// The arm from a joint's fixed side to the tip: what lies upstream does not count.
Eigen::Vector3d armOf(const NeededCorrection& needed, const Chain& chain, const State& state, int joint) {
  std::vector<double> q = state.position;
  for (int j = 0; j < joint; ++j) q[j] = 0.0;
  return needed.model().machine().nominal(q.data(), std::numeric_limits<double>::quiet_NaN()).position -
         chain.origin[joint];
}

/// Rotation and translation that explain how much more the probe is displaced at this place than at the
/// reference.
CarriageError explained(const std::vector<Eigen::Vector3d>& more, const std::vector<Eigen::Vector3d>& arms) {
  Eigen::Vector3d meanMore = Eigen::Vector3d::Zero(), meanArm = Eigen::Vector3d::Zero();
  const double n = more.size();
  for (std::size_t i = 0; i < more.size(); ++i) {
    meanMore += more[i] / n;
    meanArm += arms[i] / n;
  }
  Eigen::MatrixXd lever(3 * more.size(), 3);
  Eigen::VectorXd moved(lever.rows());
  for (std::size_t i = 0; i < more.size(); ++i) {
    lever.middleRows<3>(3 * i) = skew(meanArm - arms[i]);  // r x arm
    moved.segment<3>(3 * i) = more[i] - meanMore;
  }
  const RightSingular levers(lever);
  const Eigen::Vector3d moments = lever.transpose() * moved;
  Eigen::Vector3d rotation = Eigen::Vector3d::Zero();
  for (Eigen::Index k = 0; k < levers.values.size(); ++k) {
    const Eigen::Vector3d axis = levers.vectors.col(k);
    const double size = levers.values[k];
    if (size > kArms * std::sqrt(n)) rotation += axis * (axis.dot(moments) / (size * size));
  }
  CarriageError error;
  error << meanMore - rotation.cross(meanArm), rotation;
  return error;
}

/// Rotary joints stand at their reference: component errors are told there.
std::vector<State> statesFor(const NeededCorrection& needed) {
  std::vector<State> states = needed.states(kCsvOthers, kCsvSeed);
  for (State& s : states)
    for (const ExportAxis& axis : needed.axes())
      if (axis.kind == JointKind::kRotary) s.position[axis.joint] = needed.reference(axis.joint);
  return states;
}

/// Of one joint, a row at each of its positions: upwards, then downwards.
Eigen::MatrixXd errorsOf(const NeededCorrection& needed, const Chain& chain, int joint,
                         const std::vector<double>& at) {
  std::vector<State> states = statesFor(needed);
  const auto displaced = [&](State& s, double position, double travel) {
    s.position[joint] = position;
    s.travel[joint] = travel;
    return needed.missed(s, s.position);  // of the machine without any compensation
  };
  std::vector<Eigen::Vector3d> reference;
  for (State& s : states)
    reference.push_back(
        0.5 * (displaced(s, needed.reference(joint), 1.0) + displaced(s, needed.reference(joint), -1.0)));
  Eigen::MatrixXd errors(at.size(), 12);
  for (Eigen::Index n = 0; n < errors.rows(); ++n)
    for (int way = 0; way < 2; ++way) {
      std::vector<Eigen::Vector3d> more, arms;
      for (std::size_t i = 0; i < states.size(); ++i) {
        more.push_back(displaced(states[i], at[n], way == 0 ? 1.0 : -1.0) - reference[i]);
        arms.push_back(armOf(needed, chain, states[i], joint));
      }
      errors.block<1, 6>(n, 6 * way) = explained(more, arms).transpose();
    }
  return errors;
}

/// The same at the points of a table, zero at the reference, from samples between them: a period that is
/// shorter than the steps is left alone.
Eigen::MatrixXd fittedErrors(const NeededCorrection& needed, const Chain& chain, const LineTable& table) {
  const std::vector<double> at = samplesWithin(table.at, table.samplesAStep);
  Eigen::MatrixXd values = hatOrLineFit(table.at, at, errorsOf(needed, chain, table.input, at));
  const auto [before, share] = placeAmong(table.at, needed.reference(table.input));
  const Eigen::RowVectorXd there = (1.0 - share) * values.row(before) + share * values.row(before + 1);
  const Eigen::RowVectorXd zero = 0.5 * (there.head(6) + there.tail(6));
  values.leftCols(6).rowwise() -= zero;
  values.rightCols(6).rowwise() -= zero;
  return values;
}

std::string chainTable(const NeededCorrection& needed, const Chain& chain) {
  std::string text =
      "joint,kind,direction_x,direction_y,direction_z,origin_x_mm,origin_y_mm,origin_z_mm,rotation_about\n";
  const auto vector = [](const Eigen::Vector3d& v, int digits) {
    return "," + fixed(v.x(), digits) + "," + fixed(v.y(), digits) + "," + fixed(v.z(), digits);
  };
  Eigen::Vector3d last = Eigen::Vector3d::Zero();
  for (const ExportAxis& axis : needed.axes()) {
    const int j = axis.joint;
    text += axis.letter + (axis.kind == JointKind::kLinear ? ",linear" : ",rotary") +
            vector(chain.direction[j], 9) + vector((chain.origin[j] - last) / kMillimetre, 6) +
            ",fixed_side\n";
    last = chain.origin[j];
  }
  return text + "tip,,,," + vector((chain.tip - last) / kMillimetre, 6) + ",\n";
}

void addErrorTables(const ExportAxis& axis, const std::vector<double>& at, const Eigen::MatrixXd& errors,
                    Exported& out) {
  for (Eigen::Index k = 0; k < 3; ++k) {
    std::string linear = "position_mm,positive_um,negative_um\n", angular = "position_mm,value_urad\n";
    for (Eigen::Index i = 0; i < errors.rows(); ++i) {
      const std::string where = fixed(at[i] / kMillimetre, 4);
      linear += where + "," + fixed(errors(i, k) / kMicrometre, 5) + "," +
                fixed(errors(i, 6 + k) / kMicrometre, 5) + "\n";
      angular += where + "," + fixed(0.5 * (errors(i, 3 + k) + errors(i, 9 + k)) * 1e6, 5) + "\n";
    }
    const std::string joint = capital(axis.letter);
    const std::string translation = "E" + std::string(1, "XYZ"[k]) + joint,
                      rotation = "E" + std::string(1, "ABC"[k]) + joint;
    out.files.push_back(
        {translation + ".csv",
         "error of " + joint + " along " + std::string(1, "XYZ"[k]) + ", um, upwards and downwards", linear});
    out.files.push_back(
        {rotation + ".csv", "error of " + joint + " about " + std::string(1, "XYZ"[k]) + ", urad", angular});
  }
}

}  // namespace

Exported toCsv(const NeededCorrection& needed, const ExportOptions&) {
  Exported out;
  const Chain chain(needed);
  for (const ExportAxis& axis : needed.axes()) out.axes.insert(axis.letter);
  for (const int joint : needed.linear()) {
    if (!needed.moved(joint) && needed.activePoints(joint).empty()) continue;
    const LineTable table = lineTable(needed, joint, kCsvMostPoints);
    addNotFollowed(needed, table, needed.linear(), out);
    addErrorTables(needed.axis(joint), table.at, fittedErrors(needed, chain, table), out);
  }
  out.files.push_back({"chain.csv", "the kinematic chain from workpiece to tip, in the axes of the workpiece",
                       chainTable(needed, chain)});
  out.holds =
      "six component errors of each linear axis by its own position, those of position upwards and downwards "
      "apart";
  out.load = {
      "Read the tables by their names: E, direction of the error, axis that moves (ISO 230-1). EXX "
      "positioning, EYX straightness, EAX roll (about X), EBX, ECX.",
      "Errors are actual minus commanded, seen from the workpiece: a compensation takes them away.",
      "Rotations turn, right-handed, about the origin of the joint's fixed side (chain.csv), what follows in "
      "the chain: displacement = translation + rotation x arm from there to the tip."};
  out.reference =
      "Every table is zero at position 0 of its axis (mean of both directions), or at the end of the "
      "calibrated range that is nearest to it. Squareness is in the tables: the slope of EYX over x is C0X, "
      "and so on.";
  out.notes = {"Rotary joints are in the chain; their errors are not in these tables."};
  return out;
}

}  // namespace mm
