#include "estimation/datum.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "estimation/residual_space.h"
#include "estimation/thin_qr.h"

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
  const ResidualSpace space(fitted);
  const Problem& problem = space.problem();
  Eigen::MatrixXd zeros = Eigen::MatrixXd::Zero(problem.rowCount(), problem.model().machine().jointCount());
  for (int i = 0; i < problem.rowCount(); ++i) {
    const ResidualRow& row = problem.rows()[static_cast<std::size_t>(i)];
    if (withoutSetup(problem.session().observations[static_cast<std::size_t>(row.observation)]))
      zeros(i, row.component) = 1.0;
  }
  Eigen::MatrixXd both(space.length(), space.baseRank() + zeros.cols());
  both << space.basis(), space.whiten(zeros);
  both = orthonormalBasis(std::move(both));
  const auto taken = static_cast<double>(both.cols() - space.baseRank()),
             freedoms = static_cast<double>(space.length() - both.cols());
  if (taken < 1.0 || freedoms < 1.0) return false;
  const Eigen::VectorXd& r = space.target();
  const double without = r.squaredNorm(), with = (r - both * (both.transpose() * r)).squaredNorm();
  if (!(with < without)) return false;
  return !(with > 0.0) ||
         logPValueF((without - with) / taken * freedoms / with, taken, freedoms) < std::log(kChance);
}

}  // namespace mm
