#include "design/session_doubts.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <set>

#include "base/error.h"
#include "base/format.h"
#include "base/range.h"
#include "base/units.h"

namespace mm {
namespace {

constexpr double kOneAngle = 0.5 * kDegree;
constexpr double kOneReading = 0.05e-3;  // m
constexpr double kSuspect = 50e-6;       // m: residual RMS at which a wrong sign is thought of
constexpr double kAsGood = 1.5;          // times the least residual
constexpr double kReversed = 0.2;        // share of the residual that is left when the sign was wrong

std::string rowOf(const Session& session, const Observation& o) {
  return session.source + ": " + session.rowText(o.row, o.recording) + ": ";
}

void rotaryDoubts(const Session& session, const std::vector<const Observation*>& contacts,
                  std::vector<std::string>& doubts) {
  int last = -1;  // the one that carries the probe
  for (int j = 0; j < session.machine.jointCount(); ++j)
    if (session.machine.joints()[j].kind == JointKind::kRotary) last = j;
  for (int j = 0; j < session.machine.jointCount(); ++j) {
    const Joint& joint = session.machine.joints()[j];
    if (joint.kind != JointKind::kRotary) continue;
    Range range;
    for (const Observation* o : contacts) range.add(o->position[j]);
    const auto [low, high] = range;
    if (high - low < kOneAngle)
      doubts.push_back("every posture has " + joint.name + format(" = %.4g deg: ", low / kDegree) + "what " +
                       joint.name +
                       " carries cannot be separated from the position of the artifact; measure at "
                       "two values of " +
                       joint.name + " or more, a quarter of a turn apart");
    else if (j == last && (low >= 0.0 || high <= 0.0) && joint.lower < 0.0 && joint.upper > 0.0)
      doubts.push_back(
          joint.name +
          format(" is of one sign in every posture (%.4g … %.4g deg): ", low / kDegree, high / kDegree) +
          "offsets that turn with it are weakly determined; measure with " + joint.name + " of both signs");
  }
}

void readingDoubts(const Session& session, const std::vector<const Observation*>& contacts,
                   std::vector<std::string>& doubts) {
  std::vector<double> readings;
  for (const Observation* o : contacts)
    if (std::isfinite(o->laserReading)) readings.push_back(o->laserReading);
  if (readings.empty()) return;
  std::sort(readings.begin(), readings.end());
  const auto at = [&](double share) {
    return readings[static_cast<std::size_t>(share * static_cast<double>(readings.size() - 1))];
  };
  if (readings.back() - readings.front() < kOneReading) {
    doubts.push_back(
        format("every reading of the laser is %.4g mm: ", readings.front() / kMillimetre) +
        "the direction of its beam cannot be separated from its zero; measure at both ends of its range");
    return;
  }
  constexpr std::size_t kFew = 10;
  constexpr double kFar = 5.0;  // times the range of the middle 80 %
  if (readings.size() < kFew) return;
  const double middle = at(0.5), reach = kFar * std::max(at(0.9) - at(0.1), kOneReading);
  for (const Observation* o : contacts)
    if (std::abs(o->laserReading - middle) > reach)
      doubts.push_back(rowOf(session, *o) +
                       format("reading %.4g mm is far from all others (most are %.4g … %.4g mm): ",
                              o->laserReading / kMillimetre, at(0.1) / kMillimetre, at(0.9) / kMillimetre) +
                       "out of the laser's range? if so, leave the row out");
}

/// Shortest distance of the beam's line from a point, m.
double missOf(const Problem& problem, int observation, const Eigen::VectorXd& x,
              const Eigen::Vector3d& centre) {
  constexpr double kAhead = 1e-3;  // m
  Model::Workspace work;
  State state = problem.state(observation);
  const Eigen::Vector3d spot = problem.model().corrected(state, x.data(), work).position;
  state.laserReading += kAhead;
  const Eigen::Vector3d beam =
      (problem.model().corrected(state, x.data(), work).position - spot).normalized();
  return (centre - spot).cross(beam).norm();
}

void beamDoubts(const CalibrationResult& result, std::vector<std::string>& doubts) {
  const Problem& problem = *result.problem;
  const Session& session = problem.session();
  for (std::size_t i = 0; i < session.observations.size(); ++i) {
    const Observation& o = session.observations[i];
    if (o.kind != ObservationKind::kContact || !std::isfinite(o.laserReading)) continue;
    const Feature& feature = session.artifact.features[o.feature];
    if (feature.kind != FeatureKind::kBall) continue;
    const double miss = missOf(problem, static_cast<int>(i), result.x,
                               problem.featureInWorkpiece(o.feature, o.placement, result.x));
    if (miss > feature.radius)
      doubts.push_back(rowOf(session, o) +
                       format("the beam passes the centre of '%s' at %.3g mm and misses it "
                              "(radius %.4g mm): ",
                              feature.name.c_str(), miss / kMillimetre, feature.radius / kMillimetre) +
                       "the reading is of another surface; leave the row out");
  }
}

double rmsOf(const CalibrationResult& r) { return std::isfinite(r.figures.rms) ? r.figures.rms : 0.0; }

void signDoubts(const CalibrationResult& result, std::vector<std::string>& doubts) {
  const Session& session = result.problem->session();
  const double noise = result.repeatabilityFrom == "estimated" ? 0.0 : result.repeatability;
  // outliers may be what does not fit the wrong sign
  double all = 0.0;
  int count = 0;
  for (int i = 0; i < result.residuals.size(); ++i)
    if (!result.problem->rows()[i].angular) all += std::pow(result.residuals[i], 2), ++count;
  const double whole = count > 0 ? std::sqrt(all / count) : 0.0;
  if (!(whole > std::max(kSuspect, 20.0 * noise))) return;
  CalibrateOptions fit;
  fit.method = Method::kLeastSquares;
  fit.rejectOutliers = false;
  const double before = std::max(rmsOf(result), whole);
  std::vector<std::pair<double, int>> better;
  for (int j = 0; j < session.machine.jointCount(); ++j) {
    Session reversed = session;
    for (Observation& o : reversed.observations) {
      o.position[j] = -o.position[j];
      if (j < static_cast<int>(o.velocity.size())) o.velocity[j] = -o.velocity[j];
      if (j < static_cast<int>(o.travel.size())) o.travel[j] = -o.travel[j];
    }
    try {
      const CalibrationResult other = calibrate(reversed, result.problem->model(), fit);
      if (rmsOf(other) < kReversed * before) better.emplace_back(rmsOf(other), j);
    } catch (const Error&) {  // no answer from this one
    }
  }
  if (better.empty()) return;
  std::sort(better.begin(), better.end());
  const auto nameOf = [&](std::size_t i) { return session.machine.joints()[better[i].second].name; };
  std::string others;  // a machine and its mirror image measure the same
  for (std::size_t i = 1; i < better.size(); ++i)
    if (better[i].first < kAsGood * better[0].first)
      others += (others.empty() ? ", or as well of " : ", ") + nameOf(i);
  doubts.push_back(session.source +
                   format(": with the readings of %s reversed the residual falls from %.3g to %.3g um: ",
                          nameOf(0).c_str(), before / kMicrometre, better[0].first / kMicrometre) +
                   "probably a sign error of " + nameOf(0) + others +
                   "; reverse its axis in the URDF, or its readings");
}

}  // namespace

std::vector<std::string> postureDoubts(const Session& session) {
  std::vector<std::string> doubts;
  std::vector<const Observation*> contacts;
  for (const Observation& o : session.observations)
    if (o.kind == ObservationKind::kContact) contacts.push_back(&o);
  if (contacts.empty()) return doubts;
  rotaryDoubts(session, contacts, doubts);
  readingDoubts(session, contacts, doubts);
  return doubts;
}

std::vector<std::string> repeatabilityDoubts(const CalibrationResult& r) {
  constexpr double kTooLarge = 5.0;  // times the scatter
  constexpr int kFew = 10;           // degrees of freedom: a scatter that is small by chance
  if (!r.problem || r.repeatabilityFrom != "declared" || r.figures.degreesOfFreedom < kFew) return {};
  const double times = 1.0 / std::sqrt(std::max(r.figures.chi2PerDof, 1e-18));
  if (times < kTooLarge) return {};
  const bool angular = !std::isfinite(r.figures.rms);
  const double unit = angular ? kArcsecond : kMicrometre;
  const char* const name = angular ? "arcsec" : "um";
  return {
      format("the declared repeatability of %.4g %s is %.3g times the scatter of the residuals (%.3g %s): "
             "state the standard deviation of one measurement, --repeatability-um in um, or omit it",
             r.repeatability / unit, name, times, r.repeatability / times / unit, name)};
}

std::vector<std::string> fitDoubts(const CalibrationResult& result) {
  std::vector<std::string> doubts;
  signDoubts(result, doubts);
  if (doubts.empty()) beamDoubts(result, doubts);
  for (const std::string& doubt : repeatabilityDoubts(result)) doubts.push_back(doubt);
  return doubts;
}

}  // namespace mm
