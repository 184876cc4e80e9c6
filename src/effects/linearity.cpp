#include "effects/linearity.h"

#include <algorithm>
#include <cmath>

#include "base/unit_random.h"

namespace mm {
namespace {

constexpr int kTrials = 96;
constexpr double kTolerance = 1e-9;

class Trials {
 public:
  Trials(const Expression& expression, const FormulaVariables& variables, const std::vector<double>& start)
      : expression_(expression), variables_(variables), start_(start), count_(expression.unknowns().size()) {}

  /// True when the mixed second difference in unknowns i and j (i == j: the second difference) vanishes
  /// everywhere.
  bool flat(std::size_t i, std::size_t j) {
    std::mt19937_64 random(7);
    Expression::Evaluation formula(expression_);
    int finite = 0;
    for (int trial = 0; trial < kTrials; ++trial) {
      draw(random, formula);
      std::vector<double> k(count_);
      for (std::size_t m = 0; m < count_; ++m) k[m] = unknown(m, random);
      const double a = unknown(i, random), b = unknown(j, random);
      std::vector<double> both = k, first = k, second = k;
      first[i] += a;
      second[j] += b;
      both[i] += a;
      both[j] += b;
      const double f[4] = {formula(both.data()), formula(first.data()), formula(second.data()),
                           formula(k.data())};
      double largest = 0.0;
      for (const double value : f) largest = std::max(largest, std::abs(value));
      if (!std::isfinite(f[0] + f[1] + f[2] + f[3])) continue;
      ++finite;
      if (std::abs(f[0] - f[1] - f[2] + f[3]) > kTolerance * largest) return false;
    }
    return finite >= kTrials / 8;
  }

  /// True when the formula is zero where all unknowns are; the RMS of each basis function beside it.
  bool homogeneous(std::vector<double>* basis) {
    std::mt19937_64 random(11);
    Expression::Evaluation formula(expression_);
    std::vector<double> sum(count_, 0.0);
    std::vector<int> finite(count_, 0);
    std::vector<double> k(count_, 0.0);
    for (int trial = 0; trial < kTrials; ++trial) {
      draw(random, formula);
      const double zero = formula(k.data());
      if (std::isnan(zero)) continue;
      if (zero != 0.0) return false;
      for (std::size_t i = 0; i < count_; ++i) {
        k[i] = 1.0;
        const double value = formula(k.data());
        k[i] = 0.0;
        if (!std::isfinite(value)) continue;
        sum[i] += value * value;
        ++finite[i];
      }
    }
    basis->assign(count_, 1.0);
    for (std::size_t i = 0; i < count_; ++i) {
      if (finite[i] < kTrials / 8) return false;
      if (sum[i] > 0.0) (*basis)[i] = std::sqrt(sum[i] / finite[i]);
    }
    return true;
  }

 private:
  void draw(std::mt19937_64& random, Expression::Evaluation& formula) {
    double* values = formula.variables();
    for (const int v : expression_.usedVariables()) *values++ = variables_.sample(v, random);
  }

  /// Either sign, six decades around the start.
  double unknown(std::size_t i, std::mt19937_64& random) const {
    const double middle = i < start_.size() && start_[i] != 0.0 ? std::abs(start_[i]) : 1.0;
    return middle * std::pow(10.0, 6.0 * unitRandom(random) - 3.0) * ((random() >> 40) % 2 == 0 ? 1.0 : -1.0);
  }

  const Expression& expression_;
  const FormulaVariables& variables_;
  const std::vector<double>& start_;
  std::size_t count_;
};

}  // namespace

std::vector<int> linearParameters(const Effect& effect) {
  const std::vector<int> nonlinear = effect.nature().nonlinear;
  std::vector<int> linear;
  for (int k = 0; k < effect.parameterCount(); ++k)
    if (std::find(nonlinear.begin(), nonlinear.end(), k) == nonlinear.end()) linear.push_back(k);
  return linear;
}

Eigen::MatrixXd linearColumns(const Effect& effect, const Eigen::MatrixXd& all) {
  const std::vector<int> linear = linearParameters(effect);
  Eigen::MatrixXd columns(all.rows(), static_cast<Eigen::Index>(linear.size()));
  for (std::size_t k = 0; k < linear.size(); ++k)
    columns.col(static_cast<Eigen::Index>(k)) = all.col(linear[k]);
  return columns;
}

std::vector<double> startsAt(const Effect& effect, const std::vector<double>& nonlinear) {
  std::vector<double> p;
  for (const Parameter& parameter : effect.parameters()) p.push_back(parameter.start);
  const std::vector<int> indices = effect.nature().nonlinear;
  for (std::size_t k = 0; k < indices.size() && k < nonlinear.size(); ++k) p[indices[k]] = nonlinear[k];
  return p;
}

Linearity linearityOf(const Expression& expression, const FormulaVariables& variables,
                      const std::vector<double>& start) {
  Linearity result;
  Trials trials(expression, variables, start);
  const int count = static_cast<int>(expression.unknowns().size());
  std::vector<int> affine;
  for (int i = 0; i < count; ++i) {
    bool flat = trials.flat(i, i);
    for (std::size_t m = 0; flat && m < affine.size(); ++m) flat = trials.flat(affine[m], i);
    (flat ? affine : result.nonlinear).push_back(i);
  }
  result.linear = result.nonlinear.empty() && trials.homogeneous(&result.typicalBasis);
  if (!result.linear) result.typicalBasis.clear();
  return result;
}

}  // namespace mm
