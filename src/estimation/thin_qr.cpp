#include "estimation/thin_qr.h"

#include <Eigen/QR>
#include <cmath>

namespace mm {

std::vector<LocalBlock> localBlocks(const Problem& problem, const Eigen::MatrixXd& jacobian,
                                    const std::vector<int>& unknowns) {
  std::vector<LocalBlock> ofFeature(problem.session().artifact.features.size());
  for (std::size_t c = 0; c < unknowns.size(); ++c) {
    const Unknown& u = problem.unknowns()[unknowns[c]];
    if (u.kind == UnknownKind::kFeature) ofFeature[u.owner].columns.push_back(static_cast<int>(c));
  }
  for (int i = 0; i < problem.rowCount(); ++i) {
    const Observation& o = problem.session().observations[problem.rows()[i].observation];
    if (o.feature >= 0 && !ofFeature[o.feature].columns.empty()) ofFeature[o.feature].rows.push_back(i);
  }
  std::vector<LocalBlock> blocks;
  for (LocalBlock& block : ofFeature) {
    for (int i = problem.rowCount(); i < jacobian.rows(); ++i)
      for (const int c : block.columns)
        if (jacobian(i, c) != 0.0) {
          block.rows.push_back(i);
          break;
        }
    if (!block.columns.empty() && block.rows.size() >= block.columns.size())
      blocks.push_back(std::move(block));
  }
  return blocks;
}

Eigen::MatrixXd ThinQr::rInOrder() const {
  Eigen::MatrixXd ordered(r.rows(), r.cols());
  for (std::size_t k = 0; k < order.size(); ++k) ordered.col(order[k]) = r.col(static_cast<Eigen::Index>(k));
  return ordered;
}

ThinQr thinQr(const Eigen::MatrixXd& jacobian, const std::vector<LocalBlock>& blocks, bool wantQ) {
  using Qr = Eigen::HouseholderQR<Eigen::MatrixXd>;
  const Eigen::Index rows = jacobian.rows(), columns = jacobian.cols();
  ThinQr result;
  std::vector<char> localColumn(columns, 0), localRow(rows, 0);
  for (const LocalBlock& block : blocks) {
    for (const int c : block.columns) localColumn[c] = 1, result.order.push_back(c);
    for (const int i : block.rows) localRow[i] = 1;
  }
  const Eigen::Index local = static_cast<Eigen::Index>(result.order.size()), shared = columns - local;
  for (Eigen::Index c = 0; c < columns; ++c)
    if (localColumn[c] == 0) result.order.push_back(static_cast<int>(c));
  const std::vector<int> others(result.order.begin() + local, result.order.end());

  result.r.setZero(columns, columns);
  std::vector<Qr> small;
  Eigen::MatrixXd rest(rows - local, shared);  // what the blocks leave of the shared columns
  Eigen::Index filled = 0, column = 0;
  for (const LocalBlock& block : blocks) {
    const Eigen::Index n = static_cast<Eigen::Index>(block.rows.size()),
                       m = static_cast<Eigen::Index>(block.columns.size());
    small.emplace_back(Eigen::MatrixXd(jacobian(block.rows, block.columns)));
    Eigen::MatrixXd beside = jacobian(block.rows, others);
    beside.applyOnTheLeft(small.back().householderQ().transpose());
    result.r.block(column, column, m, m) = small.back().matrixQR().topRows(m).triangularView<Eigen::Upper>();
    result.r.block(column, local, m, shared) = beside.topRows(m);
    rest.middleRows(filled, n - m) = beside.bottomRows(n - m);
    filled += n - m;
    column += m;
  }
  for (Eigen::Index i = 0; i < rows; ++i)
    if (localRow[i] == 0) rest.row(filled++) = jacobian(i, others);
  const Qr last(rest);
  result.r.block(local, local, shared, shared) =
      last.matrixQR().topRows(shared).triangularView<Eigen::Upper>();
  if (!wantQ) return result;

  const Eigen::MatrixXd lastQ = last.householderQ() * Eigen::MatrixXd::Identity(rest.rows(), shared);
  result.q.setZero(rows, columns);
  filled = column = 0;
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    const LocalBlock& block = blocks[b];
    const Eigen::Index n = static_cast<Eigen::Index>(block.rows.size()),
                       m = static_cast<Eigen::Index>(block.columns.size());
    Eigen::MatrixXd part = Eigen::MatrixXd::Zero(n, m + shared);
    part.topLeftCorner(m, m).setIdentity();
    part.bottomRightCorner(n - m, shared) = lastQ.middleRows(filled, n - m);
    part.applyOnTheLeft(small[b].householderQ());
    result.q(block.rows, Eigen::seqN(column, m)) = part.leftCols(m);
    result.q(block.rows, Eigen::seqN(local, shared)) = part.rightCols(shared);
    filled += n - m;
    column += m;
  }
  for (Eigen::Index i = 0; i < rows; ++i)
    if (localRow[i] == 0) result.q.block(i, local, 1, shared) = lastQ.row(filled++);
  return result;
}

Eigen::MatrixXd orthonormalBasis(Eigen::MatrixXd columns) {
  constexpr double kRounding = 1e-11;  // of a column's own length
  using Qr = Eigen::HouseholderQR<Eigen::MatrixXd>;
  Eigen::Index kept = 0;
  for (Eigen::Index c = 0; c < columns.cols(); ++c) {
    const double norm = columns.col(c).norm();
    if (norm > 0.0) columns.col(kept++) = columns.col(c) / norm;
  }
  columns.conservativeResize(Eigen::NoChange, kept);
  if (kept == 0 || columns.rows() < kept) return Eigen::MatrixXd(columns.rows(), 0);
  std::vector<Eigen::Index> fresh;
  {
    const Qr all(columns);
    for (Eigen::Index c = 0; c < kept; ++c)
      if (std::abs(all.matrixQR()(c, c)) > kRounding) fresh.push_back(c);
    if (static_cast<Eigen::Index>(fresh.size()) == kept)
      return all.householderQ() * Eigen::MatrixXd::Identity(columns.rows(), kept);
  }
  for (std::size_t k = 0; k < fresh.size(); ++k)
    columns.col(static_cast<Eigen::Index>(k)) = columns.col(fresh[k]);
  kept = static_cast<Eigen::Index>(fresh.size());
  columns.conservativeResize(Eigen::NoChange, kept);
  return Qr(columns).householderQ() * Eigen::MatrixXd::Identity(columns.rows(), kept);
}

}  // namespace mm
