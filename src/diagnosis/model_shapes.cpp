// What the effects of the model have beside the shape that they have in it: the remainder of a screw's wave
// is no new cause.
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "diagnosis/shape_maker.h"
#include "effects/linearity.h"
#include "effects/registry.h"

namespace mm {

std::vector<RandomBlock> shapesOfTheModel(const ResidualSpace& space) {
  std::vector<RandomBlock> blocks;
  const Model& model = space.problem().model();
  const Domain& domain = model.domain();
  for (std::size_t e = 0; e < model.effects().size(); ++e) {
    const Effect& effect = *model.effects()[e];
    double size = 0.0;  // of the fitted values, in units of the parameters' scale
    for (const int k : linearParameters(effect))
      size = std::max(size, std::abs(space.fitted().x[model.offset(static_cast<int>(e)) + k]) /
                                effect.parameters()[k].scale);
    if (!(size > 0.0)) continue;
    std::vector<double> p;
    for (int k = 0; k < effect.parameterCount(); ++k)
      p.push_back(space.fitted().x[model.offset(static_cast<int>(e)) + k]);
    const auto add = [&](const Eigen::MatrixXd& columns, double share) {
      constexpr double kNothing = 0.05;  // of the noise, root mean square: less is not worth its columns
      Eigen::MatrixXd seen = columns;
      space.project(seen);
      if (!(share * size * seen.norm() > kNothing * std::sqrt(static_cast<double>(space.rows())))) return;
      blocks.push_back({RowMatrix(columns), share * size, 0.0, true});
    };
    for (const ShapeFreedom& f : effect.freedom(domain)) {
      if (inModel(model, f.spec)) continue;
      const EffectPtr other = createEffect(f.spec, domain);
      // in the units of this effect's parameters, so that a share is a share
      Eigen::MatrixXd columns = linearColumns(*other, space.columns(*other, startsAt(*other, {})));
      add(columns, f.share);
    }
    const std::vector<int> nonlinear = effect.nonlinearParameters();
    std::vector<double> now;
    for (const int k : nonlinear) now.push_back(p[k]);
    for (const Effect::NonlinearFreedom& f : effect.freedomBeside(now)) {
      std::vector<double> at = p;
      for (std::size_t k = 0; k < nonlinear.size(); ++k) at[nonlinear[k]] = f.nonlinear[k];
      add(linearColumns(effect, space.columns(effect, at)), f.share);
    }
    for (const int joint : effect.variesAlong(domain)) {
      RowMatrix columns = linearColumns(effect, space.columns(effect, p));
      varyAlong(space.problem(), space.used(), joint, columns);
      add(columns, kVariation);
    }
  }
  return blocks;
}

}  // namespace mm
