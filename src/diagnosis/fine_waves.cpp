#include "diagnosis/fine_waves.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "base/dense.h"
#include "base/tiny.h"
#include "base/units.h"
#include "diagnosis/shape_maker.h"
#include "effects/linearity.h"

namespace mm {
namespace {

constexpr std::size_t kMostLikely = 12;  // of what is left, and of that without what is smooth
constexpr int kManyPlaces = 20;

/// What an error of the joint by one unit does to each row, and where the joint was and from where it came.
struct ErrorOfJoint {
  ErrorOfJoint(const ResidualSpace& space, const Effect& effect, const Nature::FineWaves& waves) {
    const double length = waves.lengths.front();
    const Eigen::MatrixXd both = linearColumns(effect, space.columns(effect, startsAt(effect, {length})));
    const Problem& problem = space.problem();
    position.resize(space.rows());
    travel.resize(space.rows());
    for (int i = 0; i < space.rows(); ++i) {
      const State& state = problem.state(problem.rows()[space.used()[i]].observation);
      position[i] = state.position[waves.joint];
      travel[i] = state.travel[waves.joint];
    }
    const Eigen::ArrayXd phase = 2.0 * kPi / length * position;
    factor = both.col(0).head(space.rows()).array() * phase.sin() +
             both.col(1).head(space.rows()).array() * phase.cos();
  }
  Eigen::ArrayXd position, travel, factor;
};

/// The part of the residuals' sum of squares that a wave takes.
double powerOf(const ErrorOfJoint& error, const Eigen::ArrayXd& target, double length) {
  const Eigen::ArrayXd phase = 2.0 * kPi / length * error.position;
  const Eigen::ArrayXd sine = error.factor * phase.sin(), cosine = error.factor * phase.cos();
  Eigen::Matrix2d products;
  products << sine.square().sum(), (sine * cosine).sum(), 0.0, cosine.square().sum();
  products(1, 0) = products(0, 1);
  const Eigen::Vector2d by((sine * target).sum(), (cosine * target).sum());
  if (!(products.determinant() > kTiny)) return 0.0;
  return by.dot(products.inverse() * by);
}

/// Without what a scale, a straightness or a sag and a backlash would take: beside these a wave may be the
/// smallest of what is left, and they have sidelobes everywhere.
Eigen::ArrayXd withoutWhatIsSmooth(const ErrorOfJoint& error, const Eigen::ArrayXd& target) {
  constexpr int kDegree = 5;
  const double low = error.position.minCoeff(), range = error.position.maxCoeff() - low;
  Eigen::MatrixXd smooth(target.size(), kDegree + 2);
  for (int k = 0; k <= kDegree; ++k)
    smooth.col(k) = error.factor * (2.0 * (error.position - low) / std::max(range, kTiny) - 1.0).pow(k);
  smooth.col(kDegree + 1) = error.factor * error.travel;
  return target - (smooth * leastSquares(smooth, target.matrix())).array();
}

/// Lengths of the highest peaks of the power.
std::set<double> highest(const ErrorOfJoint& error, const Eigen::ArrayXd& target,
                         const std::vector<double>& lengths) {
  std::vector<double> power;
  for (const double length : lengths) power.push_back(powerOf(error, target, length));
  std::vector<std::pair<double, double>> peaks;  // power, length
  for (std::size_t i = 0; i < power.size(); ++i)
    if ((i == 0 || power[i] >= power[i - 1]) && (i + 1 == power.size() || power[i] > power[i + 1]))
      peaks.emplace_back(power[i], lengths[i]);
  std::stable_sort(peaks.begin(), peaks.end(), [](auto& a, auto& b) { return a.first > b.first; });
  peaks.resize(std::min(peaks.size(), kMostLikely));
  std::set<double> of;
  for (const auto& [height, length] : peaks) of.insert(length);
  return of;
}

}  // namespace

LikelyWaves likelyWaves(const ResidualSpace& space, const Effect& effect) {
  LikelyWaves out;
  const Nature::FineWaves waves = effect.nature().fineWaves;
  if (waves.lengths.empty()) return out;
  const Domain& domain = space.problem().model().domain();
  const double range = domain.upper[waves.joint] - domain.lower[waves.joint];
  // Few places are met by many waves. Enough of them tell a screw of short lead, as far as their distances
  // do (Nyquist: aliases are not among the lengths): what two constants and a period explain of so many by
  // chance is paid for.
  const int places = distinctPositions(space.problem(), waves.joint);
  const double shortest = places >= kManyPlaces ? 0.0 : 2.0 * range / std::max(1, places);
  const ErrorOfJoint error(space, effect, waves);
  const Eigen::ArrayXd target = space.target().head(space.rows()).array();
  std::vector<double> lengths;
  for (const double length : waves.lengths) {
    if (length < shortest) break;
    lengths.push_back(length);
  }
  out.looked = static_cast<int>(lengths.size());
  std::set<double> likely = highest(error, target, lengths);
  likely.merge(highest(error, withoutWhatIsSmooth(error, target), lengths));
  out.lengths.assign(likely.begin(), likely.end());
  std::sort(out.lengths.begin(), out.lengths.end(), std::greater<double>());
  return out;
}

}  // namespace mm
