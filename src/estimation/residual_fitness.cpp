#include "estimation/residual_fitness.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/tiny.h"
#include "base/units.h"

namespace mm {
namespace {

constexpr double kPenalty = 1e4;  // M of LASER, residuals in mm

}  // namespace

ResidualFitness::ResidualFitness(const Problem& problem, const Eigen::VectorXd& base, std::vector<int> genes,
                                 const Eigen::VectorXd& inverseSigma, double unit, double metre,
                                 std::function<bool()> cancelled)
    : problem_(problem),
      base_(base),
      genes_(std::move(genes)),
      inverseSigma_(inverseSigma),
      unit_(unit),
      metre_(metre),
      cancelled_(std::move(cancelled)) {
  placeOf_.assign(problem.rowCount(), -1);
  for (int u = 0; u < problem.unknownCount(); ++u)
    if (solvedInClosedForm(problem, u)) solved_.push_back(u);
  for (int i = 0; i < problem.rowCount(); ++i) {
    const Observation& o = problem.session().observations[problem.rows()[i].observation];
    for (std::size_t s = 0; s < solved_.size() && o.kind == ObservationKind::kContact; ++s)
      if (problem.unknowns()[solved_[s]].owner == o.feature &&
          problem.unknowns()[solved_[s]].component == problem.rows()[i].component)
        placeOf_[i] = static_cast<int>(s);
  }
}

bool ResidualFitness::solvedInClosedForm(const Problem& problem, int unknown) {
  const Unknown& u = problem.unknowns()[unknown];
  const auto& observations = problem.session().observations;
  const auto isLength = [&](const Observation& o) {
    return o.kind == ObservationKind::kLength && o.feature == u.owner;
  };
  return u.kind == UnknownKind::kFeature && u.priorStd == 0.0 && problem.session().placements.empty() &&
         !problem.session().poseFree(0) &&
         problem.session().artifact.features[u.owner].kind == FeatureKind::kPoint &&
         std::none_of(observations.begin(), observations.end(), isLength);
}

void ResidualFitness::solve(Eigen::VectorXd& x) const {
  const Eigen::VectorXd means = meansOf(problem_.residuals(x));
  for (std::size_t s = 0; s < solved_.size(); ++s) x[solved_[s]] += means[static_cast<Eigen::Index>(s)];
}

void ResidualFitness::evaluate(const double* population, std::size_t count, double* costs) const {
  for (std::size_t c = 0; c < count; ++c) {
    // A generation may take many seconds; one that is cut short only leaves its rest behind the best.
    if (cancelled_ && cancelled_()) {
      costs[c] = std::numeric_limits<double>::infinity();
      continue;
    }
    Eigen::VectorXd x = base_;
    for (std::size_t g = 0; g < genes_.size(); ++g) x[genes_[g]] = population[c * genes_.size() + g];
    costs[c] = cost(x);
  }
}

double ResidualFitness::cost(const Eigen::VectorXd& x) const {
  const Eigen::VectorXd r = problem_.residuals(x);
  const Eigen::VectorXd means = meansOf(r);
  double sum = 0.0;
  int used = 0;
  for (int i = 0; i < r.size(); ++i) {
    if (inverseSigma_[i] == 0.0) continue;
    const double w =
        (r[i] - (placeOf_[i] >= 0 ? means[placeOf_[i]] : 0.0)) * inverseSigma_[i] * unit_ / metre_;
    sum += w * w;
    ++used;
  }
  for (const UnitVector& v : problem_.unitVectors()) {  // LASER (11), also where the norm is a constraint
    const double h = v.excess(x.data() + v.first) * kMillimetre / metre_;
    sum += (v.penalty > 0.0 ? v.penalty : kPenalty) * h * h;
  }
  for (const int u : genes_) {
    const double priorStd = problem_.unknowns()[static_cast<std::size_t>(u)].priorStd;
    if (priorStd > 0.0) sum += std::pow(x[u] / priorStd * unit_ / metre_, 2);
  }
  return sum / std::max(1, used);
}

Eigen::VectorXd ResidualFitness::meansOf(const Eigen::VectorXd& r) const {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(solved_.size())), weight = sum;
  for (int i = 0; i < r.size(); ++i) {
    if (placeOf_[i] < 0) continue;
    const double w = inverseSigma_[i] * inverseSigma_[i];
    sum[placeOf_[i]] += w * r[i];
    weight[placeOf_[i]] += w;
  }
  return sum.cwiseQuotient(weight.cwiseMax(kTiny));
}

}  // namespace mm
