#include "diagnosis/judge.h"

#include <Eigen/Dense>
#include <cmath>
#include <random>

#include "machine/cancel_scope.h"

namespace mm {

HeldOutJudge::HeldOutJudge(const ResidualSpace& space) : space_(space) {
  const int rank = space.baseRank();
  for (int f = 0; f < space.folds().folds; ++f) {
    Fold fold;
    for (int i = 0; i < space.rows(); ++i)
      if (space.folds().ofRow[i] == f) fold.rows.push_back(i);
    if (fold.rows.empty()) continue;
    fold.q.resize(static_cast<int>(fold.rows.size()), rank);
    for (std::size_t i = 0; i < fold.rows.size(); ++i)
      fold.q.row(static_cast<int>(i)) = space.basis().row(fold.rows[i]);
    fold.gain.resize(rank, rank);
    if (rank == 0) {
      folds_.push_back(std::move(fold));
      continue;
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(fold.q.transpose() * fold.q);
    Eigen::VectorXd gain(rank);
    for (int k = 0; k < rank; ++k)
      gain[k] = eigen.eigenvalues()[k] > 1.0 - 1e-7 ? 0.0 : 1.0 / (1.0 - eigen.eigenvalues()[k]);
    fold.gain = eigen.eigenvectors() * gain.asDiagonal() * eigen.eigenvectors().transpose();
    folds_.push_back(std::move(fold));
  }
}

double HeldOutJudge::squares(const Eigen::MatrixXd& added, int which) const {
  CancelScope::check();
  const int k = static_cast<int>(added.cols());
  Eigen::VectorXd left = space_.target();
  if (k > 0) left -= added * (added.transpose() * left);
  const Fold& fold = folds_[which];
  Eigen::MatrixXd v(fold.rows.size(), k + 1);
  for (std::size_t i = 0; i < fold.rows.size(); ++i) {
    if (k > 0) v.row(static_cast<int>(i)).head(k) = added.row(fold.rows[i]);
    v(static_cast<int>(i), k) = left[fold.rows[i]];
  }
  Eigen::MatrixXd solved = v;
  if (fold.q.cols() > 0) solved += fold.q * (fold.gain * (fold.q.transpose() * v));
  Eigen::VectorXd held = solved.col(k);
  if (k > 0) {
    const Eigen::MatrixXd inner =
        Eigen::MatrixXd::Identity(k, k) - v.leftCols(k).transpose() * solved.leftCols(k);
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(0.5 * (inner + inner.transpose()));
    Eigen::VectorXd inverse(k);
    for (int i = 0; i < k; ++i)
      inverse[i] = eigen.eigenvalues()[i] > 1e-6 ? 1.0 / eigen.eigenvalues()[i] : 0.0;
    const Eigen::VectorXd right = v.leftCols(k).transpose() * solved.col(k);
    held += solved.leftCols(k) *
            (eigen.eigenvectors() * inverse.cwiseProduct(eigen.eigenvectors().transpose() * right));
  }
  return held.squaredNorm();
}

double HeldOutJudge::rms(const Eigen::MatrixXd& added) const {
  double sum = 0.0;
  for (int f = 0; f < folds(); ++f) sum += squares(added, f);
  return std::sqrt(sum / std::max(1, space_.rows()));
}

namespace {

/// What one orthonormalised effect explains, block by block.
struct BlockScores {
  std::vector<Eigen::VectorXd> score;   // a block: q' left
  std::vector<Eigen::MatrixXd> weight;  // a block: q' q
  double penalty = 0.0;
  int rank = 0;
};

BlockScores blockScores(const ResidualSpace& space, const Subset& rest, const Gain& gain, double penalty) {
  Eigen::MatrixXd q = gain.columns;
  for (int k = 0; k < q.cols(); ++k) q.col(k) /= std::max(q.col(k).norm(), 1e-300);
  if (rest.basis.cols() > 0) q -= rest.basis * (rest.basis.transpose() * q);
  BlockScores b;
  b.rank = static_cast<int>(q.cols());
  b.penalty = penalty;
  b.score.assign(space.folds().blocks, Eigen::VectorXd::Zero(b.rank));
  b.weight.assign(space.folds().blocks, Eigen::MatrixXd::Zero(b.rank, b.rank));
  for (int i = 0; i < space.rows(); ++i) {
    const int block = space.folds().blockOfRow[i];
    b.score[block] += q.row(i).transpose() * rest.left[i];
    b.weight[block] += q.row(i).transpose() * q.row(i);
  }
  return b;
}

double dropOf(const BlockScores& b, const std::vector<int>& counts) {
  Eigen::VectorXd score = Eigen::VectorXd::Zero(b.rank);
  Eigen::MatrixXd weight = Eigen::MatrixXd::Identity(b.rank, b.rank) * 1e-6;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (counts[i] == 0) continue;
    score += counts[i] * b.score[i];
    weight += counts[i] * b.weight[i];
  }
  return score.dot(weight.ldlt().solve(score));
}

}  // namespace

double stability(const ResidualSpace& space, const CandidateSet& set, const Subset& rest, const Gain& chosen,
                 const std::vector<Gain>& rivals, double dof, std::uint64_t seed) {
  constexpr int kDraws = 100;
  const auto penalty = [&](const Gain& g) { return set.candidates[g.candidate].cost; };
  const BlockScores own = blockScores(space, rest, chosen, penalty(chosen));
  std::vector<BlockScores> others;
  for (const Gain& g : rivals)
    if (g.candidate != chosen.candidate) others.push_back(blockScores(space, rest, g, penalty(g)));
  const int blocks = space.folds().blocks;
  std::vector<double> total(blocks, 0.0);
  for (int i = 0; i < space.rows(); ++i) total[space.folds().blockOfRow[i]] += rest.left[i] * rest.left[i];
  std::mt19937_64 random(seed);
  int won = 0;
  for (int draw = 0; draw < kDraws; ++draw) {
    std::vector<int> counts(blocks, 0);
    for (int i = 0; i < blocks; ++i) ++counts[random() % static_cast<std::uint64_t>(blocks)];
    double rss = 0.0;
    for (int i = 0; i < blocks; ++i) rss += counts[i] * total[i];
    const auto objective = [&](const BlockScores& b) {
      return 0.5 * dof * std::log(std::max(rss - dropOf(b, counts), 1e-12 * rss) / dof) + b.penalty;
    };
    const double mine = objective(own);
    bool best = mine < 0.5 * dof * std::log(rss / dof);
    for (const BlockScores& b : others) best &= mine <= objective(b);
    won += best;
  }
  return static_cast<double>(won) / kDraws;
}

}  // namespace mm
