#include "diagnosis/evidence.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "base/cancel_scope.h"
#include "base/parallel.h"
#include "base/tiny.h"

namespace mm {
namespace {

constexpr double kNothingLeft = 1e-9;  // of a column of unit mean square: what the others leave is rounding
constexpr double kSomeNoise = 1e-12;   // share of the squares that no cause explains
constexpr double kLarge = 1e100;       // of a product: its square is still a number
constexpr double kUnused = 1e10;       // variance of a row that is held out

/// Sizes that are asked: from what nobody sees to a hundred times the noise, in steps of a quarter of e.
const std::vector<double>& sizes() {
  static const std::vector<double> all = [] {
    std::vector<double> s;
    for (double l = std::log(0.02); l < std::log(300.0); l += 0.25) s.push_back(std::exp(l));
    return s;
  }();
  return all;
}

Eigen::VectorXd withoutHeldOut(Eigen::VectorXd variance, const std::vector<char>* heldOut) {
  CancelScope::check();
  for (std::size_t i = 0; heldOut != nullptr && i < heldOut->size(); ++i)
    if ((*heldOut)[i]) variance[static_cast<Eigen::Index>(i)] = kUnused;
  return variance;
}

/// The size at which columns explain most.
/// @param products of the columns, @param target theirs with what is left: both beside what is given.
Gain bestOf(const Eigen::MatrixXd& products, const Eigen::VectorXd& target, const Evidence::Given& given) {
  Gain gain;
  const SymmetricEigen eigen(products);
  const Eigen::VectorXd values = eigen.values.cwiseMax(0.0);
  const Eigen::VectorXd z2 = (eigen.vectors.transpose() * target).cwiseAbs2();
  double most = 0.0;  // no size explains more than this
  for (int k = 0; k < z2.size(); ++k)
    if (values[k] > kNothingLeft) most += z2[k] / values[k];
  gain.value = 0.0;
  if (!(most > given.rest / given.freedoms)) return gain;
  const auto at = [&](double size) {
    double logs = 0.0, product = 1.0, explained = 0.0;
    const double s2 = size * size;
    for (int k = 0; k < z2.size(); ++k) {
      const double more = 1.0 + s2 * values[k];
      product *= more;
      if (product > kLarge) logs += std::log(product), product = 1.0;
      explained += s2 * z2[k] / more;
    }
    logs += std::log(product);
    const double share = std::min(explained / given.rest, 1.0 - kSomeNoise);
    return -0.5 * logs - 0.5 * given.freedoms * std::log1p(-share);
  };
  for (const double size : sizes()) {
    const double value = at(size);
    if (value > gain.value) gain.value = value, gain.size = size;
  }
  const double s2 = gain.size * gain.size;
  const Eigen::ArrayXd shrunk =
      s2 * (eigen.vectors.transpose() * target).array() / (1.0 + s2 * values.array());
  gain.coefficient = eigen.vectors.row(0).dot(shrunk.matrix());
  return gain;
}

}  // namespace

Evidence::Evidence(const NoiseRows& rows, const Groups& groups, const NoiseModel& noise,
                   const std::vector<RandomBlock>& blocks, const std::vector<double>& ratios,
                   const std::vector<char>* heldOut)
    : rows_(rows),
      groups_(groups),
      whitened_(rows, withoutHeldOut(noise.variance, heldOut), noise.drift, blocks, ratios),
      fixed_(fixedColumnsOf(rows, blocks, ratios)) {
  const auto held = heldOut == nullptr ? 0 : std::count(heldOut->begin(), heldOut->end(), char(1));
  freedoms_ = std::max(1.0, whitened_.freedoms() - static_cast<double>(held));
}

std::vector<WhitenedRows::Sized> Evidence::sizedOf(const std::vector<Member>& members) const {
  std::vector<WhitenedRows::Sized> sized;
  for (const Member& m : members) {
    auto known = prepared_.find(m.columns);
    if (known == prepared_.end()) known = prepared_.emplace(m.columns, whitened_.prepare(*m.columns)).first;
    sized.push_back({m.size, &known->second});
  }
  return sized;
}

Evidence::Given Evidence::given(const std::vector<Member>& members) const {
  CancelScope::check();
  Given g;
  g.members = sizedOf(members);
  g.joint = WhitenedRows::jointOf(g.members);
  g.freedoms = freedoms_;
  g.rest = std::max(kTiny, whitened_.rest() - g.joint.explained.squaredNorm());
  const double logDeterminant = whitened_.logDeterminant() + g.joint.factor.logDeterminant();
  g.logEvidence = -0.5 * logDeterminant - 0.5 * g.freedoms * std::log(g.rest / g.freedoms);
  return g;
}

Gain Evidence::gainOf(const Given& given, const RowMatrix& columns) const {
  const WhitenedRows::Columns asked = whitened_.prepare(columns);
  Eigen::MatrixXd products = WhitenedRows::productOf(asked, asked);
  Eigen::VectorXd target = asked.target;
  if (!given.members.empty()) {
    Eigen::MatrixXd absorbed(given.joint.explained.size(), columns.cols());
    Eigen::Index at = 0;
    for (const auto& [size, of] : given.members) {
      absorbed.middleRows(at, of->whitened.cols()) = size * WhitenedRows::productOf(*of, asked);
      at += of->whitened.cols();
    }
    given.joint.factor.solveLowerInPlace(absorbed);
    products -= absorbed.transpose() * absorbed;
    target -= absorbed.transpose() * given.joint.explained;
  }
  return bestOf(products, target, given);
}

Gain Evidence::gainOf(const Given& given, int group) const {
  Gain best;
  const Group& g = groups_.groups[group];
  for (std::size_t s = 0; s < g.shapes.size(); ++s) {
    const Shape& shape = g.shapes[s];
    Gain gain = gainOf(given, groups_.columns.middleCols(shape.first, shape.count));
    gain.group = group;
    gain.shape = static_cast<int>(s);
    gain.value -= shape.price + shape.priceOfSize(gain.coefficient);
    if (gain.value > best.value) best = gain;
  }
  return best;
}

std::vector<Gain> Evidence::gains(const Given& given) const {
  const std::size_t n = groups_.groups.size();
  std::vector<Gain> all(n);
  parallelFor(n, [&](std::size_t g) { all[g] = gainOf(given, static_cast<int>(g)); });
  std::stable_sort(all.begin(), all.end(), [](const Gain& a, const Gain& b) { return a.value > b.value; });
  return all;
}

Evidence::Fit Evidence::fit(const std::vector<Member>& members) const {
  const std::vector<WhitenedRows::Sized> sets = sizedOf(members);
  const WhitenedRows::Joint joint = WhitenedRows::jointOf(sets);
  const double left = std::max(0.0, whitened_.rest() - joint.explained.squaredNorm());
  WhitenedRows::Fit of = WhitenedRows::fitOf(sets, joint, left / freedoms_);
  Fit fit;
  fit.withoutDrift = fixed_ * whitened_.fixedBeside(sets, of.values);
  for (std::size_t j = 0; j < members.size(); ++j) fit.withoutDrift += *members[j].columns * of.values[j];
  fit.expected = fit.withoutDrift;
  fit.expected.head(rows_.rows()) +=
      whitened_.whitener().driftIn((rows_.target - fit.withoutDrift).head(rows_.rows()));
  fit.values = std::move(of.values);
  fit.covariance = std::move(of.covariance);
  return fit;
}

}  // namespace mm
