#include "estimation/folds.h"

#include <Eigen/Core>
#include <algorithm>

#include "base/dense.h"
#include "estimation/row_products.h"
#include "estimation/thin_qr.h"

namespace mm {
namespace {

constexpr int kFolds = 10, kSmallestBlock = 8, kBlocks = 60;
/// A direction of which the other rows have a smaller share is fitted to the block itself: they would give it
/// a value that is rounding.
constexpr double kOwn = 1e-7;
/// The same where rows beside the block are left out, too, and drift is predicted across the gap: a share of
/// a hundredth would blow ten times the noise into the block.
constexpr double kDetermined = 0.01;

/// First observation behind each stretch that a block must not cut: a free feature that was measured in one
/// go and is little longer than a block. What a cut leaves of its contacts would have to find its position.
std::vector<int> stretchEnds(const Problem& problem, int size) {
  struct Run {
    int first = -1, last = -1, count = 0;
  };
  const auto& observations = problem.session().observations;
  std::vector<Run> runs(problem.session().artifact.features.size());
  std::vector<int> ends(observations.size());
  for (int o = 0; o < static_cast<int>(observations.size()); ++o) {
    ends[o] = o + 1;
    if (observations[o].feature < 0) continue;
    Run& run = runs[observations[o].feature];
    if (run.count == 0) run.first = o;
    run.last = o;
    ++run.count;
  }
  for (std::size_t f = 0; f < runs.size(); ++f) {
    const Run& run = runs[f];
    const bool free = run.count > 0 && problem.find(UnknownKind::kFeature, static_cast<int>(f)) >= 0;
    if (free && run.count < 2 * size && run.last - run.first + 1 == run.count)
      for (int o = run.first; o <= run.last; ++o) ends[o] = run.last + 1;
  }
  return ends;
}

/// A block for each observation, numbered from 0 in the order of time.
std::vector<int> blocksOf(const std::vector<int>& ends, int size) {
  std::vector<int> blocks(ends.size());
  int block = 0, first = 0;
  for (int o = 0; o < static_cast<int>(ends.size());) {
    const int end = ends[o];
    for (; o < end; ++o) blocks[o] = block;
    if (end - first >= size) ++block, first = end;
  }
  return blocks;
}

}  // namespace

Folds makeFolds(const Problem& problem) {
  Folds folds;
  const int observations = static_cast<int>(problem.session().observations.size());
  const int size =
      std::max(std::min(kSmallestBlock, std::max(1, observations / kFolds)), observations / kBlocks);
  std::vector<int> blocks = blocksOf(stretchEnds(problem, size), size);
  if (blocks.back() == 0)
    for (int o = 0; o < observations; ++o) blocks[o] = o / size;
  folds.blocks = blocks.back() + 1;
  folds.folds = std::min(kFolds, folds.blocks);
  for (const ResidualRow& row : problem.rows()) {
    const int block = blocks[row.observation];
    folds.blockOfRow.push_back(block);
    folds.ofRow.push_back(block % folds.folds);
  }
  return folds;
}

Eigen::VectorXd heldOutResiduals(const Eigen::MatrixXd& q, const Eigen::VectorXd& residuals,
                                 const Folds& folds) {
  const int data = static_cast<int>(folds.ofRow.size()), rank = static_cast<int>(q.cols());
  Eigen::VectorXd out = residuals.head(data);
  if (rank == 0) return out;
  for (int f = 0; f < folds.folds; ++f) {
    std::vector<int> rows;
    for (int i = 0; i < data; ++i)
      if (folds.ofRow[i] == f) rows.push_back(i);
    if (rows.empty()) continue;
    std::vector<int> columns;  // that the fold touches: the centres of other balls are zero in it
    for (int k = 0; k < rank; ++k)
      if (std::any_of(rows.begin(), rows.end(), [&](int i) { return q(i, k) != 0.0; })) columns.push_back(k);
    const int touched = static_cast<int>(columns.size());
    if (touched == 0) continue;
    const Eigen::MatrixXd qf = q(rows, columns);
    const Eigen::VectorXd rf = residuals(rows);
    const SymmetricEigen eigen(qf.transpose() * qf);
    Eigen::VectorXd gain(touched);
    for (int k = 0; k < touched; ++k) {
      const double share = eigen.values[k];  // of the information on this direction that the fold alone holds
      gain[k] = share > 1.0 - kOwn ? 0.0 : 1.0 / (1.0 - share);
    }
    out(rows) =
        rf + qf * (eigen.vectors * gain.cwiseProduct(eigen.vectors.transpose() * (qf.transpose() * rf)));
  }
  return out;
}

Eigen::MatrixXd determinedWithin(const RowMatrix& base, const std::vector<char>& held,
                                 const std::vector<char>& unused) {
  if (base.cols() == 0) return Eigen::MatrixXd(std::count(held.begin(), held.end(), 1), 0);
  std::vector<int> judged;
  RowMatrix others = base;
  for (std::size_t i = 0; i < held.size(); ++i) {
    if (unused[i]) others.row(static_cast<long>(i)).setZero();
    if (held[i]) judged.push_back(static_cast<int>(i));
  }
  const SymmetricEigen shares(rowProducts(others));
  const long undetermined = (shares.values.array() < kDetermined).count();
  return orthonormalBasis(base(judged, Eigen::all) * shares.vectors.leftCols(undetermined));
}

}  // namespace mm
