#pragma once
#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "session/session.h"

namespace mm {

enum class MoveKind {
  kGo,         // only goes there
  kTouch,      // goes to `position`, then straight towards `target` until the probe trips, then back to
               // `position`
  kLaser,      // goes there and reads the laser
  kDeviation,  // goes there and has an independent instrument measure the deviation of `joint`
  kPosition,   // goes there and has an independent instrument measure the position
  kLength,     // goes there and has an independent instrument measure the length from `feature` to the tip
};

/// Whether an independent instrument measures it, not the machine's probe.
inline bool byInstrument(MoveKind kind) {
  return kind == MoveKind::kDeviation || kind == MoveKind::kPosition || kind == MoveKind::kLength;
}

/// One step of a measurement. SI units; readings one a joint.
struct PlanMove {
  MoveKind kind = MoveKind::kGo;
  std::vector<double> position;
  std::vector<double> target;  // kTouch: where the approach ends if nothing was touched
  int feature = -1;            // kTouch, kLaser, kLength: index in the artifact
  double speed = 0.0;          // m/s of the tip in the approach (kTouch); 0: the plan's rapid speed
  double wait = 0.0;           // s after arriving, before measuring
  int joint = -1;              // kDeviation
  std::string setup;           // by instrument: rows of one setup share an unknown zero; empty: known zero
  int placement = 0;           // index in Plan::placements
  int stylus = 0;              // index in the artifact's styli
  int line = 0;                // of the plan file
};

/// How the artifact stands, beside where its file says: turned about the vertical through a point of the
/// workpiece frame, then shifted. rad, m.
struct PlanPlacement {
  std::string name;
  double turn = 0.0;
  Eigen::Vector3d about = Eigen::Vector3d::Zero(), shift = Eigen::Vector3d::Zero();
  Eigen::Vector3d operator()(const Eigen::Vector3d& place) const;  ///< in workpiece
};

/// What to measure, in order: read by `mm simulate`, by the measurement node, and written by a diagnosis.
struct Plan {
  std::string name;
  std::string source;  // path, for messages
  std::string text;    // the YAML; its key `instrument` is for the simulation only
  Artifact artifact;
  bool laser = false;
  std::vector<PlanPlacement> placements;  // one after the other; empty: one, without a name
  double rapid = 10e-3;                   // m/s, of linear joints between measurements
  double rapidRotary = 0.35;              // rad/s
  std::vector<PlanMove> moves;

  /// @param machine that will move: checks names, limits and reach. @throw InputError naming file, line and
  /// key.
  static Plan load(const std::filesystem::path& file, const Machine& machine);
  /// The same from text. @param folder to which the name of an artifact file is relative.
  static Plan parse(const std::string& yaml, const std::string& source, const std::filesystem::path& folder,
                    const Machine& machine);
  /// Where a feature stands in a placement, by the artifact's file: workpiece, m.
  Eigen::Vector3d placeOf(int feature, int placement) const;
  /// Where the tip of a stylus is at those readings (m or rad) of the nominal machine: workpiece, m.
  Eigen::Vector3d tipOf(const Machine& machine, const std::vector<double>& readings, int stylus) const;
  /// "placement turned, stylus B", "state A of the correction (block 3 of 10)", what an operator is asked for
  /// before a move; empty: nothing but one of each.
  std::string standText(const PlanMove& move) const;
  /// How often each kind of measurement occurs: contacts, laser readings, references.
  int measurements() const;
};

}  // namespace mm
