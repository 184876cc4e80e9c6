#include "estimation/datum.h"

#include <Eigen/Dense>
#include <algorithm>
#include <boost/math/distributions/fisher_f.hpp>

#include "estimation/thin_qr.h"
#include "estimation/whitened.h"

namespace mm {
namespace {

bool withoutSetup(const Observation& o) { return o.kind == ObservationKind::kDeviation && o.setup < 0; }

}  // namespace

bool lawMayStateDatum(const Session& session, const Model& model) {
  const auto& effects = model.effects();
  return !effects.empty() && std::all_of(effects.begin(), effects.end(), [](const EffectPtr& e) {
    return e->nature().statesDatum;
  }) && std::any_of(session.observations.begin(), session.observations.end(), withoutSetup);
}

bool contradictsDatum(const CalibrationResult& fitted) {
  constexpr double kChance = 1e-4;
  const Problem& problem = *fitted.problem;
  const Eigen::VectorXd inverseSigma = fitted.weight.cwiseSqrt().cwiseQuotient(fitted.sigma);
  const WhitenedSystem system(problem, fitted.x, inverseSigma, fitted.identifiability.fixed);
  Eigen::MatrixXd zeros =
      Eigen::MatrixXd::Zero(system.jacobian.rows(), problem.model().machine().jointCount());
  for (int i = 0; i < problem.rowCount(); ++i) {
    const ResidualRow& row = problem.rows()[static_cast<std::size_t>(i)];
    if (withoutSetup(problem.session().observations[static_cast<std::size_t>(row.observation)]))
      zeros(i, row.component) = inverseSigma[i];
  }
  const Eigen::Index unknowns = system.jacobian.cols();
  if (system.jacobian.rows() <= unknowns) return false;
  const Eigen::MatrixXd basis = orthonormalBasis(system.jacobian);
  Eigen::MatrixXd both(zeros.rows(), basis.cols() + zeros.cols());
  both << basis, zeros;
  both = orthonormalBasis(std::move(both));
  const double taken = static_cast<double>(both.cols() - basis.cols());
  const double used = static_cast<double>((fitted.weight.array() > 0.0).count() + system.jacobian.rows() -
                                          problem.rowCount());
  const double freedoms = used - static_cast<double>(both.cols());
  if (taken < 1.0 || freedoms < 1.0) return false;
  const Eigen::VectorXd& r = system.residuals;
  const double without = (r - basis * (basis.transpose() * r)).squaredNorm();
  const double with = (r - both * (both.transpose() * r)).squaredNorm();
  if (!(with < without)) return false;
  if (!(with > 0.0)) return true;
  const boost::math::fisher_f f(taken, freedoms);
  return boost::math::cdf(boost::math::complement(f, (without - with) / taken * freedoms / with)) < kChance;
}

}  // namespace mm
