#include "estimation/identifiability.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "base/dense.h"
#include "base/text.h"
#include "estimation/thin_qr.h"
#include "estimation/whitened.h"

namespace mm {
namespace {

// Of a lost direction, a unit vector in units of the bounds:
constexpr double kHolds = 0.05;       // an unknown with this part in it may be held in its place
constexpr double kHoldsZero = 1e-6;   // a zero of the instrument has no bound to speak of: any part counts
constexpr double kNoPart = 1e-9;      // rounding: holding it would determine nothing
constexpr double kTold = 0.02;        // parts that the result keeps
constexpr double kSaid = 0.15;        // parts that are named to people
constexpr double kAlike = 0.1;        // two parts that differ by less are a sum or a difference
constexpr double kOfTheModel = 1e-3;  // square of the effects' parts: less is rounding of the artifact's

/// Effects whose parameters partly only choose the frame in which the machine's errors are told.
bool choosesFrame(const Problem& problem, int unknown) {
  const Unknown& u = problem.unknowns()[unknown];
  if (u.kind != UnknownKind::kEffect) return true;
  return problem.model().effects()[u.owner]->choosesFrame(u.component);
}

/// Held first, by a published convention.
bool zeroByConvention(const Problem& problem, int unknown) {
  const Unknown& u = problem.unknowns()[unknown];
  return u.kind == UnknownKind::kEffect && problem.model().effects()[u.owner]->zeroByConvention(u.component);
}

std::string inWordsOf(const Problem& problem, const LostDirection& lost) {
  std::vector<std::pair<int, double>> big;
  for (const auto& d : lost.direction)
    if (std::abs(d.second) > kSaid && problem.unknowns()[d.first].kind == UnknownKind::kEffect)
      big.push_back(d);
  if (big.empty())
    for (const auto& d : lost.direction)
      if (std::abs(d.second) > kSaid) big.push_back(d);
  std::sort(big.begin(), big.end(), [](auto& a, auto& b) { return a.first < b.first; });
  if (big.empty()) return "no single parameter is affected";
  if (big.size() == 1) return displayName(problem, big[0].first) + " has no influence on these data";
  std::vector<std::string> all;
  for (const auto& [p, part] : big) all.push_back(displayName(problem, p));
  const std::string names = enumerated(all);
  if (big.size() == 2 && std::abs(std::abs(big[0].second) - std::abs(big[1].second)) < kAlike)
    return names + ": only their " + (big[0].second * big[1].second < 0 ? "sum" : "difference") +
           " is determined";
  return names + ": one combination of them is not determined";
}

bool measured(const Problem& problem, ObservationKind kind) {
  const auto& all = problem.session().observations;
  return std::any_of(all.begin(), all.end(), [&](const Observation& o) { return o.kind == kind; });
}

/// What to measure so that the unknown that is held would be determined: by the kind of observation there is.
std::string wouldShowOf(const Problem& problem, int unknown, bool byConvention) {
  const Unknown& u = problem.unknowns()[unknown];
  if (u.kind == UnknownKind::kSetup)
    return "an instrument with an arbitrary zero shows differences only, so one value is a convention; an "
           "absolutely known position (columns reference_) would fix it";
  if (u.kind == UnknownKind::kEffect && !byConvention) return problem.model().effects()[u.owner]->shownBy();
  if (u.kind == UnknownKind::kEffect) {
    if (measured(problem, ObservationKind::kContact))
      return "a ball at a known position, or a reference direction, would separate them";
    if (measured(problem, ObservationKind::kPosition))
      return "a point at a known position in workpiece, or a reference direction, would separate them";
    return "an absolutely known position (columns reference_), or deviations of the other axes as well, "
           "would "
           "separate them";
  }
  const bool point =
      u.kind == UnknownKind::kFeature &&
      problem.session().artifact.features[static_cast<std::size_t>(u.owner)].kind == FeatureKind::kPoint;
  const auto& all = problem.session().observations;
  const auto touches = [&](const Observation& o) {
    return o.kind == ObservationKind::kContact && o.feature == u.owner;
  };
  if (point && std::none_of(all.begin(), all.end(), touches))
    return "lengths to tip positions that are not on one plane, and farther apart";
  if (point) return "the point reached from more directions, or with other readings of the joints";
  if (u.kind == UnknownKind::kPose && !measured(problem, ObservationKind::kContact))
    return "three or more points that are not on one line";
  return "contacts spread over more of the ball, or over more balls";
}

/// Which unknowns are held first, one a lost direction: the instrument's zeros, what a convention names, the
/// other parameters of the effects from the last to the first, the rest.
std::vector<int> orderOfHolding(const Problem& problem) {
  const auto& unknowns = problem.unknowns();
  const int count = problem.unknownCount();
  std::vector<int> order;
  for (int u = count - 1; u >= 0; --u)
    if (unknowns[u].kind == UnknownKind::kSetup) order.push_back(u);
  for (const bool named : {true, false})
    for (int u = count - 1; u >= 0; --u)
      if (unknowns[u].kind == UnknownKind::kEffect && zeroByConvention(problem, u) == named)
        order.push_back(u);
  for (int u = count - 1; u >= 0; --u)
    if (unknowns[u].kind != UnknownKind::kEffect && unknowns[u].kind != UnknownKind::kSetup)
      order.push_back(u);
  return order;
}

/// @param direction a unit vector of the unknowns, in units of the bounds. @param unknown held in its place.
LostDirection lostBy(const Problem& problem, int unknown, const Eigen::VectorXd& direction) {
  LostDirection lost;
  double ofEffects = 0.0;
  for (int k = 0; k < problem.unknownCount(); ++k) {
    if (std::abs(direction[k]) > kTold) lost.direction.emplace_back(k, direction[k]);
    if (problem.unknowns()[k].kind == UnknownKind::kEffect) ofEffects += direction[k] * direction[k];
  }
  lost.ofTheModel = ofEffects > kOfTheModel;
  lost.fixedUnknown = unknown;
  lost.byConvention = choosesFrame(problem, unknown);
  lost.inWords = inWordsOf(problem, lost);
  lost.wouldShow = wouldShowOf(problem, unknown, lost.byConvention);
  return lost;
}

/// Marks what is lost within one effect without a trace in the data, while the data determine the rest of
/// that effect: a parameter whose column is zero, or, where only angles are measured, parameters whose
/// columns cancel.
/// @param scaled the Jacobian, columns in units of the bounds. @param inverseSigma a data row, 0: left out.
void markNoInfluence(const Problem& problem, const Eigen::MatrixXd& scaled,
                     const Eigen::VectorXd& inverseSigma, Identifiability& found) {
  constexpr double kTrace = 1e-9, kOthers = 1e-6;  // of the columns' length; of the direction
  const auto& unknowns = problem.unknowns();
  bool angular = true;
  for (int i = 0; i < problem.rowCount(); ++i)
    angular &= problem.rows()[static_cast<std::size_t>(i)].angular || inverseSigma[i] == 0.0;
  const auto ofEffect = [&](int unknown, int effect) {
    return unknowns[unknown].kind == UnknownKind::kEffect && unknowns[unknown].owner == effect;
  };
  for (LostDirection& lost : found.lost) {
    if (!lost.ofTheModel || unknowns[lost.fixedUnknown].kind != UnknownKind::kEffect) continue;
    const int effect = unknowns[lost.fixedUnknown].owner;
    bool determined = false;
    for (int u = 0; u < problem.unknownCount(); ++u)
      determined |= ofEffect(u, effect) && found.fixed[u] == 0 && scaled.col(u).norm() > 0.0;
    if (!determined) continue;
    Eigen::VectorXd trace = Eigen::VectorXd::Zero(scaled.rows());
    double length = 0.0, others = 0.0;
    for (const auto& [u, component] : lost.direction) {
      trace += component * scaled.col(u);
      length += std::abs(component) * scaled.col(u).norm();
      if (!ofEffect(u, effect)) others += component * component;
    }
    const bool zero = scaled.col(lost.fixedUnknown).norm() == 0.0;
    lost.noInfluence = zero || (angular && others < kOthers && trace.norm() < kTrace * length &&
                                problem.model().effects()[static_cast<std::size_t>(effect)]->separable());
    if (lost.noInfluence && angular)
      lost.wouldShow = "contacts or positions (columns reference_) would show it: angles alone do not";
  }
}

/// What is held cannot be lost: its column is a measurement of itself alone.
void holdColumns(Eigen::MatrixXd& scaled, const std::vector<char>& held) {
  constexpr double kKnown = 1e3;
  const Eigen::Index data = scaled.rows(), count = scaled.cols();
  scaled.conservativeResize(data + count, count);
  scaled.bottomRows(count).setZero();
  for (Eigen::Index u = 0; u < count; ++u) {
    if (held[static_cast<std::size_t>(u)] == 0) continue;
    scaled.col(u).setZero();
    scaled(data + u, u) = kKnown;
  }
}

}  // namespace

std::string displayName(const Problem& problem, int unknown) {
  const Unknown& u = problem.unknowns()[unknown];
  if (u.kind != UnknownKind::kEffect) return u.name;
  int same = 0;
  for (const Unknown& other : problem.unknowns())
    same += other.kind == UnknownKind::kEffect && other.name == u.name;
  return same == 1 ? u.name : u.name + " of " + problem.model().effects()[u.owner]->spec().yaml();
}

bool Identifiability::incomplete() const {
  return std::any_of(lost.begin(), lost.end(), [](const LostDirection& l) { return l.lacking(); });
}

Identifiability identify(const Problem& problem, const Eigen::VectorXd& x,
                         const Eigen::VectorXd& inverseSigma, bool beforeFit, const std::vector<char>& held) {
  const int count = problem.unknownCount();
  const auto& unknowns = problem.unknowns();
  Identifiability result;
  result.fixed.assign(count, 0);
  result.parameters = problem.model().parameterCount();
  WhitenedSystem system(problem, x, inverseSigma, result.fixed);
  if (count == 0) return result;
  Eigen::VectorXd bound(count);
  for (int u = 0; u < count; ++u) bound[u] = unknowns[u].bound;
  // columns in units of the bounds: a singular value below one is a standard deviation above the bound
  Eigen::MatrixXd scaled = system.jacobian * bound.cwiseQuotient(system.scale).asDiagonal();
  if (!held.empty()) holdColumns(scaled, held);
  const RightSingular svd(scaled.rows() > count
                              ? thinQr(scaled, localBlocks(problem, scaled, system.free), false).rInOrder()
                              : scaled);
  std::vector<int> lostColumns;
  for (int i = 0; i < count; ++i) {
    const double s = i < svd.values.size() ? svd.values[i] : 0.0;
    if (!(s >= 1.0)) lostColumns.push_back(i);
  }
  const std::vector<int> order = orderOfHolding(problem);
  Eigen::MatrixXd rest = svd.vectors(Eigen::all, lostColumns);
  for (int u : order) {
    if (rest.cols() == 0) break;
    const Eigen::RowVectorXd row = rest.row(u);
    const double share = row.norm();
    const bool last = u == order.back();
    if (share < (unknowns[u].kind == UnknownKind::kSetup ? kHoldsZero : kHolds) && !last) continue;
    if (share < kNoPart) continue;
    if (beforeFit && unknowns[u].kind == UnknownKind::kEffect &&
        !problem.model().effects()[unknowns[u].owner]->startTells())
      continue;
    // the member of the remaining null space that u belongs to
    const LostDirection lost = lostBy(problem, u, (rest * row.transpose() / share).normalized());
    result.fixed[u] = 1;
    result.lost.push_back(lost);
    // remove u from the null space: what remains has no component along u
    const Eigen::VectorXd unit = row.transpose() / share;
    const Eigen::MatrixXd basis = Eigen::HouseholderQR<Eigen::MatrixXd>(unit).householderQ();
    rest = (rest * basis.rightCols(rest.cols() - 1)).eval();
  }
  markNoInfluence(problem, scaled, inverseSigma, result);
  int fixedParameters = 0;
  for (int u = 0; u < count; ++u)
    fixedParameters += result.fixed[u] && unknowns[u].kind == UnknownKind::kEffect;
  result.rank = result.parameters - fixedParameters;
  for (std::size_t u = 0; u < held.size(); ++u) result.fixed[u] |= held[u];
  return result;
}

}  // namespace mm
