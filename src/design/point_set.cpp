#include "design/point_set.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "base/dense.h"
#include "base/units.h"
#include "design/session_doubts.h"
#include "effects/linearity.h"
#include "effects/registry.h"
#include "estimation/fitter.h"
#include "estimation/whitened.h"
#include "model/observed_domain.h"

namespace mm {
namespace {

double correlation(const std::vector<double>& a, const std::vector<double>& b) {
  double meanA = 0.0, meanB = 0.0;
  int n = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    if (std::isfinite(a[i]) && std::isfinite(b[i])) meanA += a[i], meanB += b[i], ++n;
  if (n < 3) return 0.0;
  meanA /= n, meanB /= n;
  double aa = 0.0, bb = 0.0, ab = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (!std::isfinite(a[i]) || !std::isfinite(b[i])) continue;
    aa += (a[i] - meanA) * (a[i] - meanA);
    bb += (b[i] - meanB) * (b[i] - meanB);
    ab += (a[i] - meanA) * (b[i] - meanB);
  }
  return aa > 0.0 && bb > 0.0 ? ab / std::sqrt(aa * bb) : 0.0;
}

std::vector<double> timesOf(const Session& session) {
  std::vector<double> times;
  for (const Observation& o : session.observations) times.push_back(o.time);
  return times;
}

std::vector<FeatureCoverage> coverFeatures(const Problem& problem) {
  const Session& session = problem.session();
  std::vector<FeatureCoverage> all;
  for (std::size_t f = 0; f < session.artifact.features.size(); ++f) {
    FeatureCoverage cover;
    cover.name = session.artifact.features[f].name;
    cover.ball = session.artifact.features[f].kind == FeatureKind::kBall;
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
    const Eigen::Vector3d centre = problem.featureInWorkpiece(
        static_cast<int>(f), session.placementOf(static_cast<int>(f)), problem.start());
    std::vector<Eigen::Vector3d> approaches;
    for (std::size_t o = 0; o < session.observations.size(); ++o) {
      const Observation& at = session.observations[o];
      if (at.feature != static_cast<int>(f)) continue;
      ++(at.kind == ObservationKind::kContact ? cover.contacts : cover.lengths);
      if (at.kind != ObservationKind::kContact) continue;
      const Eigen::Vector3d from = session.machine.nominal(at.position.data(), at.laserReading).position;
      Eigen::Vector3d approach = problem.state(static_cast<int>(o)).approach;
      if (cover.ball && (centre - from).norm() > 0.0) approach = (centre - from).normalized();
      if (!approach.allFinite() || approach.norm() < 0.5) continue;
      approaches.push_back(approach);
      mean += approach;
      information += approach * approach.transpose();
    }
    cover.coneHalfAngle = approaches.empty() || !cover.ball ? kNotMeasured : 0.0;
    constexpr double kAllRound = 1e-6;  // of a unit vector: approaches from all sides cancel up to rounding
    if (cover.ball && mean.norm() > kAllRound * static_cast<double>(approaches.size()))
      for (const Eigen::Vector3d& a : approaches)
        cover.coneHalfAngle =
            std::max(cover.coneHalfAngle, std::acos(std::clamp(a.dot(mean.normalized()), -1.0, 1.0)));
    else if (cover.ball && !approaches.empty())
      cover.coneHalfAngle = kPi;  // from all sides
    if (cover.ball && approaches.size() >= 3) {
      const double weakest = SymmetricEigen(information).values[0];
      constexpr double kFlat = 1e-9;  // of one contact: no approach has a part along this direction
      if (weakest > kFlat) cover.centrePerNoise = 1.0 / std::sqrt(weakest);
    }
    all.push_back(cover);
  }
  return all;
}

std::vector<JointCoverage> coverJoints(const Session& session, const Domain& domain) {
  const std::vector<double> times = timesOf(session);
  std::vector<JointCoverage> all;
  for (std::size_t j = 0; j < domain.joints.size(); ++j) {
    JointCoverage cover;
    cover.name = domain.joints[j].name;
    cover.rotary = domain.joints[j].kind == JointKind::kRotary;
    cover.lower = domain.lower[j];
    cover.upper = domain.upper[j];
    cover.positions = static_cast<int>(domain.positions[j].size());
    std::vector<double> position;
    for (const Observation& o : session.observations) {
      position.push_back(o.position[j]);
      const double travel = j < o.travel.size() ? o.travel[j] : 0.0;
      ++(travel > 0.0 ? cover.up : travel < 0.0 ? cover.down : cover.unknown);
      const double speed = j < o.velocity.size() ? std::abs(o.velocity[j]) : kNotMeasured;
      if (!(speed > 0.0)) continue;
      cover.slowest = std::fmin(cover.slowest, speed);
      cover.fastest = std::fmax(cover.fastest, speed);
    }
    cover.withTime = correlation(position, times);
    all.push_back(cover);
  }
  return all;
}

void coverInputs(const Session& session, const std::vector<Series>& logged, bool temperature,
                 std::vector<InputCoverage>& all) {
  const std::vector<double> times = timesOf(session);
  for (const Series& series : logged) {
    InputCoverage cover{series.name, temperature ? "degC" : series.unit, temperature};
    std::vector<double> values;
    for (const double t : times) {
      values.push_back(series.at(t));
      if (!std::isfinite(values.back())) ++cover.missing;
      cover.lower = std::fmin(cover.lower, values.back());
      cover.upper = std::fmax(cover.upper, values.back());
    }
    cover.withTime = correlation(values, times);
    all.push_back(cover);
  }
}

/// Orthonormal basis of what the free unknowns, and a constant in each measured component, can explain of the
/// data rows. Touches of balls have no such constant: an artifact that lies elsewhere moves opposite sides of
/// a ball in opposite senses, and what moves both alike is a radius.
Eigen::MatrixXd explainedBy(const Linearisation& at, const Eigen::VectorXd& inverse,
                            const std::vector<char>& fixed) {
  const Problem& problem = at.problem();
  const WhitenedSystem system(at, inverse, fixed);
  const int data = problem.rowCount(), free = static_cast<int>(system.free.size());
  constexpr int kNone = -1;
  std::vector<int> constantOf;
  std::vector<std::pair<ObservationKind, int>> constants;
  const Session& session = problem.session();
  for (const ResidualRow& row : problem.rows()) {
    const Observation& seen = session.observations[static_cast<std::size_t>(row.observation)];
    if (seen.kind == ObservationKind::kContact &&
        session.artifact.features[static_cast<std::size_t>(seen.feature)].kind == FeatureKind::kBall) {
      constantOf.push_back(kNone);
      continue;
    }
    const std::pair<ObservationKind, int> key(seen.kind, row.component);
    auto found = std::find(constants.begin(), constants.end(), key);
    if (found == constants.end()) found = constants.insert(found, key);
    constantOf.push_back(static_cast<int>(found - constants.begin()));
  }
  Eigen::MatrixXd all =
      Eigen::MatrixXd::Zero(system.jacobian.rows(), free + static_cast<Eigen::Index>(constants.size()));
  all.leftCols(free) = system.jacobian;
  for (int i = 0; i < data; ++i)
    if (const int k = constantOf[static_cast<std::size_t>(i)]; k != kNone) all(i, free + k) = inverse[i];
  if (all.rows() == 0 || all.cols() == 0) return Eigen::MatrixXd(data, 0);
  return spanOf(all).topRows(data);
}

/// Judges each member of the catalogue by what is left of its columns beside those of the model and the
/// artifact.
std::vector<CannotBeShown> judgeCatalogue(const Problem& problem, const Identifiability& identifiability,
                                          const Eigen::VectorXd& inverse) {
  const Domain& domain = problem.model().domain();
  const Eigen::VectorXd x = problem.start();
  const Linearisation at = linearise(problem, x);
  const Eigen::MatrixXd q = explainedBy(at, inverse, identifiability.fixed);
  std::vector<CannotBeShown> hidden;
  for (const EffectType& type : effectRegistry()) {
    if (type.composite || !type.candidates) continue;
    for (const EffectSpec& spec : type.candidates(domain)) {
      const EffectPtr effect = createEffect(spec, domain);
      const auto& inModel = problem.model().effects();
      if (std::any_of(inModel.begin(), inModel.end(),
                      [&](const EffectPtr& e) { return e->spec() == effect->spec(); }))
        continue;
      const auto starts = effect->nature().searchStarts;
      const std::vector<double> p =
          startsAt(*effect, starts.empty() ? std::vector<double>() : starts[starts.size() / 2]);
      Eigen::MatrixXd all = inverse.asDiagonal() * at.effectColumns(*effect, p);
      int unknown = 0;  // rows that lack an input; a fit leaves them out, as long as they are few
      for (Eigen::Index i = 0; i < all.rows(); ++i) {
        if (all.row(i).allFinite()) continue;
        ++unknown;
        if (5 * unknown <= all.rows()) all.row(i).setZero();
      }
      if (!all.allFinite()) {
        hidden.push_back(
            {spec, "an input that it needs is unknown for some observations", effect->shownBy()});
        continue;
      }
      double seen = 0.0, alone = 0.0;  // in typical sizes over the noise
      for (const int k : linearParameters(*effect)) {
        const Eigen::VectorXd column = all.col(k) * effect->parameters()[static_cast<std::size_t>(k)].scale;
        alone = std::max(alone, column.norm());
        seen = std::max(seen, (column - q * (q.transpose() * column)).norm());
      }
      constexpr double kImitated = 1e-3;  // what others leave of an effect that they imitate
      if (!(alone > 0.0))
        hidden.push_back({spec, "no measurement of this session depends on it", effect->shownBy()});
      else if (seen < kImitated * alone)
        hidden.push_back({spec,
                          "in this session it is equivalent to a constant, to the pose of the artifact or to "
                          "effects of the model",
                          effect->shownBy()});
    }
  }
  return hidden;
}

}  // namespace

PointSet checkPointSet(const Session& session, const ModelSpec* spec) {
  PointSet set;
  set.questions = sensibleDoubts(session);
  for (const Observation& o : session.observations)
    ++(o.kind == ObservationKind::kContact ? set.contacts : set.references);
  const Domain domain = observedDomain(session);
  set.duration = domain.duration;
  auto problem = std::make_shared<Problem>(
      session, Model(session.machine, domain, spec != nullptr ? spec->effects : std::vector<EffectSpec>()));
  set.problem = problem;
  set.hasModel = spec != nullptr;
  set.features = coverFeatures(*problem);
  set.joints = coverJoints(session, domain);
  coverInputs(session, session.temperatures, true, set.inputs);
  coverInputs(session, session.covariates, false, set.inputs);

  const double stated =
      spec != nullptr && spec->repeatability > 0.0 ? spec->repeatability : session.artifact.repeatability;
  set.noiseDeclared = stated > 0.0;
  set.noise = set.noiseDeclared ? stated : kMicrometre;
  const Eigen::VectorXd inverse = inverseOf(problem->sigmas(set.noise, kArcsecond), usableWeight(*problem));
  const Eigen::VectorXd x = problem->start();
  set.identifiability = identify(*problem, x, inverse, true);
  const WhitenedSystem system(*problem, x, inverse, set.identifiability.fixed);
  const int columns = static_cast<int>(system.free.size());
  if (set.hasModel && columns > 0 && system.jacobian.rows() >= columns) {
    const Eigen::MatrixXd inverseR = triangleOf(system.jacobian)
                                         .triangularView<Eigen::Upper>()
                                         .solve(Eigen::MatrixXd::Identity(columns, columns));
    for (int c = 0; c < columns; ++c) {
      const Unknown& u =
          problem->unknowns()[static_cast<std::size_t>(system.free[static_cast<std::size_t>(c)])];
      if (u.kind != UnknownKind::kEffect) continue;
      const double std = inverseR.row(c).norm() * system.scale[c];
      if (std > u.scale)
        set.weak.push_back(
            {displayName(*problem, system.free[static_cast<std::size_t>(c)]), u.unit, std * u.toUnit});
    }
  }
  set.doubts = postureDoubts(session);
  if (set.hasModel) set.advice = proposePostures(*problem, x, inverse);
  set.separations = separationsOf(session);
  set.cannotShow = judgeCatalogue(*problem, set.identifiability, inverse);
  return set;
}

}  // namespace mm
