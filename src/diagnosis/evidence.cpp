#include "diagnosis/evidence.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "base/cancel_scope.h"
#include "base/dense.h"
#include "base/parallel.h"
#include "base/tiny.h"
#include "estimation/row_products.h"

namespace mm {
namespace {

constexpr double kNothingLeft = 1e-9;  // of a column of unit mean square: what the others leave is rounding
constexpr double kSomeNoise = 1e-12;   // share of the squares that no cause explains
constexpr double kLarge = 1e100;       // of a product: its square is still a number
constexpr double kUnused = 1e10;       // variance of a row that is held out
/// Columns that are whitened together: enough for the products to be worth their packing, few enough to keep
/// all cores busy. Part of the layout of the work, so that the bits do not depend on the number of threads.
constexpr std::size_t kColumns = 192;
static_assert(kColumns % PackedColumns::kTogether == 0, "parts share no tile");

/// Sizes that are asked: from what nobody sees to a hundred times the noise, in steps of a quarter of e.
const std::vector<double>& sizes() {
  static const std::vector<double> all = [] {
    std::vector<double> s;
    for (double l = std::log(0.02); l < std::log(300.0); l += 0.25) s.push_back(std::exp(l));
    return s;
  }();
  return all;
}

}  // namespace

std::shared_ptr<const Evidence::Fixed> Evidence::fixedOf(const NoiseRows& rows, NoiseModel noise,
                                                         const std::vector<RandomBlock>& blocks,
                                                         const std::vector<char>* heldOut) {
  CancelScope::check();
  auto out = std::make_shared<Fixed>();
  out->noise = std::move(noise);
  int held = 0;
  if (heldOut != nullptr)
    for (int i = 0; i < rows.rows(); ++i)
      if ((*heldOut)[i]) out->noise.variance[i] = kUnused, ++held;
  out->whitener = std::make_unique<TimeWhitener>(whitenerOf(rows, out->noise.variance, out->noise.drift));
  const int base = static_cast<int>(rows.base.cols());
  int fixed = base;
  for (const RandomBlock& b : blocks)
    if (b.ratio > 0.0) fixed += static_cast<int>(b.columns.cols());
  out->raw.resize(rows.length(), fixed);
  out->raw.leftCols(base) = rows.base;
  int at = base;
  for (const RandomBlock& b : blocks)
    if (b.ratio > 0.0) {
      out->raw.middleCols(at, b.columns.cols()) = b.ratio * b.columns;
      at += static_cast<int>(b.columns.cols());
    }
  out->columns = out->raw;
  out->whitener->whiten(out->columns);
  RowMatrix target = rows.target;
  out->whitener->whiten(target);
  out->target = target.col(0);
  Eigen::MatrixXd m = rowProducts(out->columns);
  for (int k = 0; k < fixed; ++k) m(k, k) += k < base ? kRidge : 1.0;
  out->factor = Cholesky(m);
  out->byTarget = out->factor.solveLower(out->columns.transpose() * out->target);
  out->rest = std::max(kTiny, out->target.squaredNorm() - out->byTarget.squaredNorm());
  out->logDeterminant = out->whitener->logDeterminant() + out->factor.logDeterminant();
  out->freedoms = std::max(1, rows.length() - base - held);
  return out;
}

Evidence::Evidence(const NoiseRows& rows, const Groups& groups, NoiseModel noise,
                   std::vector<RandomBlock> blocks, const std::vector<char>* heldOut)
    : rows_(rows), groups_(groups), fixed_(fixedOf(rows, std::move(noise), blocks, heldOut)) {
  const int all = static_cast<int>(groups.columns.cols());
  RowMatrix columns(groups.columns.rows(), all);
  byBase_.resize(fixed_->columns.cols(), all);
  groupTarget_.resize(all);
  products_.resize(groups.groups.size());
  parallelFor(partsOf(all, kColumns), [&](std::size_t number) {
    const Part at = partOf(all, kColumns, number);
    const int first = static_cast<int>(at.first), count = static_cast<int>(at.end - at.first);
    RowMatrix part = groups.columns.middleCols(first, count);
    fixed_->whitener->whiten(part);
    Eigen::MatrixXd by = rowProducts(fixed_->columns, part);
    fixed_->factor.solveLowerInPlace(by);
    groupTarget_.segment(first, count) =
        part.transpose() * fixed_->target - by.transpose() * fixed_->byTarget;
    byBase_.middleCols(first, count) = by;
    columns.middleCols(first, count) = part;
  });
  columns_ = PackedColumns(columns);
  parallelFor(groups.groups.size(), [&](std::size_t g) {
    for (const Shape& s : groups.groups[g].shapes) {
      const auto block = columns.middleCols(s.first, s.count);
      const auto by = byBase_.middleCols(s.first, s.count);
      products_[g].push_back(Eigen::MatrixXd(rowProducts(block)) - by.transpose() * by);
    }
  });
}

Evidence::Prepared Evidence::prepare(const RowMatrix& columns) const {
  Prepared p;
  p.columns = columns;
  fixed_->whitener->whiten(p.columns);
  p.byBase = rowProducts(fixed_->columns, p.columns);
  fixed_->factor.solveLowerInPlace(p.byBase);
  p.target = p.columns.transpose() * fixed_->target - p.byBase.transpose() * fixed_->byTarget;
  return p;
}

Evidence::Prepared& Evidence::prepared(const Member& member) const {
  const auto found = prepared_.find(member.id);
  if (found != prepared_.end()) return found->second;
  return prepared_.emplace(member.id, prepare(*member.columns)).first->second;
}

void Evidence::makeCross(Prepared& p, int first, int end) const {
  constexpr int kTile = PackedColumns::kTogether;
  const int all = static_cast<int>(byBase_.cols());
  if (p.there.empty()) {
    p.cross.resize(p.columns.cols(), all);
    p.there.assign(partsOf(static_cast<std::size_t>(all), kTile), 0);
  }
  const int lastTile = (end + kTile - 1) / kTile;
  for (int tile = first / kTile; tile < lastTile; ++tile) {
    const int begin = tile;
    while (tile < lastTile && !p.there[tile]) p.there[tile++] = 1;
    if (tile == begin) continue;
    const int from = begin * kTile, count = std::min(tile * kTile, all) - from;
    columns_.productsWith(p.columns, from, from + count, p.cross);
    p.cross.middleCols(from, count) -= p.byBase.transpose() * byBase_.middleCols(from, count);
  }
}

void Evidence::makeAllCross(const Given& given) const {
  const auto all = static_cast<std::size_t>(byBase_.cols());
  for (const auto& [size, p] : given.members) {
    makeCross(*p, 0, 0);
    parallelFor(partsOf(all, kColumns), [&, of = p](std::size_t number) {
      const Part at = partOf(all, kColumns, number);
      makeCross(*of, static_cast<int>(at.first), static_cast<int>(at.end));
    });
  }
}

Eigen::MatrixXd Evidence::productsOf(const Prepared& a, const Prepared& b) const {
  return Eigen::MatrixXd(rowProducts(a.columns, b.columns)) - a.byBase.transpose() * b.byBase;
}

Evidence::Joint Evidence::jointOf(const std::vector<Member>& members) const {
  Joint joint;
  for (const Member& m : members) joint.columns += static_cast<int>(m.columns->cols());
  Eigen::MatrixXd products(joint.columns, joint.columns);
  Eigen::VectorXd target(joint.columns);
  int at = 0;
  for (std::size_t i = 0; i < members.size(); ++i) {
    const Prepared& a = prepared(members[i]);
    const int n = static_cast<int>(a.columns.cols());
    target.segment(at, n) = members[i].size * a.target;
    int to = 0;
    for (std::size_t j = 0; j <= i; ++j) {
      const Prepared& b = prepared(members[j]);
      const int other = static_cast<int>(b.columns.cols());
      const Eigen::MatrixXd block = members[i].size * members[j].size * productsOf(a, b);
      products.block(at, to, n, other) = block;
      products.block(to, at, other, n) = block.transpose();
      to += other;
    }
    at += n;
  }
  products.diagonal().array() += 1.0;
  joint.factor = Cholesky(products);
  joint.explained = joint.factor.solveLower(target);
  return joint;
}

Evidence::Given Evidence::given(const std::vector<Member>& members) const {
  CancelScope::check();
  Given g;
  g.joint = jointOf(members);
  g.freedoms = fixed_->freedoms;
  for (const Member& m : members) g.members.emplace_back(m.size, &prepared(m));
  g.rest = std::max(kTiny, fixed_->rest - g.joint.explained.squaredNorm());
  const double logDeterminant = fixed_->logDeterminant + g.joint.factor.logDeterminant();
  g.logEvidence = -0.5 * logDeterminant - 0.5 * g.freedoms * std::log(g.rest / g.freedoms);
  return g;
}

Gain Evidence::best(const Eigen::MatrixXd& products, const Eigen::VectorXd& target,
                    const Given& given) const {
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

Gain Evidence::gainOf(const Given& given, int group, std::vector<double>* ofShapes) const {
  Gain best;
  const Group& g = groups_.groups[group];
  if (ofShapes != nullptr) ofShapes->clear();
  for (std::size_t s = 0; s < g.shapes.size(); ++s) {
    const Shape& shape = g.shapes[s];
    Eigen::MatrixXd products = products_[group][s];
    Eigen::VectorXd target = groupTarget_.segment(shape.first, shape.count);
    if (given.joint.columns > 0) {
      Eigen::MatrixXd absorbed(given.joint.columns, shape.count);
      int at = 0;
      for (const auto& [size, p] : given.members) {
        makeCross(*p, shape.first, shape.first + shape.count);
        absorbed.middleRows(at, p->cross.rows()) = size * p->cross.middleCols(shape.first, shape.count);
        at += static_cast<int>(p->cross.rows());
      }
      given.joint.factor.solveLowerInPlace(absorbed);
      products.noalias() -= absorbed.transpose() * absorbed;
      target.noalias() -= absorbed.transpose() * given.joint.explained;
    }
    Gain gain = this->best(products, target, given);
    gain.group = group;
    gain.shape = static_cast<int>(s);
    gain.value -= shape.price + shape.priceOfSize(gain.coefficient);
    if (ofShapes != nullptr) ofShapes->push_back(gain.value);
    if (gain.value > best.value) best = gain;
  }
  return best;
}

Gain Evidence::gainOf(const Given& given, const std::vector<Member>& members,
                      const RowMatrix& columns) const {
  const Prepared p = prepare(columns);
  Eigen::MatrixXd products = productsOf(p, p);
  Eigen::VectorXd target = p.target;
  if (!members.empty()) {
    const Joint joint = jointOf(members);
    Eigen::MatrixXd absorbed(joint.columns, columns.cols());
    int at = 0;
    for (const Member& m : members) {
      absorbed.middleRows(at, m.columns->cols()) = m.size * productsOf(prepared(m), p);
      at += static_cast<int>(m.columns->cols());
    }
    joint.factor.solveLowerInPlace(absorbed);
    products -= absorbed.transpose() * absorbed;
    target -= absorbed.transpose() * joint.explained;
  }
  return best(products, target, given);
}

std::vector<Gain> Evidence::gains(const Given& given) const {
  const std::size_t n = groups_.groups.size();
  std::vector<Gain> all(n);
  makeAllCross(given);
  parallelFor(n, [&](std::size_t g) { all[g] = gainOf(given, static_cast<int>(g)); });
  std::stable_sort(all.begin(), all.end(), [](const Gain& a, const Gain& b) { return a.value > b.value; });
  return all;
}

Evidence::Fit Evidence::fit(const std::vector<Member>& members) const {
  const Joint joint = jointOf(members);
  const Eigen::VectorXd values = joint.factor.solveUpper(joint.explained);
  Eigen::VectorXd byFixed = fixed_->byTarget;
  Fit fit;
  fit.withoutDrift = Eigen::VectorXd::Zero(rows_.length());
  int at = 0;
  for (const Member& m : members) {
    const int k = static_cast<int>(m.columns->cols());
    fit.values.emplace_back(m.size * values.segment(at, k));
    byFixed -= prepared(m).byBase * fit.values.back();
    fit.withoutDrift += *m.columns * fit.values.back();
    at += k;
  }
  fit.withoutDrift += fixed_->raw * fixed_->factor.solveUpper(byFixed);
  fit.expected = fit.withoutDrift;
  const Eigen::VectorXd left = rows_.target - fit.withoutDrift;
  fit.expected.head(rows_.rows()) += fixed_->whitener->driftIn(left.head(rows_.rows()));
  const double variance = std::max(0.0, fixed_->rest - joint.explained.squaredNorm()) / fixed_->freedoms;
  const Eigen::MatrixXd inverse = joint.factor.inverse();
  at = 0;
  for (const Member& m : members) {
    const int k = static_cast<int>(m.columns->cols());
    fit.covariance.push_back(variance * m.size * m.size * inverse.block(at, at, k, k));
    at += k;
  }
  return fit;
}

}  // namespace mm
