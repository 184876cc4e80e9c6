#include "diagnosis/formula_view.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "machine/units.h"

namespace mm {

Eigen::MatrixXd FormulaView::columns(int direction, const std::vector<Term>& terms) const {
  int count = 0;
  for (const Term& t : terms) count += t.coefficients();
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(length(), count);
  int at = 0;
  for (const Term& t : terms) {
    const Eigen::MatrixXd values = t.values(symbols, rows);
    for (int k = 0; k < values.cols(); ++k)
      out.col(at++).head(rows) = factors.col(direction).cwiseProduct(values.col(k));
  }
  return out;
}

void FormulaView::project(Eigen::MatrixXd& columns) const {
  if (basis.cols() == 0) return;
  const Eigen::MatrixXd absorbed = basis.transpose() * columns;
  columns.noalias() -= basis * absorbed;
}

double FormulaView::misfit(double sum) const { return 0.5 * dof * std::log(std::max(sum, 1e-300) / dof); }

double FormulaView::priceOfVariables(std::size_t count) const {
  return std::log(static_cast<double>(directions.size())) +
         static_cast<double>(count) * std::log(static_cast<double>(symbols.size()));
}

double FormulaView::priceOf(const Term& term) const {
  constexpr double kShape = 2.8, kConstant = 1.0;  // logarithms of the number of choices
  constexpr double kRareEvent = 2.0;  // something happens at a moment rather than at a temperature
  const double unknown = 0.5 * std::log(dof);
  double price = unknown * (term.coefficients() + term.constants()) + kConstant * term.constants() +
                 kShape * static_cast<double>(std::max<std::size_t>(1, term.factors.size()));
  for (const Factor& f : term.factors)
    if ((f.shape == Shape::kStep || f.shape == Shape::kAfter) &&
        (symbols[f.symbol].kind == Symbol::Kind::kTemperature ||
         symbols[f.symbol].kind == Symbol::Kind::kCovariate))
      price += kRareEvent;
  return price;
}

FormulaViews::FormulaViews(const ResidualSpace& space) : space_(space), variables_(variablesOf(space)) {
  const Domain& domain = space.problem().model().domain();
  symbols_ = symbolsOf(variables_, domain);
  directions_ = directionsOf(space);
  const int count = static_cast<int>(directions_.names.size());
  Eigen::MatrixXd all = Eigen::MatrixXd::Zero(space.problem().rowCount(), count);
  for (int d = 0; d < count; ++d) {
    const int joint = domain.findJoint(directions_.names[d]);
    const bool rotary = joint >= 0 && domain.joints[joint].kind == JointKind::kRotary;
    for (int i = 0; i < space.rows(); ++i)
      all(space.used()[i], d) = directions_.factors(i, d) * (rotary ? kArcsecond : kMicrometre);
  }
  factors_ = space.whiten(all).topRows(space.rows());
}

FormulaView FormulaViews::view(const Subset& rest, int most) const {
  const int n = space_.rows();
  if (n > most) {
    std::vector<int> taken(most);
    for (int i = 0; i < most; ++i) taken[i] = static_cast<int>((static_cast<long>(i) * n + n / 2) / most);
    return viewOf(rest, taken);
  }
  FormulaView v;
  v.directions = directions_.names;
  v.symbols = symbols_;
  v.rows = n;
  v.factors = factors_;
  v.basis.resize(space_.length(), space_.basis().cols() + rest.basis.cols());
  v.basis << space_.basis(), rest.basis;
  v.left = rest.left;
  v.rss = v.left.squaredNorm();
  v.dof = std::max(1.0, static_cast<double>(v.length() - v.basis.cols()));
  return v;
}

FormulaView FormulaViews::viewOf(const Subset& rest, const std::vector<int>& taken) const {
  const int priors = space_.length() - space_.rows(), n = static_cast<int>(taken.size());
  FormulaView v;
  v.directions = directions_.names;
  v.symbols = symbols_;
  for (std::size_t s = 0; s < symbols_.size(); ++s) v.symbols[s].values = symbols_[s].values(taken);
  v.rows = n;
  v.factors = factors_(taken, Eigen::all);
  const Eigen::MatrixXd& model = space_.basis();
  Eigen::MatrixXd some(n + priors, model.cols() + rest.basis.cols());
  some << model(taken, Eigen::all), rest.basis(taken, Eigen::all), model.bottomRows(priors),
      rest.basis.bottomRows(priors);
  Eigen::VectorXd left(n + priors);
  left << rest.left(taken), rest.left.tail(priors);
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(some);
  v.basis = qr.householderQ() * Eigen::MatrixXd::Identity(some.rows(), qr.rank());
  v.left = left - v.basis * (v.basis.transpose() * left);
  v.rss = v.left.squaredNorm();
  v.dof = std::max(1.0, static_cast<double>(v.length() - v.basis.cols()));
  return v;
}

}  // namespace mm
