// Heavy tails of the noise: whether Student's t describes it better than a normal distribution does.
#include <Eigen/Core>
#include <cmath>

#include "base/random.h"
#include "base/tiny.h"
#include "diagnosis/answers.h"
#include "estimation/robust.h"

namespace mm {
namespace {

constexpr double kClearly = 5.0;    // nats: as likely by chance as a cause at 100 to 1 and better
constexpr int kFewestOfATail = 60;  // rows: below, a tail is one row

/// What each row differs from what all the others make of it, in units of the standard deviation of that:
/// what a row shows alone is not explained by what was found for it, and a bad reading stays one.
Eigen::VectorXd againstAllOthers(const Search& search, const Explanation& found) {
  const Questions& q = search.questions();
  std::vector<RandomBlock> blocks = q.scatter;
  std::vector<double> sizes = found.scatter;
  for (const Member& m : found.members) {
    blocks.push_back({*m.columns, m.size, 0.0, false});
    sizes.push_back(m.size);
  }
  const WhitenedRows others(q.rows, found.noise.variance, found.noise.drift, blocks, sizes);
  const WhitenedRows::Columns own = others.prepare(RowMatrix::Identity(q.rows.length(), q.rows.rows()));
  const Eigen::VectorXd weight = own.whitened.colwise().squaredNorm() - own.byFixed.colwise().squaredNorm();
  return own.target.cwiseQuotient(weight.cwiseMax(kTiny).cwiseSqrt());
}

}  // namespace

Tails tailsOf(const Search& search, const Explanation& found) {
  const NoiseRows& rows = search.questions().rows;
  const int n = rows.rows();
  Tails tails;
  if (n < kFewestOfATail || search.questions().resolution > 0.0) return tails;  // steps are no tails
  const Eigen::VectorXd e = againstAllOthers(search, found);
  const double variance = e.squaredNorm() / n;
  double best = -0.5 * n * (std::log(2.0 * M_PI * variance) + 1.0) + kClearly;
  for (const double dof : {10.0, 6.0, 4.0, 3.0}) {
    double s2 = variance;
    Eigen::VectorXd weight(n);
    for (int round = 0; round < 30; ++round) {  // expectation and maximisation: Student's t as a mixture
      for (int i = 0; i < n; ++i) weight[i] = (dof + 1.0) / (dof + e[i] * e[i] / s2);
      s2 = weight.dot(e.cwiseAbs2()) / n;
    }
    double value =
        n * (std::lgamma(0.5 * (dof + 1.0)) - std::lgamma(0.5 * dof) - 0.5 * std::log(M_PI * dof * s2));
    for (int i = 0; i < n; ++i) value -= 0.5 * (dof + 1.0) * std::log1p(e[i] * e[i] / (dof * s2));
    if (value > best) {
      best = value;
      tails.dof = dof;
      tails.variance = weight.cwiseInverse();
      tails.variance *= n / tails.variance.cwiseInverse().sum();  // weights of 1 on average
    }
  }
  return tails;
}

void spreadOverResolution(Questions& q) {
  constexpr double kOfStep = 0.25;  // a noise that is not nothing, and little beside that of the readings
  const ResidualSpace& space = *q.space;
  const Eigen::VectorXd resolution = resolutionSigma(space.problem());
  const Eigen::VectorXd whitened = resolution.cwiseQuotient(space.fitted().sigma);
  std::vector<double> left(q.rows.target.begin(), q.rows.target.begin() + space.rows());
  const double middle = medianOf(left);
  for (double& value : left) value = std::abs(value - middle);
  if (!(medianOf(std::move(left)) < whitened.maxCoeff())) return;
  const double steps = std::sqrt(12.0);  // of a standard deviation
  q.resolution = steps * resolution.maxCoeff();
  Random random(1, "resolution");
  Eigen::VectorXd spread(whitened.size());  // of all rows, so that a row has the same in every look
  for (double& value : spread) value = kOfStep * steps * random.uniform(-0.5, 0.5);
  for (int i = 0; i < space.rows(); ++i) {
    const int row = space.used()[static_cast<std::size_t>(i)];
    q.rows.target[i] += whitened[row] * spread[row];
  }
}

}  // namespace mm
