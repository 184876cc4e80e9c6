#include "diagnosis/variation.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "diagnosis/shape_maker.h"
#include "effects/inputs.h"
#include "effects/linearity.h"
#include "effects/registry.h"

namespace mm {
namespace {

const double kNoChance = std::log(1e-4);
constexpr double kWorthSaying = 0.5;  // of the noise: less is not seen beside it
constexpr int kDegrees = 3;           // a line, a bow, a worn end

/// A play that changes is followed by these; the model's own constant part stays.
std::string formulaOver(const std::string& joint) {
  return "k1*" + joint + "*" + joint + "_travel + k2*" + joint + "^2*" + joint + "_travel";
}

/// What columns take from what the model leaves, root mean square in units of a whitened residual; 0 where
/// chance would do as well.
double takenBy(const ResidualSpace& space, Eigen::MatrixXd columns) {
  space.project(columns);
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(columns);
  const auto taken = static_cast<double>(qr.rank());
  const double freedoms = space.rows() - space.baseRank() - taken;
  if (taken < 1.0 || freedoms < 1.0) return 0.0;
  const Eigen::VectorXd part = columns * qr.solve(space.target());
  const double rest = (space.target() - part).squaredNorm();
  if (!(rest > 0.0) ||
      logPValueF(part.squaredNorm() / taken / (rest / freedoms), taken, freedoms) > kNoChance)
    return 0.0;
  return std::sqrt(part.squaredNorm() / space.rows());
}

}  // namespace

std::vector<Variation> variationsOf(const ResidualSpace& space, double unit, double least) {
  std::vector<Variation> found;
  const Model& model = space.problem().model();
  const Domain& domain = model.domain();
  for (std::size_t e = 0; e < model.effects().size(); ++e) {
    const Effect& effect = *model.effects()[e];
    std::vector<double> p;
    for (int k = 0; k < effect.parameterCount(); ++k)
      p.push_back(space.fitted().x[model.offset(static_cast<int>(e)) + k]);
    Variation shape{effect.spec(), "", 0.0, EffectSpec("")};  // the one that takes most
    for (const ShapeFreedom& f : effect.freedom(domain)) {
      if (inModel(model, f.spec)) continue;
      const EffectPtr other = createEffect(f.spec, domain);
      const double rms =
          unit * takenBy(space, linearColumns(*other, space.columns(*other, startsAt(*other, {}))));
      if (rms > std::max(kWorthSaying * least, shape.rms)) shape.rms = rms, shape.formula = f.spec;
    }
    if (shape.rms > 0.0) found.push_back(std::move(shape));
    for (const int joint : effect.variesAlong(domain)) {
      RowMatrix varied = linearColumns(effect, space.columns(effect, p));
      const int one = static_cast<int>(varied.cols());
      Eigen::MatrixXd columns(varied.rows(), kDegrees * one);
      for (int d = 0; d < kDegrees; ++d) {
        varyAlong(space.problem(), space.used(), joint, varied);
        columns.middleCols(d * one, one) = varied;
      }
      const double rms = unit * takenBy(space, std::move(columns));
      if (!(rms > kWorthSaying * least)) continue;
      Variation v{effect.spec(), domain.joints[joint].name, rms, EffectSpec("")};
      const std::vector<int> travels = inputsOf(effect, domain).travels;
      if (std::find(travels.begin(), travels.end(), joint) != travels.end())
        v.formula = EffectSpec("formula").set("direction", v.along).set("formula", formulaOver(v.along));
      found.push_back(std::move(v));
    }
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const Variation& a, const Variation& b) { return a.rms > b.rms; });
  return found;
}

}  // namespace mm
