#include "estimation/robust.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>

#include "base/distributions.h"
#include "base/median.h"
#include "base/range.h"
#include "estimation/thin_qr.h"
#include "estimation/whitened.h"

namespace mm {
namespace {

constexpr double kChance = 1e-9;   // of a residual of normal noise beyond the limit, both sides
constexpr double kSmallest = 9.0;  // standard deviations: a limit that a long session's noise stays within
constexpr int kFewestRows = 20;    // rows of a kind: fewer do not say what their bulk is
constexpr double kApart = 6.0;     // standard deviations between an outlier and the median of its neighbours
constexpr int kMostApart = 5;      // one row in so many: more that stand apart are structure
constexpr std::size_t kNeighbours = 7;
constexpr double kRounding = 1e-11;  // of a column's own length
// How far apart rows are in a view: opposite approaches are four travels away, other features ten, and a
// direction of travel weighs less where the approach says much the same.
constexpr double kByApproach = 2.0, kByTravel = 0.3, kByFeature = 10.0;

/// Rows that can be compared: the same component of the same kind of observation.
std::map<std::pair<ObservationKind, int>, std::vector<int>> comparableRows(const Problem& problem) {
  std::map<std::pair<ObservationKind, int>, std::vector<int>> groups;
  for (int i = 0; i < problem.rowCount(); ++i) {
    const ResidualRow& row = problem.rows()[i];
    groups[{problem.session().observations[row.observation].kind, row.component}].push_back(i);
  }
  return groups;
}

/// A view of the inputs in which close rows should have close residuals.
struct View {
  std::vector<double> coordinates;  // rows x width
  int width = 0;
};

View timeView(const Problem& problem, const std::vector<int>& rows) {
  View v;
  v.width = 1;
  for (int i : rows) v.coordinates.push_back(problem.rows()[i].observation);
  return v;
}

View stateView(const Problem& problem, const std::vector<int>& rows, bool approach) {
  View v;
  const int joints = problem.model().machine().jointCount();
  v.width = (approach ? 4 : 0) + 2 * joints;
  std::vector<Range> range(joints);
  for (int i : rows)
    for (int j = 0; j < joints; ++j) range[j].add(problem.state(problem.rows()[i].observation).position[j]);
  for (int i : rows) {
    const State& s = problem.state(problem.rows()[i].observation);
    if (approach)
      for (int k = 0; k < 3; ++k) v.coordinates.push_back(kByApproach * s.approach[k]);
    for (int j = 0; j < joints; ++j)
      v.coordinates.push_back(range[j].size() > 0.0 ? (s.position[j] - range[j].lower) / range[j].size()
                                                    : 0.0);
    for (int j = 0; j < joints; ++j)
      v.coordinates.push_back(approach ? kByTravel * s.travel[j] : s.travel[j]);
    if (approach) v.coordinates.push_back(kByFeature * s.feature);
  }
  return v;
}

/// True for each row of `rows` whose residual is farther than `limit` from the median of its nearest
/// neighbours.
void standsApart(const View& view, const std::vector<double>& r, const std::vector<char>& large, double limit,
                 std::vector<char>& apart) {
  const std::size_t n = r.size();
  std::vector<std::pair<double, std::size_t>> distance;
  for (std::size_t i = 0; i < n; ++i) {
    if (!large[i] || !apart[i]) continue;
    distance.clear();
    for (std::size_t j = 0; j < n; ++j) {
      if (j == i) continue;
      double d = 0.0;
      for (int k = 0; k < view.width; ++k) {
        const double e = view.coordinates[i * view.width + k] - view.coordinates[j * view.width + k];
        d += e * e;
      }
      distance.emplace_back(d, j);
    }
    const std::size_t k = std::min(kNeighbours, distance.size());
    std::partial_sort(distance.begin(), distance.begin() + static_cast<long>(k), distance.end());
    std::vector<double> near;
    for (std::size_t j = 0; j < k; ++j) near.push_back(r[distance[j].second]);
    if (std::abs(r[i] - medianOf(near)) < limit) apart[i] = 0;
  }
}

/// Variance that the fit gives to the value of a row, in units of the residuals' variance. An unknown that
/// the others leave nothing of has no part in it. @param row of the Jacobian's columns.
double leverageOf(const ThinQr& qr, const Eigen::RowVectorXd& row) {
  Eigen::VectorXd y = Eigen::VectorXd::Zero(row.size());
  for (Eigen::Index k = 0; k < row.size(); ++k) {
    if (!(std::abs(qr.r(k, k)) > kRounding * qr.r.col(k).head(k + 1).norm())) continue;
    y[k] = (row[qr.order[static_cast<std::size_t>(k)]] - qr.r.col(k).head(k).dot(y.head(k))) / qr.r(k, k);
  }
  return y.squaredNorm();
}

}  // namespace

double medianOf(std::vector<double> values) { return values.empty() ? 0.0 : median(values); }

double robustSigma(std::vector<double> values) {
  // the median of the absolute values of normal noise is its quantile of 75 %
  static const double kOfNormal = 1.0 / normalQuantile(0.75);
  for (double& v : values) v = std::abs(v);
  return kOfNormal * medianOf(std::move(values));
}

double outlyingLimit(int degreesOfFreedom) {
  return std::max(kSmallest, studentLimit(0.5 * kChance, std::max(1, degreesOfFreedom)));
}

Eigen::VectorXd resolutionSigma(const Problem& problem) {
  constexpr double kSameReading = 1e-9;  // of the largest: what writing in other units changes
  static const double kOfStep = 1.0 / std::sqrt(12.0);
  std::map<int, std::vector<int>> rowsOf;  // of a joint's deviations
  for (int i = 0; i < problem.rowCount(); ++i) {
    const ResidualRow& row = problem.rows()[i];
    if (problem.session().observations[row.observation].kind == ObservationKind::kDeviation)
      rowsOf[row.component].push_back(i);
  }
  Eigen::VectorXd sigma = Eigen::VectorXd::Zero(problem.rowCount());
  for (const auto& [component, rows] : rowsOf) {
    std::vector<double> values;
    for (const int i : rows)
      values.push_back(problem.session().observations[problem.rows()[i].observation].deviation[component]);
    std::sort(values.begin(), values.end());
    const double same = kSameReading * std::max(std::abs(values.front()), std::abs(values.back()));
    double step = std::numeric_limits<double>::infinity();
    for (std::size_t i = 1; i < values.size(); ++i)
      if (values[i] - values[i - 1] > same) step = std::min(step, values[i] - values[i - 1]);
    if (!std::isfinite(step)) continue;
    for (const int i : rows) sigma[i] = kOfStep * step;
  }
  return sigma;
}

Eigen::VectorXd outlierWeights(const Problem& problem, const Eigen::VectorXd& residuals,
                               const Eigen::VectorXd& rowSigma, int freeUnknowns) {
  const Eigen::VectorXd whitened = residuals.cwiseQuotient(rowSigma);
  const Eigen::VectorXd resolution = resolutionSigma(problem).cwiseQuotient(rowSigma);
  Eigen::VectorXd weight = Eigen::VectorXd::Ones(problem.rowCount());
  std::vector<char> outlying(problem.session().observations.size(), 0);
  for (const auto& [of, rows] : comparableRows(problem)) {
    const int n = static_cast<int>(rows.size());
    if (n < kFewestRows || n < 2 * freeUnknowns) continue;
    std::vector<double> r;
    double least = 0.0;
    for (int i : rows) r.push_back(whitened[i]), least = std::max(least, resolution[i]);
    const double sigma =
        std::max(least, robustSigma(r) * std::sqrt(static_cast<double>(n) / std::max(1, n - freeUnknowns)));
    if (!(sigma > 0.0)) continue;
    std::vector<char> large(rows.size(), 0);
    bool any = false;
    const double limit = outlyingLimit(n - freeUnknowns);
    for (std::size_t i = 0; i < rows.size(); ++i) any |= (large[i] = std::abs(r[i]) > limit * sigma) != 0;
    if (!any) continue;
    std::vector<char> apart = large;
    standsApart(timeView(problem, rows), r, large, kApart * sigma, apart);
    standsApart(stateView(problem, rows, false), r, large, kApart * sigma, apart);
    standsApart(stateView(problem, rows, true), r, large, kApart * sigma, apart);
    int count = static_cast<int>(std::count(apart.begin(), apart.end(), 1));
    if (kMostApart * count > n) continue;
    for (std::size_t i = 0; i < rows.size(); ++i)
      if (apart[i]) outlying[problem.rows()[rows[i]].observation] = 1;
  }
  for (int i = 0; i < problem.rowCount(); ++i)
    if (outlying[problem.rows()[i].observation]) weight[i] = 0.0;
  return weight;
}

Eigen::VectorXd reinstated(const Problem& problem, const Eigen::VectorXd& x, const Eigen::VectorXd& residuals,
                           const Eigen::VectorXd& sigma, const Eigen::VectorXd& weight,
                           const std::vector<char>& fixed) {
  Eigen::VectorXd result = weight;
  std::vector<int> out;
  for (int i = 0; i < weight.size(); ++i)
    if (weight[i] == 0.0 && problem.uses(problem.rows()[i].observation)) out.push_back(i);
  if (out.empty()) return result;
  const Linearisation at = linearise(problem, x);
  const WhitenedSystem system(at, weight.cwiseSqrt().cwiseQuotient(sigma), fixed);
  Eigen::VectorXd only = Eigen::VectorXd::Zero(weight.size());
  for (int i : out) only[i] = 1.0 / sigma[i];
  const WhitenedSystem left(at, only, fixed);
  const int columns = static_cast<int>(system.free.size()), rows = static_cast<int>(system.jacobian.rows());
  const int used = static_cast<int>((weight.array() > 0.0).count());
  if (columns == 0 || rows < columns || used <= columns) return result;
  const ThinQr qr = thinQr(system.jacobian, localBlocks(problem, system.jacobian, system.free), false);
  const double limit = outlyingLimit(used - columns);
  const double spread = system.residuals.squaredNorm() / (used - columns);
  for (int i : out) {
    const double expected = spread * (1.0 + leverageOf(qr, left.jacobian.row(i)));
    const double size = residuals[i] / sigma[i];
    if (!(size * size > limit * limit * expected)) result[i] = 1.0;
  }
  for (int i : out)  // an observation is in or out with all its rows
    for (int j = problem.firstRow(problem.rows()[i].observation);
         j < problem.firstRow(problem.rows()[i].observation + 1); ++j)
      if (result[j] == 0.0) result[i] = 0.0;
  return result;
}

}  // namespace mm
