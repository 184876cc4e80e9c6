#include "thermal/grey_relation.h"

#include <algorithm>
#include <string>

#include "base/error.h"

namespace mm {
namespace {

Eigen::VectorXd scaled(const Eigen::VectorXd& v) {
  return (v.array() - v.minCoeff()) / (v.maxCoeff() - v.minCoeff());
}

}  // namespace

Eigen::VectorXd greyRelationalGrade(const Eigen::MatrixXd& inputs, const Eigen::MatrixXd& outputs,
                                    double rho) {
  if (inputs.rows() != outputs.rows() || inputs.rows() < 2)
    throw InputError("grey relational grade: " + std::to_string(inputs.rows()) +
                     " samples of the inputs and " + std::to_string(outputs.rows()) +
                     " of the outputs; at least 2 are needed, of each as many");
  if (!(rho > 0.0 && rho <= 1.0))
    throw InputError("grey relational grade: rho = " + std::to_string(rho) +
                     "; it must be above 0 and at most 1");
  Eigen::VectorXd grade = Eigen::VectorXd::Zero(inputs.cols());
  int counted = 0;
  for (Eigen::Index p = 0; p < outputs.cols(); ++p) {
    const Eigen::VectorXd out = outputs.col(p);
    if (!varies(out)) continue;
    const Eigen::VectorXd reference = scaled(out);
    Eigen::MatrixXd delta(inputs.rows(), inputs.cols());
    double least = 1.0, most = 0.0;
    for (Eigen::Index i = 0; i < inputs.cols(); ++i) {
      const Eigen::VectorXd in = inputs.col(i);
      if (!varies(in)) continue;
      const bool falls = (in.array() - in.mean()).matrix().dot((out.array() - out.mean()).matrix()) < 0.0;
      delta.col(i) = (reference - scaled(falls ? Eigen::VectorXd(-in) : in)).cwiseAbs();
      least = std::min(least, delta.col(i).minCoeff());
      most = std::max(most, delta.col(i).maxCoeff());
    }
    for (Eigen::Index i = 0; i < inputs.cols(); ++i) {
      if (!varies(inputs.col(i))) continue;
      grade(i) += most > 0.0 ? ((least + rho * most) / (delta.col(i).array() + rho * most)).mean() : 1.0;
    }
    ++counted;
  }
  if (counted > 0) grade /= counted;
  return grade;
}

}  // namespace mm
