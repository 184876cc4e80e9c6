#include "design/next_measurement.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.h"
#include "base/units.h"
#include "design/hypothetical_session.h"
#include "effects/linearity.h"
#include "estimation/linearisation.h"

namespace mm {
namespace {

constexpr int kMoves = 12;
constexpr double kSame = 1e-3;     // of an effect: what an imitation of it lacks, wherever the machine can go
constexpr double kRidge = 1e-9;    // of columns of unit length: what nothing determines stays finite
constexpr double kNothing = 1e-6;  // squares of standard deviations: a move that tells less tells nothing

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
  if (o.time - end > 0.5 * kCooling) move.values.emplace_back("wait_s", kCooling);
  return move;
}

/// What is measured now, and what could be measured next, by one linearisation each.
struct Views {
  Views(const ResidualSpace& space, const Problem& future)
      : space(space),
        future(future),
        now(space.linearisation()),
        next(linearise(future, space.fitted().x)),
        inverse(space.fitted().weight.cwiseSqrt().cwiseQuotient(space.fitted().sigma)),
        sigma(1.0 / inverse.maxCoeff()) {}
  Eigen::MatrixXd whitened(Eigen::MatrixXd m) const {
    for (int i = 0; i < m.rows(); ++i) m.row(i) *= inverse[i];
    return m;
  }
  const ResidualSpace& space;
  const Problem& future;
  const Linearisation& now;
  const Linearisation next;
  const Eigen::VectorXd inverse;  // a data row: 1 / standard deviation
  const double sigma;             // of the most precise row: what a future row is taken to have
};

/// The leading hypothesis at its fitted size: what it does to the rows, in standard deviations.
struct Leading {
  Leading(const Views& views, const Hypothesis& own)
      : now(views.whitened(columnsOf(views.now, own))), next(columnsOf(views.next, own) / views.sigma) {
    const ResidualSpace& space = views.space;
    Eigen::MatrixXd left = Eigen::MatrixXd::Zero(space.length(), now.cols());
    for (int i = 0; i < space.rows(); ++i) left.row(i) = now.row(space.used()[i]);
    space.project(left);
    const Eigen::VectorXd size = left.colPivHouseholderQr().solve(space.target());
    now *= size;
    next *= size;
  }
  Eigen::MatrixXd now, next;  // one column
};

/// How well one rival imitates the leading hypothesis in what is still to be measured.
class Imitation {
 public:
  Imitation(const Views& views, const Hypothesis& rival, const Leading& leading) : future_(views.future) {
    const Eigen::MatrixXd rivalNow = views.whitened(columnsOf(views.now, rival)),
                          rivalNext = columnsOf(views.next, rival) / views.sigma;
    const Eigen::Index free = views.now.jacobian().cols();
    Eigen::MatrixXd now(views.now.jacobian().rows(), free + rivalNow.cols());
    later_.resize(views.next.jacobian().rows(), free + rivalNow.cols());
    now << views.whitened(views.now.jacobian()), rivalNow;
    later_ << views.next.jacobian() / views.sigma, rivalNext;
    for (int c = 0; c < now.cols(); ++c) {  // held unknowns do not imitate
      const double norm = now.col(c).norm();
      if (!(norm > 0.0) || (c < free && views.space.fitted().identifiability.fixed[c])) {
        now.col(c).setZero();
        later_.col(c).setZero();
      } else {
        now.col(c) /= norm;
        later_.col(c) /= norm;
      }
    }
    const Eigen::MatrixXd gram =
        now.transpose() * now + kRidge * Eigen::MatrixXd::Identity(now.cols(), now.cols());
    const Eigen::LDLT<Eigen::MatrixXd> solver(gram);
    misses_ = leading.next - later_ * solver.solve(now.transpose() * leading.now);
    same_ = misses_.norm() < kSame * leading.next.norm();
    covariance_ = solver.solve(Eigen::MatrixXd::Identity(gram.rows(), gram.cols()));
    variance_ = (later_ * covariance_).cwiseProduct(later_).rowwise().sum();
  }
  bool same() const { return same_; }
  /// What an observation would tell of the two, in squares of standard deviations.
  double told(int observation) const {
    double sum = 0.0;
    for (int i = future_.firstRow(observation); i < future_.firstRow(observation + 1); ++i)
      sum += misses_[i] * misses_[i] / (1.0 + std::max(0.0, variance_[i]));
    return sum;
  }
  /// It is measured: covariance and predicted variances by a rank-one update a row.
  void measured(int observation) {
    for (int i = future_.firstRow(observation); i < future_.firstRow(observation + 1); ++i) {
      const Eigen::VectorXd gain = covariance_ * later_.row(i).transpose();
      const double total = 1.0 + later_.row(i).dot(gain);
      variance_ -= (later_ * gain).cwiseAbs2() / total;
      covariance_ -= gain * gain.transpose() / total;
    }
  }

 private:
  const Problem& future_;
  Eigen::MatrixXd later_;       // columns of the model and of the rival, a future row
  Eigen::VectorXd misses_;      // how far its imitation is from the leading hypothesis, a future row
  Eigen::MatrixXd covariance_;  // of its unknowns, by all that is measured so far
  Eigen::VectorXd variance_;    // of its prediction, a future row
  bool same_ = false;
};

/// One wait, before the first of the later moves.
std::vector<Move> withOneWait(std::vector<std::pair<double, Move>> chosen) {
  std::stable_sort(chosen.begin(), chosen.end(), [](auto& a, auto& b) { return a.first < b.first; });
  std::vector<Move> moves;
  bool waited = false;
  for (auto& [time, move] : chosen) {
    auto& v = move.values;
    const auto wait = std::find_if(v.begin(), v.end(), [](auto& p) { return p.first == "wait_s"; });
    if (wait != v.end() && waited)
      v.erase(wait);
    else
      waited |= wait != v.end();
    moves.push_back(move);
  }
  return moves;
}

/// One move after the other, each that which tells most of the rival that is told apart least.
void choose(const Session& next, double end, std::vector<Imitation>& imitations, NextMeasurement& out) {
  std::vector<char> taken(next.observations.size(), 0);
  std::vector<std::pair<double, Move>> chosen;
  for (int m = 0; m < kMoves; ++m) {
    double best = kNothing;
    int pick = -1;
    for (int o = 0; o < static_cast<int>(next.observations.size()); ++o) {
      if (taken[o]) continue;
      double worst = std::numeric_limits<double>::infinity();
      for (const Imitation& rival : imitations)
        if (!rival.same()) worst = std::min(worst, rival.told(o));
      if (worst > best) best = worst, pick = o;
    }
    if (pick < 0) break;
    taken[pick] = 1;
    for (std::size_t r = 0; r < imitations.size(); ++r) {
      out.rivals[r].deviations = std::sqrt(std::pow(out.rivals[r].deviations, 2) + imitations[r].told(pick));
      imitations[r].measured(pick);
    }
    chosen.emplace_back(next.observations[pick].time, moveOf(next, next.observations[pick], end));
  }
  out.moves = withOneWait(std::move(chosen));
}

}  // namespace

NextMeasurement nextMeasurement(const ResidualSpace& space, const Hypothesis& own,
                                const std::vector<Hypothesis>& rivals) {
  NextMeasurement out;
  if (rivals.empty()) return out;
  const Session next = hypotheticalSession(space);
  if (next.observations.empty()) return out;
  const Problem& problem = space.problem();
  try {
    const Problem future(next, problem.model(), problem.datum());
    if (future.unknownCount() != problem.unknownCount()) return out;
    const Views views(space, future);
    const Leading leading(views, own);
    std::vector<Imitation> imitations;
    for (const Hypothesis& rival : rivals) {
      Imitation ofLeading(views, rival, leading);
      if (ofLeading
              .same())  // the rival may be the wider law of the two: then its rest is what tells them apart
        imitations.emplace_back(views, own, Leading(views, rival));
      else
        imitations.push_back(std::move(ofLeading));
      out.rivals.push_back({imitations.back().same(), 0.0});
    }
    if (std::any_of(imitations.begin(), imitations.end(), [](const Imitation& r) { return !r.same(); }))
      choose(next, problem.session().observations.back().time, imitations, out);
  } catch (const InputError&) {
    out = {};  // the model cannot be evaluated at states that were not measured
  }
  return out;
}

}  // namespace mm
