#pragma once
#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "model/model.h"
#include "model/session_states.h"
#include "session/geometric_start.h"
#include "session/session.h"

namespace mm {

enum class UnknownKind { kEffect, kPose, kFeature, kRadius, kStylus, kSetup };

/// One unknown of a calibration. SI; `unit` and `toUnit` are for people.
struct Unknown {
  UnknownKind kind = UnknownKind::kEffect;
  int owner = 0;      // effect, placement, feature, stylus or setup
  int component = 0;  // within the owner
  std::string name;   // unique: "gap (backlash x)", "rotation x of the artifact" …
  std::string unit;
  double toUnit = 1.0;
  double scale = 1.0;
  double bound = 1.0;
  double start = 0.0;
  double priorStd = 0.0;                                      // about zero; 0: no prior
  double minimum = -std::numeric_limits<double>::infinity();  // limits of meaning: a period is positive
  double maximum = std::numeric_limits<double>::infinity();
};

/// Unknowns of one kind and owner, neighbours in x.
struct UnknownGroup {
  UnknownKind kind = UnknownKind::kEffect;
  int owner = 0;  // effect, placement, feature, stylus or setup
  int first = 0, count = 0;
};

/// Three unknowns (l, m, n) that form a unit vector: h = l^2 + m^2 + n^2 - 1 is kept at 0, LASER (10)-(12).
struct UnitVector {
  int first = 0;
  double penalty = 0.0;  // M, the weight of h^2 beside residuals in mm; 0: a constraint

  /// Square of the norm less 1.
  double excess(const double* lmn) const { return lmn[0] * lmn[0] + lmn[1] * lmn[1] + lmn[2] * lmn[2] - 1.0; }
  /// What h is multiplied by among whitened residuals. @param inverseSigma of the data rows, 1/m.
  double weight(const Eigen::VectorXd& inverseSigma) const;
};

/// What deviations without a setup count from: a zero of the instrument, free along each component (it has a
/// datum of its own); or where the model's formulas say that they start.
enum class Datum { kFree, kOfTheLaw };

/// One scalar residual of the data.
struct ResidualRow {
  int observation = 0;
  int component = 0;       // contact on a ball, length: 0; points and positions: 0-2; deviations: the joint
  bool angular = false;    // rad instead of m
  double statedSigma = 0;  // m or rad from the data (deviation_std); 0: the session's repeatability
};

/// Session + model -> residuals as a function of the unknowns: the effects' parameters, the pose of the
/// artifact in each placement, free (or not exactly known) positions of features, not exactly known radii,
/// offsets of styli that are not stated, zeros of setups.
///
/// Residual of a contact on a ball: distance of the corrected probe from the ball's centre minus what it
/// should be, MMT eq. (16); of a point: three components; of a reference (position, deviation, length):
/// measured minus model. In m and rad; a fit divides them by `sigmas`. Immutable; how it changes with the
/// unknowns says `linearise` (linearisation.h).
class Problem {
 public:
  /// The derivative of one observation's residuals, by groups of unknowns. Rows: its residuals (at most
  /// kMaxRows).
  struct Derivative {
    Eigen::MatrixXd effects;                              // rows x parameterCount
    Eigen::MatrixXd pose;                                 // rows x 6
    Eigen::MatrixXd feature;                              // rows x 3
    Eigen::MatrixXd stylus;                               // rows x 3: by its offset
    Eigen::MatrixXd slots;                                // rows x ErrorLayout::size(): by each small error
    Eigen::VectorXd radius;                               // rows
    void clear(int rows, int parameters, int slotCount);  ///< all zero, of this size
  };

  /// @param session must outlive the problem. @throw InputError when a session cannot be used with the model
  /// (no observations, unknown feature, missing input of an effect).
  Problem(const Session& session, Model model, Datum datum = Datum::kFree);

  const Session& session() const { return *session_; }                         ///< measured
  const Model& model() const { return model_; }                                ///< machine and effects
  Datum datum() const { return datum_; }                                       ///< of deviations
  const std::vector<Unknown>& unknowns() const { return unknowns_; }           ///< in the order of x
  const std::vector<UnknownGroup>& groups() const { return groups_; }          ///< of the unknowns
  const std::vector<ResidualRow>& rows() const { return rows_; }               ///< one a data row
  int unknownCount() const { return static_cast<int>(unknowns_.size()); }      ///< size of x
  int rowCount() const { return static_cast<int>(rows_.size()); }              ///< data rows
  int priorCount() const { return static_cast<int>(priors_.size()); }          ///< rows after the data rows
  const std::vector<UnitVector>& unitVectors() const { return unitVectors_; }  ///< constraints
  int firstRow(int observation) const { return firstRow_[observation]; }       ///< its first data row
  const State& state(int observation) const { return states_->states()[observation]; }  ///< SI, uncorrected
  Eigen::VectorXd start() const;  ///< of all unknowns, SI

  /// Standard deviation of each data row (m or rad): stated with the data, else linearSigma / angularSigma.
  Eigen::VectorXd sigmas(double linearSigma, double angularSigma) const;

  /// Residuals (m, rad) of the data rows at x.
  Eigen::VectorXd residuals(const Eigen::VectorXd& x) const;
  /// Residuals of one observation. @param r rows of the observation. @return number of rows.
  int residualsOf(int observation, const Eigen::VectorXd& x, double* r, Derivative* derivative,
                  Model::Workspace& work) const;
  /// Spreads the derivative of one observation over all unknowns. @param rows its residuals x unknownCount.
  void scatter(int observation, const Derivative& derivative, Eigen::MatrixXd& rows) const;
  /// Observations that lack an input of the model: they have no weight. Empty when all are used.
  const std::vector<int>& leftOut() const { return leftOut_; }
  bool uses(int observation) const { return usable_[observation] != 0; }

  /// Index of the first unknown of a kind and owner, -1 when it is not unknown.
  int find(UnknownKind kind, int owner) const;
  const std::vector<int>& priors() const { return priors_; }
  bool poseFree(int placement) const { return poseOffset_[static_cast<std::size_t>(placement)] >= 0; }
  /// Position of a feature in the artifact's frame at x (m).
  Eigen::Vector3d featureInArtifact(int feature, const Eigen::VectorXd& x) const;
  /// True position of a feature in workpiece at x (m), without thermal growth of the artifact.
  Eigen::Vector3d featureInWorkpiece(int feature, int placement, const Eigen::VectorXd& x) const;
  /// Rotation artifact -> workpiece at x.
  Eigen::Matrix3d artifactRotation(int placement, const Eigen::VectorXd& x) const {
    return poseRotation(placement, x, nullptr);
  }
  /// Where the artifact's origin is in workpiece at x, m.
  Eigen::Vector3d artifactPlace(int placement, const Eigen::VectorXd& x) const {
    return artifactPose(placement, x, false).translation;
  }
  /// From the machine's probe_tip to the tip of a stylus at x: axes of probe_tip, m.
  Eigen::Vector3d reach(int stylus, const Eigen::VectorXd& x) const;

  static constexpr int kMaxRows = 16;

 private:
  void addUnknowns();
  void addRows();
  void addPoses();
  void addStyli();
  void add(Unknown unknown);
  Eigen::Matrix3d poseRotation(int placement, const Eigen::VectorXd& x, Eigen::Matrix3d* leftJacobian) const;
  struct ArtifactPose {
    Eigen::Matrix3d rotation, leftJacobian;  // artifact -> workpiece; of its rotation vector, where wanted
    Eigen::Vector3d translation;             // m
  };
  ArtifactPose artifactPose(int placement, const Eigen::VectorXd& x, bool derivative) const;
  double growthAt(int observation) const;  // of the artifact, by its temperature
  struct Seen;
  void seeDeviation(const Seen& seen) const;
  void seePosition(const Seen& seen) const;
  void seeContact(const Seen& seen) const;
  void seeLength(const Seen& seen) const;
  /// From a feature to the probe, in workpiece.
  struct Away {
    ArtifactPose at;
    double growth = 1.0;
    Eigen::Vector3d offset, vector;  // artifact's origin -> feature; feature -> probe, m
  };
  Away awayFromFeature(const Seen& seen) const;
  void changeAlong(const Seen& seen, const Away& away, int row, const Eigen::RowVector3d& n) const;

  const Session* session_;
  Model model_;
  Datum datum_;
  std::shared_ptr<SessionStates> states_;
  GeometricStart start_;
  std::vector<Unknown> unknowns_;
  std::vector<UnknownGroup> groups_;
  std::vector<UnitVector> unitVectors_;
  std::vector<ResidualRow> rows_;
  std::vector<int> firstRow_, priors_, leftOut_;
  std::vector<char> usable_;  // an observation
  void findUsable();
  std::vector<int> poseOffset_, featureOffset_, radiusOffset_, stylusOffset_, setupOffset_;
  std::vector<int>
      setupOf_;  // an observation: its setup; behind them, one a recording, that of rows without; -1: none
};

}  // namespace mm
