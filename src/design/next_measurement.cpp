#include "design/next_measurement.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>

#include "base/dense.h"
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

/// @param before the session that was measured. @param stand where the artifact is then.
Move moveOf(const Session& before, const Stand& stand, const Problem& whole, const Eigen::VectorXd& x,
            const Observation& o) {
  const Session& session = whole.session();
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
    std::string placement = stand.placement;
    if (placement.empty() && before.recordings.empty() && !before.placements.empty())
      placement = before.placements[static_cast<std::size_t>(before.observations.back().placement)];
    if (!placement.empty()) {
      move.words.emplace_back("placement", placement);
      const Eigen::Matrix3d rotation = whole.artifactRotation(o.placement, x);
      move.turn = std::atan2(rotation(1, 0), rotation(0, 0));
      move.shift = whole.artifactPlace(o.placement, x);
    }
    if (!session.artifact.styli.empty())
      move.words.emplace_back("stylus", session.artifact.styli[o.stylus].name);
  }
  if (o.time - before.observations.back().time > 0.5 * kCooling) move.values.emplace_back("wait_s", kCooling);
  return move;
}

/// How far an unknown is behind the first of its kind and owner.
int offsetIn(const Problem& problem, int unknown) {
  const Unknown& u = problem.unknowns()[static_cast<std::size_t>(unknown)];
  return unknown - problem.find(u.kind, u.owner);
}

/// What is measured now, and what could be measured next, in one linearisation: the later rows are the next.
struct Views {
  Views(const ResidualSpace& space, const Problem& whole)
      : space(space),
        whole(whole),
        x(valuesOf(space, whole)),
        at(linearise(whole, x)),
        rows(space.problem().rowCount()),
        inverse(space.fitted().weight.cwiseSqrt().cwiseQuotient(space.fitted().sigma)),
        sigma(1.0 / inverse.maxCoeff()) {
    const auto& fixed = space.fitted().identifiability.fixed;
    for (int u = 0; u < whole.unknownCount(); ++u) {
      const Unknown& unknown = whole.unknowns()[static_cast<std::size_t>(u)];
      const int known = space.problem().find(unknown.kind, unknown.owner);
      held.push_back(known >= 0 ? fixed[static_cast<std::size_t>(known + offsetIn(whole, u))] : 0);
      if (known < 0) added.push_back(u);
    }
  }
  /// What was fitted; what the moves add to it at its start.
  static Eigen::VectorXd valuesOf(const ResidualSpace& space, const Problem& whole) {
    Eigen::VectorXd x = whole.start();
    for (int u = 0; u < whole.unknownCount(); ++u) {
      const Unknown& unknown = whole.unknowns()[static_cast<std::size_t>(u)];
      const int known = space.problem().find(unknown.kind, unknown.owner);
      if (known >= 0) x[u] = space.fitted().x[known + offsetIn(whole, u)];
    }
    return x;
  }
  /// The rows of what is measured, in standard deviations; and of what could be.
  Eigen::MatrixXd now(const Eigen::MatrixXd& columns) const {
    return inverse.asDiagonal() * columns.topRows(rows);
  }
  Eigen::MatrixXd next(const Eigen::MatrixXd& columns) const {
    return columns.bottomRows(columns.rows() - rows) / sigma;
  }

  const ResidualSpace& space;
  const Problem& whole;
  const Eigen::VectorXd x;
  const Linearisation at;
  const Eigen::Index rows;        // measured
  const Eigen::VectorXd inverse;  // a measured row: 1 / standard deviation
  const double sigma;             // of the most precise row: what a future row is taken to have
  std::vector<char> held;         // an unknown
  std::vector<int> added;         // unknowns that only what could be measured has
};

/// The leading hypothesis at its fitted size: what it does to the rows, in standard deviations.
struct Leading {
  Leading(const Views& views, const Hypothesis& own) {
    const Eigen::MatrixXd columns = columnsOf(views.at, own);
    now = views.now(columns);
    next = views.next(columns);
    const ResidualSpace& space = views.space;
    Eigen::MatrixXd left = Eigen::MatrixXd::Zero(space.length(), now.cols());
    for (int i = 0; i < space.rows(); ++i) left.row(i) = now.row(space.used()[i]);
    space.project(left);
    const Eigen::VectorXd size = leastSquares(left, space.target());
    now *= size;
    next *= size;
  }
  Eigen::MatrixXd now, next;  // one column
};

/// How well one rival imitates the leading hypothesis in what is still to be measured.
class Imitation {
 public:
  Imitation(const Views& views, const Hypothesis& rival, const Leading& leading) : views_(&views) {
    const Eigen::MatrixXd columns = columnsOf(views.at, rival);
    const Eigen::Index free = views.at.jacobian().cols();
    Eigen::MatrixXd now(views.rows, free + columns.cols());
    later_.resize(views.at.jacobian().rows() - views.rows, free + columns.cols());
    now << views.now(views.at.jacobian()), views.now(columns);
    later_ << views.next(views.at.jacobian()), views.next(columns);
    for (int c = 0; c < now.cols(); ++c) {  // held unknowns do not imitate
      double norm = now.col(c).norm();
      if (!(norm > 0.0)) norm = later_.col(c).norm();  // nothing tells it yet
      if (!(norm > 0.0) || (c < free && views.held[static_cast<std::size_t>(c)] != 0)) {
        now.col(c).setZero();
        later_.col(c).setZero();
      } else {
        now.col(c) /= norm;
        later_.col(c) /= norm;
      }
    }
    const Eigen::MatrixXd gram =
        now.transpose() * now + kRidge * Eigen::MatrixXd::Identity(now.cols(), now.cols());
    covariance_ = inverseOfSymmetric(gram);
    misses_ = leading.next - later_ * (covariance_ * (now.transpose() * leading.now));
    same_ = leftOf(misses_) < kSame * leading.next.norm();
    variance_ = (later_ * covariance_).cwiseProduct(later_).rowwise().sum();
  }
  bool same() const { return same_; }
  /// What an observation would tell of the two, in squares of standard deviations.
  double told(int observation) const {
    double sum = 0.0;
    for (int i = firstRow(observation); i < firstRow(observation + 1); ++i)
      sum += misses_[i] * misses_[i] / (1.0 + std::max(0.0, variance_[i]));
    return sum;
  }
  /// How little is known of what an observation will be: its variance, of that of its noise.
  double unknown(int observation) const { return variance_[firstRow(observation)]; }
  /// It is measured: unknowns and predictions by a rank-one update a row. @return what it told of the two.
  double measured(int observation) {
    double sum = 0.0;
    for (int i = firstRow(observation); i < firstRow(observation + 1); ++i) {
      const Eigen::VectorXd gain = covariance_ * later_.row(i).transpose();
      const double total = 1.0 + later_.row(i).dot(gain), miss = misses_[i];
      const Eigen::VectorXd moves = later_ * gain;
      sum += miss * miss / total;
      misses_ -= moves * (miss / total);
      variance_ -= moves.cwiseAbs2() / total;
      covariance_ -= gain * gain.transpose() / total;
    }
    return sum;
  }

 private:
  /// The first row of one of the observations that could be made.
  int firstRow(int observation) const {
    const int before = static_cast<int>(views_->space.problem().session().observations.size());
    return views_->whole.firstRow(before + observation) - static_cast<int>(views_->rows);
  }
  /// What is left of a column where the unknowns that are added take what they can.
  double leftOf(const Eigen::VectorXd& column) const {
    if (views_->added.empty()) return column.norm();
    const Eigen::MatrixXd of = later_(Eigen::all, views_->added);
    return (column - of * leastSquares(of, column)).norm();
  }

  const Views* views_;
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

/// One move after the other, each that which tells most of the rival that is told apart least; before them,
/// where the artifact was turned, those that tell how it lies.
void choose(const Views& views, const Stand& stand, std::vector<Imitation>& imitations,
            NextMeasurement& out) {
  const Session& next = views.whole.session();
  const Session& measured = views.space.problem().session();
  const int before = static_cast<int>(measured.observations.size()),
            count = static_cast<int>(next.observations.size()) - before,
            lies = static_cast<int>(views.added.size());
  std::vector<char> taken(static_cast<std::size_t>(count), 0);
  std::vector<std::pair<double, Move>> chosen;
  for (int m = 0; m < lies + kMoves; ++m) {
    double best = m < lies ? 0.0 : kNothing;
    int pick = -1;
    for (int o = 0; o < count; ++o) {
      if (taken[static_cast<std::size_t>(o)] != 0) continue;
      double worst = std::numeric_limits<double>::infinity();
      for (const Imitation& rival : imitations)
        if (!rival.same()) worst = std::min(worst, m < lies ? rival.unknown(o) : rival.told(o));
      if (worst > best) best = worst, pick = o;
    }
    if (pick < 0) break;
    taken[static_cast<std::size_t>(pick)] = 1;
    for (std::size_t r = 0; r < imitations.size(); ++r)
      out.rivals[r].deviations =
          std::sqrt(std::pow(out.rivals[r].deviations, 2) + imitations[r].measured(pick));
    const Observation& o = next.observations[static_cast<std::size_t>(before + pick)];
    chosen.emplace_back(o.time, moveOf(measured, stand, views.whole, views.x, o));
  }
  out.moves = withOneWait(std::move(chosen));
}

/// With the artifact as a stand has it. @return no rivals where nothing can be proposed.
NextMeasurement proposed(const ResidualSpace& space, const Stand& stand, const Hypothesis& own,
                         const std::vector<Hypothesis>& rivals) {
  NextMeasurement out;
  const Session next = hypotheticalSession(space, stand);
  const Problem& problem = space.problem();
  if (next.observations.size() == problem.session().observations.size()) return out;
  try {
    const Problem whole(next, problem.model(), problem.datum());
    const Views views(space, whole);
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
      choose(views, stand, imitations, out);
  } catch (const InputError&) {
    out = {};  // the model cannot be evaluated at states that were not measured
  }
  return out;
}

/// By how much the rival is told apart that is told apart least, in standard deviations.
double leastOf(const NextMeasurement& next) {
  double least = next.rivals.empty() ? 0.0 : std::numeric_limits<double>::infinity();
  for (const NextMeasurement::Rival& r : next.rivals) least = std::min(least, r.same ? 0.0 : r.deviations);
  return least;
}

}  // namespace

NextMeasurement nextMeasurement(const ResidualSpace& space, const Hypothesis& own,
                                const std::vector<Hypothesis>& rivals) {
  constexpr double kEnough = 3.0;    // standard deviations: these moves will do
  constexpr double kMoreThan = 1.5;  // times what is told without it is worth turning a plate
  NextMeasurement best;
  if (rivals.empty()) return best;
  const std::vector<Stand> stands = standsOf(space);
  for (std::size_t s = 0; s < stands.size() && leastOf(best) < kEnough; ++s) {
    NextMeasurement next = proposed(space, stands[s], own, rivals);
    if (s > 0 && !(leastOf(next) > kMoreThan * leastOf(best))) continue;
    const Artifact& artifact = space.problem().session().artifact;
    if (!stands[s].placement.empty())
      next.change = "the artifact turned about the vertical (placement '" + stands[s].placement + "')";
    else if (stands[s].stylus >= 0)
      next.change = "stylus '" + artifact.styli[static_cast<std::size_t>(stands[s].stylus)].name + "'";
    best = std::move(next);
  }
  return best;
}

}  // namespace mm
