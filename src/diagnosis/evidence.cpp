#include "diagnosis/evidence.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "machine/cancel_scope.h"
#include "machine/two_threads.h"

namespace mm {
namespace {

constexpr double kRidge = 1e-9;   // as in the fit of the noise
constexpr double kUnused = 1e10;  // variance of a row that is held out

/// Sizes that are asked: from what nobody sees to a hundred times the noise, in steps of a quarter of e.
const std::vector<double>& sizes() {
  static const std::vector<double> all = [] {
    std::vector<double> s;
    for (double l = std::log(0.02); l < std::log(300.0); l += 0.25) s.push_back(std::exp(l));
    return s;
  }();
  return all;
}

/// a' b of many rows: few columns of a by axpy along the rows of b, which need no packing.
template <class A, class B>
RowMatrix crossProducts(const A& a, const B& b) {
  constexpr int kFew = 24;
  if (a.cols() > kFew) return a.transpose() * b;
  RowMatrix out = RowMatrix::Zero(a.cols(), b.cols());
  for (Eigen::Index i = 0; i < a.rows(); ++i)
    for (Eigen::Index k = 0; k < a.cols(); ++k) out.row(k).noalias() += a(i, k) * b.row(i);
  return out;
}

}  // namespace

Evidence::Evidence(const NoiseRows& rows, const Groups& groups, NoiseModel noise,
                   std::vector<RandomBlock> blocks, const std::vector<char>* heldOut)
    : rows_(rows), groups_(groups), noise_(std::move(noise)) {
  CancelScope::check();
  int held = 0;
  if (heldOut != nullptr)
    for (int i = 0; i < rows.rows(); ++i)
      if ((*heldOut)[i]) noise_.variance[i] = kUnused, ++held;
  whitener_ = std::make_unique<TimeWhitener>(rows.time, rows.factors, noise_.variance, noise_.drift);
  const int base = static_cast<int>(rows.base.cols());
  int fixed = base;
  for (const RandomBlock& b : blocks)
    if (b.ratio > 0.0) fixed += static_cast<int>(b.columns.cols());
  fixedRaw_.resize(rows.length(), fixed);
  fixedRaw_.leftCols(base) = rows.base;
  int at = base;
  for (const RandomBlock& b : blocks)
    if (b.ratio > 0.0) {
      fixedRaw_.middleCols(at, b.columns.cols()) = b.ratio * b.columns;
      at += static_cast<int>(b.columns.cols());
    }
  fixed_ = fixedRaw_;
  RowMatrix target = rows.target;
  inTwo([&](std::size_t half) {
    if (half == 0) {
      whitener_->whiten(fixed_);
      whitener_->whiten(target);
    } else {
      columns_ = groups.columns;
      whitener_->whiten(columns_);
    }
  });
  target_ = target.col(0);
  Eigen::MatrixXd m = crossProducts(fixed_, fixed_);
  for (int k = 0; k < fixed; ++k) m(k, k) += k < base ? kRidge : 1.0;
  const Eigen::LLT<Eigen::MatrixXd> llt(m);
  factor_ = llt.matrixL();
  fixedTarget_ = factor_.triangularView<Eigen::Lower>().solve(fixed_.transpose() * target_);
  rest_ = std::max(1e-300, target_.squaredNorm() - fixedTarget_.squaredNorm());
  logDeterminant_ = whitener_->logDeterminant() + 2.0 * factor_.diagonal().array().log().sum();
  freedoms_ = std::max(1, rows.length() - base - held);

  const int all = static_cast<int>(columns_.cols());
  byBase_.resize(fixed, all);
  groupTarget_.resize(all);
  products_.resize(groups.groups.size());
  const int middle = all / 2;
  inTwo([&](std::size_t half) {
    const int first = half == 0 ? 0 : middle, count = half == 0 ? middle : all - middle;
    if (count > 0) {
      const auto part = columns_.middleCols(first, count);
      Eigen::MatrixXd by = crossProducts(fixed_, part);
      factor_.triangularView<Eigen::Lower>().solveInPlace(by);
      groupTarget_.segment(first, count) = part.transpose() * target_ - by.transpose() * fixedTarget_;
      byBase_.middleCols(first, count) = by;
    }
  });
  inTwo([&](std::size_t half) {
    for (std::size_t g = half; g < groups.groups.size(); g += 2)
      for (const Shape& s : groups.groups[g].shapes) {
        const auto block = columns_.middleCols(s.first, s.count);
        const auto by = byBase_.middleCols(s.first, s.count);
        products_[g].push_back(Eigen::MatrixXd(crossProducts(block, block)) - by.transpose() * by);
      }
  });
}

Evidence::Prepared Evidence::prepare(const RowMatrix& columns, bool cross) const {
  Prepared p;
  p.columns = columns;
  whitener_->whiten(p.columns);
  p.byBase = factor_.triangularView<Eigen::Lower>().solve(fixed_.transpose() * p.columns);
  p.target = p.columns.transpose() * target_ - p.byBase.transpose() * fixedTarget_;
  if (cross) p.cross = Eigen::MatrixXd(crossProducts(p.columns, columns_)) - p.byBase.transpose() * byBase_;
  return p;
}

const Evidence::Prepared& Evidence::prepared(const Member& member) const {
  const auto found = prepared_.find(member.id);
  if (found != prepared_.end()) return found->second;
  return prepared_.emplace(member.id, prepare(*member.columns, true)).first->second;
}

Evidence::Given Evidence::given(const std::vector<Member>& members) const {
  CancelScope::check();
  Given g;
  g.freedoms = freedoms_;
  int k = 0;
  for (const Member& m : members) k += static_cast<int>(m.columns->cols());
  Eigen::MatrixXd products(k, k), cross(k, columns_.cols());
  Eigen::VectorXd target(k);
  int at = 0;
  for (std::size_t i = 0; i < members.size(); ++i) {
    const Prepared& a = prepared(members[i]);
    const int n = static_cast<int>(a.columns.cols());
    cross.middleRows(at, n) = members[i].size * a.cross;
    target.segment(at, n) = members[i].size * a.target;
    int to = 0;
    for (std::size_t j = 0; j <= i; ++j) {
      const Prepared& b = prepared(members[j]);
      const int other = static_cast<int>(b.columns.cols());
      const Eigen::MatrixXd block = members[i].size * members[j].size *
                                    (crossProducts(a.columns, b.columns) - a.byBase.transpose() * b.byBase);
      products.block(at, to, n, other) = block;
      products.block(to, at, other, n) = block.transpose();
      to += other;
    }
    at += n;
  }
  products.diagonal().array() += 1.0;
  const Eigen::LLT<Eigen::MatrixXd> llt(products);
  g.explained = llt.matrixL().solve(target);
  g.absorbed = llt.matrixL().solve(cross);
  g.rest = std::max(1e-300, rest_ - g.explained.squaredNorm());
  double logDeterminant = logDeterminant_;
  for (int i = 0; i < k; ++i) logDeterminant += 2.0 * std::log(llt.matrixLLT()(i, i));
  g.logEvidence = -0.5 * logDeterminant - 0.5 * g.freedoms * std::log(g.rest / g.freedoms);
  return g;
}

Gain Evidence::best(const Eigen::MatrixXd& products, const Eigen::VectorXd& target,
                    const Given& given) const {
  Gain gain;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(products);
  const Eigen::VectorXd values = eigen.eigenvalues().cwiseMax(0.0);
  const Eigen::VectorXd z2 = (eigen.eigenvectors().transpose() * target).cwiseAbs2();
  double most = 0.0;  // no size explains more than this
  for (int k = 0; k < z2.size(); ++k)
    if (values[k] > 1e-9) most += z2[k] / values[k];
  gain.value = 0.0;
  if (!(most > given.rest / given.freedoms)) return gain;
  const auto at = [&](double size) {
    double logs = 0.0, explained = 0.0;
    const double s2 = size * size;
    for (int k = 0; k < z2.size(); ++k) {
      const double more = 1.0 + s2 * values[k];
      logs += std::log(more);
      explained += s2 * z2[k] / more;
    }
    const double share = std::min(explained / given.rest, 1.0 - 1e-12);
    return -0.5 * logs - 0.5 * given.freedoms * std::log1p(-share);
  };
  for (const double size : sizes()) {
    const double value = at(size);
    if (value > gain.value) gain.value = value, gain.size = size;
  }
  return gain;
}

Gain Evidence::gainOf(const Given& given, int group) const {
  Gain best;
  const Group& g = groups_.groups[group];
  const double price = std::log(static_cast<double>(g.shapes.size()));
  for (std::size_t s = 0; s < g.shapes.size(); ++s) {
    const Shape& shape = g.shapes[s];
    Eigen::MatrixXd products = products_[group][s];
    Eigen::VectorXd target = groupTarget_.segment(shape.first, shape.count);
    if (given.absorbed.rows() > 0) {
      const auto absorbed = given.absorbed.middleCols(shape.first, shape.count);
      products.noalias() -= absorbed.transpose() * absorbed;
      target.noalias() -= absorbed.transpose() * given.explained;
    }
    Gain gain = this->best(products, target, given);
    gain.group = group;
    gain.shape = static_cast<int>(s);
    gain.value -= price;
    if (gain.value > best.value) best = gain;
  }
  return best;
}

Gain Evidence::gainOf(const Given& given, const std::vector<Member>& members,
                      const RowMatrix& columns) const {
  const Prepared p = prepare(columns, false);
  Eigen::MatrixXd products = crossProducts(p.columns, p.columns) - p.byBase.transpose() * p.byBase;
  Eigen::VectorXd target = p.target;
  if (!members.empty()) {
    int k = 0;
    for (const Member& m : members) k += static_cast<int>(m.columns->cols());
    Eigen::MatrixXd own(k, k), cross(k, columns.cols());
    int at = 0;
    for (std::size_t i = 0; i < members.size(); ++i) {
      const Prepared& a = prepared(members[i]);
      const int n = static_cast<int>(a.columns.cols());
      cross.middleRows(at, n) =
          members[i].size * (crossProducts(a.columns, p.columns) - a.byBase.transpose() * p.byBase);
      int to = 0;
      for (std::size_t j = 0; j <= i; ++j) {
        const Prepared& b = prepared(members[j]);
        const int other = static_cast<int>(b.columns.cols());
        own.block(at, to, n, other) = members[i].size * members[j].size *
                                      (crossProducts(a.columns, b.columns) - a.byBase.transpose() * b.byBase);
        own.block(to, at, other, n) = own.block(at, to, n, other).transpose().eval();
        to += other;
      }
      at += n;
    }
    own.diagonal().array() += 1.0;
    const Eigen::LLT<Eigen::MatrixXd> llt(own);
    const Eigen::MatrixXd absorbed = llt.matrixL().solve(cross);
    products -= absorbed.transpose() * absorbed;
    target -= absorbed.transpose() * given.explained;
  }
  return best(products, target, given);
}

std::vector<Gain> Evidence::gains(const Given& given) const {
  const std::size_t n = groups_.groups.size();
  std::vector<Gain> all(n);
  inTwo([&](std::size_t half) {
    for (std::size_t g = half; g < n; g += 2) all[g] = gainOf(given, static_cast<int>(g));
  });
  std::stable_sort(all.begin(), all.end(), [](const Gain& a, const Gain& b) { return a.value > b.value; });
  return all;
}

Evidence::Fit Evidence::fit(const std::vector<Member>& members) const {
  const int fixed = static_cast<int>(fixed_.cols()), base = static_cast<int>(rows_.base.cols());
  int columns = fixed;
  for (const Member& m : members) columns += static_cast<int>(m.columns->cols());
  RowMatrix raw(rows_.length(), columns);
  raw.leftCols(fixed) = fixedRaw_;
  int at = fixed;
  for (const Member& m : members) {
    raw.middleCols(at, m.columns->cols()) = m.size * *m.columns;
    at += static_cast<int>(m.columns->cols());
  }
  RowMatrix whitened = raw;
  whitener_->whiten(whitened);
  Eigen::MatrixXd products = whitened.transpose() * whitened;
  for (int k = 0; k < columns; ++k) products(k, k) += k < base ? kRidge : 1.0;
  const Eigen::LLT<Eigen::MatrixXd> llt(products);
  const Eigen::VectorXd values = llt.solve(whitened.transpose() * target_);
  const Eigen::MatrixXd inverse = llt.solve(Eigen::MatrixXd::Identity(columns, columns));
  Fit fit;
  fit.withoutDrift = raw * values;
  fit.expected = fit.withoutDrift;
  const Eigen::VectorXd left = rows_.target - fit.withoutDrift;
  fit.expected.head(rows_.rows()) += whitener_->driftIn(left.head(rows_.rows()));
  const double rest = std::max(0.0, target_.squaredNorm() - values.dot(whitened.transpose() * target_));
  const double variance = rest / freedoms_;
  at = fixed;
  for (const Member& m : members) {
    const int k = static_cast<int>(m.columns->cols());
    fit.values.push_back(m.size * values.segment(at, k));
    fit.covariance.push_back(variance * m.size * m.size * inverse.block(at, at, k, k));
    at += k;
  }
  return fit;
}

}  // namespace mm
