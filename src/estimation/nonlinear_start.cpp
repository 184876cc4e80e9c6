#include "estimation/nonlinear_start.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "base/dense.h"
#include "estimation/thin_qr.h"
#include "estimation/whitened.h"

namespace mm {

void nonlinearStart(const Problem& problem, Eigen::VectorXd& x, const std::vector<char>& fixed,
                    const Eigen::VectorXd& inverseSigma, const std::function<bool()>& cancelled) {
  const Model& model = problem.model();
  for (int e = 0; e < static_cast<int>(model.effects().size()); ++e) {
    const Effect& effect = *model.effects()[e];
    std::vector<std::vector<double>> starts = effect.nature().searchStarts;
    if (starts.empty() || effect.separable()) continue;  // nothing to search where all amplitudes are linear
    const std::vector<int> nonlinear = effect.nature().nonlinear;
    for (const double length : effect.nature().fineWaves.lengths) starts.push_back({length});
    const int offset = model.offset(e);
    bool atZero = true;  // a start that the caller chose is kept
    for (int k = 0; k < effect.parameterCount(); ++k)
      if (std::find(nonlinear.begin(), nonlinear.end(), k) == nonlinear.end()) atZero &= x[offset + k] == 0.0;
    if (!atZero) continue;

    std::vector<char> without = fixed;  // everything else is refitted
    for (int k = 0; k < effect.parameterCount(); ++k) without[offset + k] = 1;
    for (int other = e + 1; other < static_cast<int>(model.effects().size()); ++other)
      if (!model.effects()[other]->nature().searchStarts.empty())
        for (int k = 0; k < model.effects()[other]->parameterCount(); ++k)
          without[model.offset(other) + k] = 1;
    const Linearisation at = linearise(problem, x);
    const WhitenedSystem system(at, inverseSigma, without);
    const Eigen::Index rows = system.jacobian.rows();
    const Eigen::MatrixXd q =
        orthonormalBasis(rows > system.jacobian.cols() ? system.jacobian : Eigen::MatrixXd(rows, 0));
    Eigen::VectorXd target = -system.residuals;
    target -= q * (q.transpose() * target);
    double best = -1.0;
    Eigen::VectorXd bestValues;
    for (const std::vector<double>& start : starts) {
      if (cancelled && cancelled()) break;
      std::vector<double> p;
      for (const Parameter& one : effect.parameters()) p.push_back(one.start);
      for (std::size_t k = 0; k < nonlinear.size(); ++k) p[nonlinear[k]] = start[k];
      const Eigen::MatrixXd all = at.effectColumns(effect, p);
      std::vector<int> linear;
      for (int k = 0; k < effect.parameterCount(); ++k)
        if (std::find(nonlinear.begin(), nonlinear.end(), k) == nonlinear.end() && !fixed[offset + k])
          linear.push_back(k);
      if (linear.empty()) break;
      Eigen::MatrixXd a = Eigen::MatrixXd::Zero(rows, linear.size());
      for (std::size_t k = 0; k < linear.size(); ++k)
        for (int i = 0; i < problem.rowCount(); ++i) {
          const double v = all(i, linear[k]) * effect.parameters()[linear[k]].scale * inverseSigma[i];
          if (inverseSigma[i] != 0.0 && std::isfinite(v)) a(i, static_cast<int>(k)) = v;
        }
      a -= q * (q.transpose() * a);
      const Eigen::VectorXd amplitudes = leastSquares(a, target);
      const double drop = target.squaredNorm() - (target - a * amplitudes).squaredNorm();
      if (!(drop > best) || !amplitudes.allFinite()) continue;
      best = drop;
      bestValues.resize(effect.parameterCount());
      for (int k = 0; k < effect.parameterCount(); ++k) bestValues[k] = p[k];
      for (std::size_t k = 0; k < linear.size(); ++k)
        bestValues[linear[k]] = amplitudes[static_cast<int>(k)] * effect.parameters()[linear[k]].scale;
    }
    if (best >= 0.0) x.segment(offset, effect.parameterCount()) = bestValues;
  }
}

}  // namespace mm
