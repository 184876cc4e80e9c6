#include "design/next_measurement.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.h"
#include "base/units.h"
#include "effects/linearity.h"
#include "machine/linear_inverse.h"

namespace mm {
namespace {

constexpr int kMoves = 12;
constexpr double kSame = 1e-3;  // of an effect: what an imitation of it lacks, wherever the machine can go
constexpr double kLeastSpeed = 1e-4;  // m/s or rad/s: of a session that did not record its speeds
constexpr double kRidge = 1e-9;       // of columns of unit length: what nothing determines stays finite
constexpr double kNothing = 1e-6;     // squares of standard deviations: a move that tells less tells nothing
constexpr double kWait = 3600.0;      // s: long enough for a small machine to cool

/// Hypothetical observations after the session: now, and after the machine has cooled.
Session hypothetical(const ResidualSpace& space) {
  const Session& session = space.problem().session();
  Session next(session.machine);
  next.artifact = session.artifact;
  next.setups = session.setups;
  next.source = session.source;
  const double end = session.observations.back().time;
  for (const Series& s : session.temperatures) {
    Series t = s;
    t.time = {0.0, end + 1.0, end + 0.5 * kWait, end + 2 * kWait};
    t.value = {s.at(0.0), s.at(end), s.at(0.0), s.at(0.0)};
    next.temperatures.push_back(t);
  }
  for (const Series& s : session.covariates) {
    Series t = s;
    t.time = {0.0, end + 1.0};
    t.value = {s.at(end), s.at(end)};
    next.covariates.push_back(t);
  }
  const auto& first = session.observations.front();
  if (first.kind == ObservationKind::kContact) {
    std::vector<char> done(session.artifact.features.size(), 0);
    for (const Observation& o : session.observations) {
      if (o.kind != ObservationKind::kContact || done[o.feature]++) continue;
      const Eigen::Vector3d centre = space.problem().featureInWorkpiece(o.feature, space.fitted().x);
      const Feature& feature = session.artifact.features[o.feature];
      const double distance =
          feature.radius + (std::isfinite(o.laserReading) ? 0.0 : session.artifact.tipRadius);
      for (int i = 0; i < 26; ++i) {
        const int c = i < 13 ? i : i + 1;
        const Eigen::Vector3d side = Eigen::Vector3d(c % 3 - 1, c / 3 % 3 - 1, c / 9 - 1).normalized();
        if (side.z() < -0.1) continue;  // from below stands the stem
        for (double time : {end + 1.0, end + kWait}) {
          Observation at = o;
          at.time = time;
          at.approach = -side;
          if (!placeTip(session.machine, centre + distance * side, at.laserReading, at.position) ||
              !withinLimits(session.machine.joints(), at.position))
            continue;
          const auto jacobian = session.machine.jacobian(at.position.data(), at.laserReading);
          const double fastest = std::max(kLeastSpeed, space.problem().model().domain().maxSpeed);
          for (double speed : {fastest, 0.3 * fastest}) {
            for (int j = 0; j < session.machine.jointCount(); ++j) {
              const double v = speed * at.approach.dot(jacobian.block<3, 1>(0, j));
              at.velocity[j] = session.machine.joints()[j].kind == JointKind::kLinear ? v : 0.0;
              at.travel[j] = v > 0 ? 1.0 : v < 0 ? -1.0 : o.travel[j];
            }
            next.observations.push_back(at);
          }
        }
      }
    }
  } else {  // an independent instrument: positions over the range of each axis, in both directions, at two
            // speeds
    const Domain& domain = space.problem().model().domain();
    for (int j = 0; j < session.machine.jointCount(); ++j)
      for (int i = 0; i <= 8; ++i)
        for (double sign : {-1.0, 1.0})
          for (double share : {1.0, 0.3})
            for (double time : {end + 1.0, end + kWait}) {
              Observation at = first;
              if (!(domain.upper[j] > domain.lower[j])) continue;
              at.time = time;
              at.position[j] = domain.lower[j] + (domain.upper[j] - domain.lower[j]) * i / 8.0;
              at.travel[j] = sign;
              const double speed = std::isfinite(first.velocity[j]) ? std::abs(first.velocity[j]) : 0.0;
              at.velocity[j] = sign * share * std::max(kLeastSpeed, speed);
              at.deviation.assign(at.deviation.size(), kNotMeasured);
              if (at.kind == ObservationKind::kDeviation) at.deviation[j] = 0.0;
              next.observations.push_back(at);
            }
  }
  std::stable_sort(next.observations.begin(), next.observations.end(),
                   [](auto& a, auto& b) { return a.time < b.time; });
  return next;
}

/// Columns of a hypothesis; 0 in rows that lack an input of it.
Eigen::MatrixXd columnsOf(const Linearisation& at, const Hypothesis& hypothesis) {
  const Effect& effect = *hypothesis.effect;
  return linearColumns(effect, at.effectColumns(effect, startsAt(effect, hypothesis.nonlinear)))
      .unaryExpr([](double v) { return std::isfinite(v) ? v : 0.0; });
}

Move moveOf(const Session& session, const Observation& o, double end) {
  Move move;
  for (int j = 0; j < session.machine.jointCount(); ++j) {
    const Joint& joint = session.machine.joints()[j];
    const bool linear = joint.kind == JointKind::kLinear;
    move.values.emplace_back(joint.name + (linear ? "_mm" : "_deg"),
                             o.position[j] / (linear ? kMillimetre : kDegree));
  }
  double fastest = 0.0;  // of the tip, or of the joint that is measured
  for (int j = 0; j < session.machine.jointCount(); ++j)
    if (std::isfinite(o.velocity[j]) && session.machine.joints()[j].kind == JointKind::kLinear)
      fastest = o.kind == ObservationKind::kContact ? std::hypot(fastest, o.velocity[j])
                                                    : std::max(fastest, std::abs(o.velocity[j]));
  if (fastest > 0.0) move.values.emplace_back("speed_mm_s", fastest / kMillimetre);
  if (o.kind == ObservationKind::kDeviation)
    for (int j = 0; j < session.machine.jointCount(); ++j)
      if (std::isfinite(o.deviation[j])) {
        move.words.emplace_back("reference", session.machine.joints()[j].name);
        move.from.emplace_back(session.machine.joints()[j].name, o.travel[j] > 0 ? -1.0 : 1.0);
      }
  if (o.kind == ObservationKind::kContact) {
    move.words.emplace_back("feature", session.artifact.features[o.feature].name);
    move.approach = {o.approach.x(), o.approach.y(), o.approach.z()};
  }
  if (o.time - end > 0.5 * kWait) move.values.emplace_back("wait_s", kWait);
  return move;
}

/// One row more is measured: covariance and predicted variances by a rank-one update.
void measured(const Eigen::MatrixXd& rows, int row, Eigen::MatrixXd& covariance,
              Eigen::VectorXd& uncertainty) {
  const Eigen::VectorXd gain = covariance * rows.row(row).transpose();
  const double total = 1.0 + rows.row(row).dot(gain);
  uncertainty -= (rows * gain).cwiseAbs2() / total;
  covariance -= gain * gain.transpose() / total;
}

}  // namespace

NextMeasurement nextMeasurement(const ResidualSpace& space, const Hypothesis& own,
                                const std::vector<Hypothesis>& rivals) {
  NextMeasurement out;
  if (rivals.empty()) return out;
  const Session next = hypothetical(space);
  if (next.observations.empty()) return out;
  const Problem& problem = space.problem();
  try {
    const Problem future(next, problem.model(), problem.datum());
    if (future.unknownCount() != problem.unknownCount()) return out;
    const Linearisation& atNow = space.linearisation();
    const Linearisation atNext = linearise(future, space.fitted().x);

    const Eigen::VectorXd inverse = space.fitted().weight.cwiseSqrt().cwiseQuotient(space.fitted().sigma);
    const double sigma = 1.0 / inverse.maxCoeff();
    const auto whitened = [&](Eigen::MatrixXd m) {
      for (int i = 0; i < m.rows(); ++i) m.row(i) *= inverse[i];
      return m;
    };
    const Eigen::MatrixXd ownNow = whitened(columnsOf(atNow, own)), ownNext = columnsOf(atNext, own) / sigma;
    // the leading hypothesis at its fitted size
    Eigen::MatrixXd left = Eigen::MatrixXd::Zero(space.length(), ownNow.cols());
    for (int i = 0; i < space.rows(); ++i) left.row(i) = ownNow.row(space.used()[i]);
    space.project(left);
    const Eigen::VectorXd size = left.colPivHouseholderQr().solve(space.target());

    const int free = problem.unknownCount();
    std::vector<Eigen::VectorXd>
        misses;  // a rival: how far its imitation is from the leading hypothesis, a future row
    std::vector<Eigen::MatrixXd> nextRows;
    std::vector<Eigen::MatrixXd> covariances;    // of each rival's unknowns, by all that is measured so far
    std::vector<Eigen::VectorXd> uncertainties;  // variance of its prediction, a future row
    for (const Hypothesis& rival : rivals) {
      const Eigen::MatrixXd rivalNow = whitened(columnsOf(atNow, rival)),
                            rivalNext = columnsOf(atNext, rival) / sigma;
      Eigen::MatrixXd now(atNow.jacobian().rows(), free + rivalNow.cols()),
          later(atNext.jacobian().rows(), free + rivalNow.cols());
      now << whitened(atNow.jacobian()), rivalNow;
      later << atNext.jacobian() / sigma, rivalNext;
      for (int c = 0; c < now.cols(); ++c) {  // held unknowns do not imitate
        const double norm = now.col(c).norm();
        if (!(norm > 0.0) || (c < free && space.fitted().identifiability.fixed[c])) {
          now.col(c).setZero();
          later.col(c).setZero();
        } else {
          now.col(c) /= norm;
          later.col(c) /= norm;
        }
      }
      const Eigen::MatrixXd gram =
          now.transpose() * now + kRidge * Eigen::MatrixXd::Identity(now.cols(), now.cols());
      const Eigen::LDLT<Eigen::MatrixXd> solver(gram);
      const Eigen::VectorXd imitation = solver.solve(now.transpose() * (ownNow * size));
      misses.push_back(ownNext * size - later * imitation);
      out.rivals.push_back({misses.back().norm() < kSame * (ownNext * size).norm(), 0.0});
      covariances.push_back(solver.solve(Eigen::MatrixXd::Identity(gram.rows(), gram.cols())));
      uncertainties.push_back((later * covariances.back()).cwiseProduct(later).rowwise().sum());
      nextRows.push_back(later);
    }
    const auto told = [&](std::size_t r, int observation) {  // in squares of standard deviations
      double sum = 0.0;
      for (int i = future.firstRow(observation); i < future.firstRow(observation + 1); ++i)
        sum += misses[r][i] * misses[r][i] / (1.0 + std::max(0.0, uncertainties[r][i]));
      return sum;
    };
    if (std::all_of(out.rivals.begin(), out.rivals.end(), [](const auto& r) { return r.same; })) return out;
    std::vector<char> taken(next.observations.size(), 0);
    const double end = problem.session().observations.back().time;
    std::vector<std::pair<double, Move>> chosen;
    for (int m = 0; m < kMoves; ++m) {
      double best = kNothing;
      int pick = -1;
      for (std::size_t o = 0; o < next.observations.size(); ++o) {
        if (taken[o]) continue;
        double worst = std::numeric_limits<double>::infinity();  // the rival that is told apart least
        for (std::size_t r = 0; r < rivals.size(); ++r)
          if (!out.rivals[r].same) worst = std::min(worst, told(r, static_cast<int>(o)));
        if (worst > best) best = worst, pick = static_cast<int>(o);
      }
      if (pick < 0) break;
      taken[pick] = 1;
      for (std::size_t r = 0; r < rivals.size(); ++r) {
        out.rivals[r].deviations = std::sqrt(std::pow(out.rivals[r].deviations, 2) + told(r, pick));
        for (int i = future.firstRow(pick); i < future.firstRow(pick + 1); ++i)
          measured(nextRows[r], i, covariances[r], uncertainties[r]);
      }
      chosen.emplace_back(next.observations[pick].time,
                          moveOf(problem.session(), next.observations[pick], end));
    }
    std::stable_sort(chosen.begin(), chosen.end(), [](auto& a, auto& b) { return a.first < b.first; });
    bool waited = false;
    for (auto& [time, move] : chosen) {  // one wait, before the first of the later moves
      auto& v = move.values;
      const auto wait = std::find_if(v.begin(), v.end(), [](auto& p) { return p.first == "wait_s"; });
      if (wait != v.end() && waited)
        v.erase(wait);
      else
        waited |= wait != v.end();
      out.moves.push_back(move);
    }
  } catch (const InputError&) {
    out = {};  // the model cannot be evaluated at states that were not measured
  }
  return out;
}

}  // namespace mm
