// What scatters in every session of balls, and is no cause: their centres, radii and form.
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <map>

#include "base/dense.h"
#include "base/range.h"
#include "base/units.h"
#include "diagnosis/diagnose.h"
#include "diagnosis/model_shapes.h"
#include "diagnosis/search.h"
#include "diagnosis/shape_maker.h"
#include "estimation/ball_columns.h"
#include "estimation/repeatability.h"

namespace mm {
namespace {

constexpr double kPrice = 3.0;       // nats: as for a drift term
constexpr double kDatumSize = 5.0;   // of the noise: a displacement of the whole artifact that costs nothing
constexpr double kDatumSeen = 0.01;  // of a displacement: less is left where the places are unknowns
constexpr double kSharedSeen = 0.1;  // of columns: less is left where a table or a zero of each is an unknown
constexpr double kAsACause = 4.6;  // nats: what an axis has for itself is met as often as one of some hundred
constexpr int kMostForm = 120;     // columns of form: each costs as much as an unknown
constexpr int kLowest = 2, kHighest = 6;
constexpr int kHarmonics = (kHighest + 1) * (kHighest + 1) - kLowest * kLowest;

/// Real spherical harmonics from degree 2 (lower ones are the radius and the centre) to 6 at a unit vector,
/// each with the standard deviation that it has where a ball's form is 1: amplitudes fall with the degree, as
/// on ground and lapped balls.
Eigen::Matrix<double, 1, kHarmonics> formAt(const Eigen::Vector3d& n) {
  const double polar = std::acos(std::clamp(n.z(), -1.0, 1.0)), azimuth = std::atan2(n.y(), n.x());
  double total = 0.0;
  for (int l = kLowest; l <= kHighest; ++l) total += 1.0 / (l * l);
  Eigen::Matrix<double, 1, kHarmonics> h;
  int at = 0;
  for (int l = kLowest; l <= kHighest; ++l) {
    const double share = std::sqrt(1.0 / (l * l) / total / (2 * l + 1));
    for (int m = -l; m <= l; ++m) {
      const auto order = static_cast<unsigned>(std::abs(m)), degree = static_cast<unsigned>(l);
      const double part = std::sph_legendre(degree, order, polar) *
                          (m < 0 ? std::sin(order * azimuth) : std::cos(order * azimuth));
      h[at++] = share * std::sqrt(4.0 * kPi) * (m == 0 ? 1.0 : std::sqrt(2.0)) * part;
    }
  }
  return h;
}

/// The few combinations of a ball's harmonics that its contacts can show.
/// @param all rows x harmonics of one ball. @return rows x at most `most`.
Eigen::MatrixXd shown(const Eigen::MatrixXd& all, int most) {
  constexpr double kNegligible = 0.01;  // of the largest variance
  const SymmetricEigen eigen(all.transpose() * all);
  int count = 0;
  const Eigen::VectorXd& values = eigen.values;  // ascending
  const auto n = static_cast<int>(values.size());
  while (count < std::min(most, n) && values[n - 1 - count] > kNegligible * values[n - 1]) ++count;
  return all * eigen.vectors.rightCols(count);
}

/// An artifact whose pose is stated as known lies beside it as a whole: a constant displacement. No cause of
/// the catalogue is one; without it, drift and what is larger than nothing everywhere (a sag, a bow about its
/// end) would have to carry it. @param unitOf of a row, by which it counts.
/// @return data rows x 3 workpiece axes; no columns where the pose is an unknown, or nothing was touched.
template <typename Unit>
Eigen::MatrixXd datumColumns(const ResidualSpace& space, const Unit& unitOf) {
  const Problem& problem = space.problem();
  Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(problem.rowCount(), 3);
  const ErrorLayout layout = problem.model().machine().layout();
  const Eigen::MatrixXd& g = space.linearisation().slotGradients();
  bool touched = false;
  for (const int row : space.used()) {
    const Observation& o = problem.session().observations[problem.rows()[row].observation];
    if (o.kind != ObservationKind::kContact || problem.session().poseFree(o.placement)) continue;
    touched = true;
    for (int k = 0; k < 3; ++k) columns(row, k) = unitOf(row) * g(row, layout.volume(k));
  }
  const RowMatrix whitened = space.whiten(columns);
  if (!touched || !(space.leftOf(whitened).minCoeff() > kDatumSeen * whitened.norm()))
    columns.resize(Eigen::NoChange, 0);
  return columns;
}

/// How large that displacement may be, of the noise: as large as it looks, where nothing else is asked yet. A
/// plate that was put down a tenth of a millimetre off is no less likely than one that is off by ten times
/// the noise, and what would have to carry it instead is drift.
double datumSize(const ResidualSpace& space, const RowMatrix& whitened) {
  Eigen::MatrixXd columns = whitened;
  space.project(columns);
  const Eigen::VectorXd shift = leastSquares(columns, space.target());
  return std::max(kDatumSize, shift.norm() / std::sqrt(static_cast<double>(shift.size())));
}

/// Rows of an axis that have one unknown error in common, a column each.
struct Shared {
  std::string name;
  std::vector<int> numbers;  // an observation: which error it has
  int fewest = 0;            // errors: fewer are met by what else is asked
  int again = 1;             // how often each must be met: once is told by the time as well
  bool readings = false;     // of instruments only
};

void addShared(Questions& q, int joint, const Shared& shared) {
  constexpr int kMost = 150;            // errors: more cost too much
  constexpr double kNoGradient = 1e-9;  // of a row by the error of a joint, m/m or m/rad: it lies across
  const ResidualSpace& space = *q.space;
  const Problem& problem = space.problem();
  const ErrorLayout layout = problem.model().machine().layout();
  const Eigen::MatrixXd& g = space.linearisation().slotGradients();
  std::map<int, int> columnOf;
  std::vector<int> rows;
  int visits = 0, at = -1;  // readings one after the other share all else, too
  for (const int row : space.used()) {
    const int o = problem.rows()[row].observation;
    const ObservationKind kind = problem.session().observations[o].kind;
    if (shared.readings && kind != ObservationKind::kDeviation && kind != ObservationKind::kPosition)
      continue;
    if (std::abs(g(row, layout.axis(joint))) < kNoGradient) continue;
    columnOf.emplace(shared.numbers[o], static_cast<int>(columnOf.size()));
    rows.push_back(row);
    if (shared.numbers[o] != at) ++visits;
    at = shared.numbers[o];
  }
  const auto errors = static_cast<int>(columnOf.size());
  // each so often, but that of a reversal; what one row has for itself is noise
  if (errors < shared.fewest || errors > kMost || visits < shared.again * errors - 1 ||
      static_cast<int>(rows.size()) < 2 * errors)
    return;
  // as large on average as what is read: of a rotary axis, by the lever
  double square = 0.0;
  for (const int row : rows) square += std::pow(g(row, layout.axis(joint)), 2);
  const double lever = std::sqrt(square / static_cast<double>(rows.size()));
  Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(problem.rowCount(), errors);
  for (const int row : rows)
    columns(row, columnOf.at(shared.numbers[problem.rows()[row].observation])) =
        (q.directionScale.empty() ? 1.0 : space.fitted().sigma[row]) * g(row, layout.axis(joint)) / lever;
  RowMatrix whitened = space.whiten(columns);
  if (!(space.leftOf(whitened).norm() > kSharedSeen * whitened.norm())) return;
  q.scatter.push_back({std::move(whitened), 0.0, kPrice, false, kAsACause});
  q.scatterNames.push_back(shared.name + problem.session().machine.joints()[joint].name);
}

/// The scale of a linear axis that wanders while it is read, as that of a screw whose temperature nobody
/// logs: a random walk, in parts of the session of as many readings each. What rises and falls with it by
/// chance is no cause.
void addWanderingScale(Questions& q, int joint) {
  constexpr int kMostParts = 30, kFewestParts = 6, kFewestReadings = 4;
  const ResidualSpace& space = *q.space;
  const Problem& problem = space.problem();
  const int slot = problem.model().machine().layout().axis(joint);
  const Eigen::MatrixXd& g = space.linearisation().slotGradients();
  std::vector<int> rows;
  Range travel;
  for (const int row : space.used()) {
    const int o = problem.rows()[row].observation;
    const ObservationKind kind = problem.session().observations[o].kind;
    if ((kind != ObservationKind::kDeviation && kind != ObservationKind::kPosition) || g(row, slot) == 0.0)
      continue;
    rows.push_back(row);
    travel.add(problem.state(o).position[joint]);
  }
  const auto count = static_cast<int>(rows.size()), parts = std::min(kMostParts, count / kFewestReadings);
  if (parts < kFewestParts || !(travel.size() > kStoodStill)) return;
  Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(problem.rowCount(), parts);
  for (int i = 0; i < count; ++i) {
    const int row = rows[static_cast<std::size_t>(i)];
    const double position = problem.state(problem.rows()[row].observation).position[joint];
    const double along = (position - travel.lower) / travel.size();
    columns.row(row)
        .head(1 + i * parts / count)
        .setConstant((q.directionScale.empty() ? 1.0 : space.fitted().sigma[row]) * g(row, slot) *
                     (2.0 * along - 1.0));
  }
  q.scatter.push_back({RowMatrix(space.whiten(columns)), 0.0, kPrice, false, kAsACause});
  q.scatterNames.push_back(kScaleOf + problem.session().machine.joints()[joint].name);
}

/// Each observation's number of two that are told together.
std::vector<int> numbersOf(const std::vector<std::pair<int, int>>& both) {
  std::map<std::pair<int, int>, int> known;
  std::vector<int> numbers;
  for (const auto& one : both)
    numbers.push_back(known.emplace(one, static_cast<int>(known.size())).first->second);
  return numbers;
}

/// What an axis has for itself each time, where that was met by several rows, which then are no independent
/// evidence of a cause: at each position (the graduation of a scale, a tooth of a rack), in each run or pass
/// (an instrument that was touched, a zero that was set anew), at each stop of a rotary axis (its clamp).
void addErrorsOfAxes(Questions& q) {
  // what is smooth is met by fewer numbers, and tells more: of few positions along a line a curve through all
  constexpr int kFewestPositions = 10, kFewestAngles = 5, kFewestRuns = 3;
  const Problem& problem = q.space->problem();
  const auto count = static_cast<int>(problem.session().observations.size());
  const std::vector<int> runs = runNumbers(problem);
  for (int joint = 0; joint < problem.session().machine.jointCount(); ++joint) {
    const bool linear = problem.session().machine.joints()[joint].kind == JointKind::kLinear;
    const std::vector<int> positions = positionNumbers(problem, joint);
    std::vector<std::pair<int, int>> passes;
    std::vector<int> stops;
    for (int o = 0; o < count; ++o) {
      passes.emplace_back(runs[o], problem.state(o).travel[joint] < 0.0);
      stops.push_back(o == 0 ? 0 : stops.back() + (positions[o] != positions[o - 1]));
    }
    addShared(q, joint, {kPositionsOf, positions, linear ? kFewestPositions : kFewestAngles, 2, linear});
    if (!linear) addShared(q, joint, {kStopsOf, stops, kFewestAngles, 1, false});
    addShared(q, joint, {kRunsOf, runs, kFewestRuns, 1, true});
    addShared(q, joint, {kPassesOf, numbersOf(passes), 2 * kFewestRuns, 1, true});
    if (linear) addWanderingScale(q, joint);
  }
}

}  // namespace

void addScatter(Questions& q) {
  for (ModelShape& s : shapesOfTheModel(*q.space)) {
    q.scatter.push_back(std::move(s.block));
    q.scatterNames.emplace_back();
  }
  addErrorsOfAxes(q);
  const ResidualSpace& space = *q.space;
  const Problem& problem = space.problem();
  const auto& features = problem.session().artifact.features;
  if (features.empty() || features.size() > kMostScattering) return;
  const ErrorLayout layout = problem.model().machine().layout();
  const Eigen::MatrixXd& g = space.linearisation().slotGradients();
  const int count = static_cast<int>(features.size());
  const auto unitOf = [&](int row) { return q.directionScale.empty() ? 1.0 : space.fitted().sigma[row]; };
  std::vector<std::vector<int>> contacts(static_cast<std::size_t>(count));  // of a ball: rows
  std::vector<std::vector<Eigen::Matrix<double, 1, kHarmonics>>> shapes(contacts.size());
  for (const int row : space.used()) {
    const Observation& o = problem.session().observations[problem.rows()[row].observation];
    if (o.kind != ObservationKind::kContact || features[o.feature].kind != FeatureKind::kBall) continue;
    const Eigen::Vector3d normal(g(row, layout.volume(0)), g(row, layout.volume(1)),
                                 g(row, layout.volume(2)));
    if (normal.norm() > 0.5) {
      contacts[o.feature].push_back(row);
      shapes[o.feature].push_back(unitOf(row) * formAt(normal.normalized()));
    }
  }
  Eigen::MatrixXd form(problem.rowCount(), 0);
  for (int f = 0; f < count; ++f) {
    const auto n = static_cast<int>(contacts[f].size());
    if (n == 0) continue;
    Eigen::MatrixXd all(n, kHarmonics);
    for (int i = 0; i < n; ++i) all.row(i) = shapes[f][i];
    const Eigen::MatrixXd some = shown(all, std::max(5, kMostForm / count));
    const auto first = form.cols();
    form.conservativeResize(Eigen::NoChange, first + some.cols());
    form.rightCols(some.cols()).setZero();
    for (int i = 0; i < n; ++i) form.row(contacts[f][i]).segment(first, some.cols()) = some.row(i);
  }
  const auto add = [&](const Eigen::MatrixXd& columns, const char* name) {
    q.scatter.push_back({RowMatrix(space.whiten(columns)), 0.0, kPrice, false});
    q.scatterNames.emplace_back(name);
  };
  BallColumns columns = ballColumns(space.linearisation(), space.used());
  for (auto& [of, name] : {std::pair{&columns.centres, "centres"}, std::pair{&columns.radii, "radii"}}) {
    for (const int row : space.used())
      if (of->cols() > 0) of->row(row) *= unitOf(row);
    if (of->cols() > 0) add(*of, name);
  }
  if (form.cols() > 0) add(form, "form");
  const Eigen::MatrixXd datum = datumColumns(space, unitOf);
  if (datum.cols() > 0) {
    const RowMatrix whitened = space.whiten(datum);
    q.scatter.push_back({whitened, datumSize(space, whitened), 0.0, true});
    q.scatterNames.emplace_back(kDatum);
  }
}

}  // namespace mm
