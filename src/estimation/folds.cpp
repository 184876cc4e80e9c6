#include "estimation/folds.h"

#include <Eigen/Dense>
#include <algorithm>

namespace mm {

Folds makeFolds(const Problem& problem) {
  constexpr int kFolds = 10, kSmallestBlock = 8, kBlocks = 60;
  Folds folds;
  const int observations = static_cast<int>(problem.session().observations.size());
  const int size = std::max(std::min(kSmallestBlock, std::max(1, observations / kFolds)), observations / kBlocks);
  folds.blocks = (observations + size - 1) / size;
  folds.folds = std::min(kFolds, folds.blocks);
  for (const ResidualRow& row : problem.rows()) {
    const int block = row.observation / size;
    folds.blockOfRow.push_back(block);
    folds.ofRow.push_back(block % folds.folds);
  }
  return folds;
}

Eigen::VectorXd heldOutResiduals(const Eigen::MatrixXd& q, const Eigen::VectorXd& residuals, const Folds& folds) {
  const int data = static_cast<int>(folds.ofRow.size()), rank = static_cast<int>(q.cols());
  Eigen::VectorXd out = residuals.head(data);
  if (rank == 0) return out;
  for (int f = 0; f < folds.folds; ++f) {
    std::vector<int> rows;
    for (int i = 0; i < data; ++i)
      if (folds.ofRow[i] == f) rows.push_back(i);
    if (rows.empty()) continue;
    Eigen::MatrixXd qf(rows.size(), rank);
    Eigen::VectorXd rf(rows.size());
    for (std::size_t i = 0; i < rows.size(); ++i) {
      qf.row(static_cast<int>(i)) = q.row(rows[i]);
      rf[static_cast<int>(i)] = residuals[rows[i]];
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(qf.transpose() * qf);
    Eigen::VectorXd gain(rank);
    for (int k = 0; k < rank; ++k) {
      const double share = eigen.eigenvalues()[k];  // of the information on this direction that the fold alone holds
      gain[k] = share > 1.0 - 1e-7 ? 0.0 : 1.0 / (1.0 - share);
    }
    const Eigen::VectorXd held =
        rf + qf * (eigen.eigenvectors() * gain.cwiseProduct(eigen.eigenvectors().transpose() * (qf.transpose() * rf)));
    for (std::size_t i = 0; i < rows.size(); ++i) out[rows[i]] = held[static_cast<int>(i)];
  }
  return out;
}

}  // namespace mm
