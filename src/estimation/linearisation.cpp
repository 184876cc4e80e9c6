#include "estimation/linearisation.h"

namespace mm {
namespace {

/// Takes the derivatives of one effect at one state to the residuals of one observation.
class ColumnSink final : public ErrorSink {
 public:
  ColumnSink(const Eigen::MatrixXd& gradients, Eigen::MatrixXd& columns)
      : gradients_(gradients), columns_(columns) {}
  void at(int first, int rows) { first_ = first, rows_ = rows; }
  void add(int slot, int parameter, double, double basis) override { derivative(slot, parameter, basis); }
  void value(int, double) override {}
  void derivative(int slot, int parameter, double derivative) override {
    for (int i = first_; i < first_ + rows_; ++i) {
      const double gradient = gradients_(i, slot);
      if (gradient != 0.0) columns_(i, parameter) += gradient * derivative;
    }
  }
  bool wantsDerivatives() const override { return true; }

 private:
  const Eigen::MatrixXd& gradients_;
  Eigen::MatrixXd& columns_;
  int first_ = 0, rows_ = 0;
};

}  // namespace

Linearisation linearise(const Problem& problem, const Eigen::VectorXd& x) {
  Linearisation at(problem);
  at.x_ = x;
  at.residuals_.resize(problem.rowCount());
  at.jacobian_.resize(problem.rowCount(), problem.unknownCount());
  at.slotGradients_.resize(problem.rowCount(), problem.model().machine().layout().size());
  Model::Workspace work;
  Problem::Derivative d;
  Eigen::MatrixXd rows;
  for (int o = 0; o < static_cast<int>(problem.session().observations.size()); ++o) {
    const int first = problem.firstRow(o);
    const int n = problem.residualsOf(o, x, at.residuals_.data() + first, &d, work);
    problem.scatter(o, d, rows);
    at.jacobian_.middleRows(first, n) = rows;
    at.slotGradients_.middleRows(first, n) = d.slots;
  }
  return at;
}

Eigen::MatrixXd Linearisation::effectColumns(const Effect& effect, const std::vector<double>& p,
                                             const std::vector<char>* asked) const {
  Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(problem_->rowCount(), effect.parameterCount());
  ColumnSink sink(slotGradients_, columns);
  for (int o = 0; o < static_cast<int>(problem_->session().observations.size()); ++o) {
    if (asked != nullptr && !(*asked)[o]) continue;
    sink.at(problem_->firstRow(o), problem_->firstRow(o + 1) - problem_->firstRow(o));
    effect.evaluate(problem_->state(o), p.data(), sink);
  }
  return columns;
}

}  // namespace mm
