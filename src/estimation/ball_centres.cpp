#include "estimation/ball_centres.h"

#include <Eigen/Core>
#include <cmath>

#include "base/dense.h"
#include "base/error.h"
#include "base/units.h"
#include "estimation/calibrate.h"
#include "model/session_states.h"
#include "session/sphere_centre.h"

namespace mm {
namespace {

constexpr double kSamePosture = 1e-5;  // rad
constexpr std::size_t kFewest = 4;     // contacts for a centre

/// The contacts on one ball in one posture, indices of the session's observations.
struct Posture {
  int feature = 0;
  std::vector<std::size_t> contacts;
};

bool sameRotary(const Machine& machine, const Observation& a, const Observation& b) {
  for (int j = 0; j < machine.jointCount(); ++j)
    if (machine.joints()[j].kind == JointKind::kRotary &&
        std::abs(a.position[j] - b.position[j]) > kSamePosture)
      return false;
  return true;
}

std::vector<Posture> posturesOf(const Session& session) {
  std::vector<Posture> postures;
  for (std::size_t o = 0; o < session.observations.size(); ++o) {
    const Observation& at = session.observations[o];
    if (at.kind != ObservationKind::kContact ||
        session.artifact.features[at.feature].kind != FeatureKind::kBall)
      throw InputError(session.source + ": " + session.rowText(at.row, at.recording) +
                       " is not a contact with a ball; --two-steps (Fei et al.) needs contacts with balls "
                       "only");
    Posture* mine = nullptr;
    for (Posture& p : postures)
      if (const Observation& first = session.observations[p.contacts[0]];
          p.feature == at.feature && first.placement == at.placement && first.recording == at.recording &&
          sameRotary(session.machine, first, at))
        mine = &p;
    if (mine == nullptr) mine = &postures.emplace_back(Posture{at.feature, {}});
    mine->contacts.push_back(o);
  }
  return postures;
}

std::string nameOf(const Session& session, const Posture& posture) {
  std::string text;
  const Observation& at = session.observations[posture.contacts[0]];
  for (int j = 0; j < session.machine.jointCount(); ++j)
    if (session.machine.joints()[j].kind == JointKind::kRotary)
      text += (text.empty() ? "" : ", ") + session.machine.joints()[j].name + " = " +
              std::to_string(std::lround(at.position[j] / kDegree)) + " deg";
  return "posture " + text + " on ball '" + session.artifact.features[posture.feature].name + "'";
}

/// Puts the linear joints of `o` where the corrected probe is at `target`.
void moveTo(const Session& session, const Model& model, const Eigen::VectorXd& x, const State& like,
            const Eigen::Vector3d& target, Observation& o) {
  std::vector<int> linear;
  for (int j = 0; j < session.machine.jointCount(); ++j)
    if (session.machine.joints()[j].kind == JointKind::kLinear) linear.push_back(j);
  if (linear.size() < 3)
    throw InputError(
        "machine '" + session.machine.name() +
        "' has fewer than three linear joints, which --two-steps (Fei et al.) needs; omit --two-steps");
  Model::Workspace work;
  for (int step = 0; step < 3; ++step) {
    State state = like;
    state.position = o.position;
    state.laserReading = o.laserReading;
    model.place(state);
    const Eigen::Vector3d miss = target - model.corrected(state, x.data(), work).position;
    const auto jacobian = session.machine.jacobian(o.position.data(), o.laserReading);
    Eigen::MatrixXd by(3, linear.size());
    for (std::size_t k = 0; k < linear.size(); ++k)
      by.col(static_cast<Eigen::Index>(k)) = jacobian.block<3, 1>(0, linear[k]);
    const Eigen::VectorXd change = leastSquares(by, miss);
    for (std::size_t k = 0; k < linear.size(); ++k)
      o.position[linear[k]] += change[static_cast<Eigen::Index>(k)];
  }
}

Session centresWith(const Session& session, const std::vector<Posture>& postures, const Model& model,
                    const Eigen::VectorXd& x) {
  const SessionStates states(session, model.domain());
  Session out(session.machine);
  out.artifact = session.artifact;
  for (Feature& f : out.artifact.features) {
    f.kind = FeatureKind::kPoint;
    f.radius = f.radiusStd = 0.0;
  }
  out.artifact.tipRadius = 0.0;
  out.artifact.styli.clear();
  out.artifact.repeatability = kNotMeasured;  // that of a centre is another than that of a contact
  out.temperatures = session.temperatures;
  out.covariates = session.covariates;
  out.epoch = session.epoch;
  out.simulated = session.simulated;
  out.source = session.source;
  out.placements = session.placements;
  out.recordings = session.recordings;
  Model::Workspace work;
  for (const Posture& posture : postures) {
    if (posture.contacts.size() < kFewest)
      throw InputError(session.source + ": " + nameOf(session, posture) + " has " +
                       std::to_string(posture.contacts.size()) +
                       " contacts; a centre of its own needs four: measure more, or omit --two-steps");
    std::vector<Eigen::Vector3d> points;
    double reading = 0.0, time = 0.0;
    for (const std::size_t o : posture.contacts) {
      points.push_back(model.corrected(states[o], x.data(), work).position);
      reading += session.observations[o].laserReading / static_cast<double>(posture.contacts.size());
      time += session.observations[o].time / static_cast<double>(posture.contacts.size());
    }
    const double radius = session.artifact.features[posture.feature].radius +
                          (std::isfinite(reading) ? 0.0 : session.artifact.tipRadiusOf(0));
    Eigen::Vector3d centre, behind = Eigen::Vector3d::Zero();  // the centre is behind the surface
    for (const std::size_t o : posture.contacts) behind += radius * states[o].approach.normalized();
    for (const Eigen::Vector3d& p : points) behind += p;
    behind /= static_cast<double>(points.size());
    if (!sphereCentre(points, radius, centre, behind.allFinite() ? &behind : nullptr))
      throw InputError(session.source + ": " + nameOf(session, posture) +
                       ": its contacts do not determine a centre; spread them over more of the ball");
    Observation at = session.observations[posture.contacts[0]];
    at.time = time;
    at.laserReading = reading;
    at.approach.setConstant(kNotMeasured);
    moveTo(session, model, x, states[posture.contacts[0]], centre, at);
    out.observations.push_back(std::move(at));
  }
  out.prepare();
  return out;
}

}  // namespace

Session centresByPosture(const Session& session, const Model& model) {
  constexpr int kRounds = 5;
  constexpr double kStays = 1e-9;  // m
  const std::vector<Posture> postures = posturesOf(session);
  CalibrateOptions fit;
  fit.method = Method::kLeastSquares;
  fit.rejectOutliers = false;
  Session centres = centresWith(session, postures, model, model.start());
  for (int round = 0; round < kRounds; ++round) {
    const CalibrationResult mount = calibrate(centres, model, fit);
    Session next = centresWith(session, postures, model, mount.x.head(model.parameterCount()));
    double moved = 0.0;
    for (std::size_t o = 0; o < next.observations.size(); ++o)
      for (std::size_t j = 0; j < next.observations[o].position.size(); ++j)
        moved =
            std::max(moved, std::abs(next.observations[o].position[j] - centres.observations[o].position[j]));
    centres = std::move(next);
    if (moved < kStays) break;
  }
  return centres;
}

}  // namespace mm
