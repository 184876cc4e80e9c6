#include "diagnosis/imitators.h"

#include <algorithm>
#include <cmath>

namespace mm {
Subset withoutImitators(const Round& round, const Subset& found) {
  if (found.chosen.empty()) return found;
  const SubsetSearch& search = round.search;
  const double dof = search.degreesOfFreedom();
  Subset best = found;
  double objective = found.objective;
  const auto consider = [&](const EffectSpec& cause, const Eigen::MatrixXd& shapes) {
    const Subset rest = search.countingBeside(found, shapes, &cause);
    if (rest.chosen.size() == found.chosen.size()) return;
    const Subset wide = search.withColumns(rest, shapes);
    const double unknowns = static_cast<double>(wide.basis.cols() - rest.basis.cols());
    const double now = 0.5 * dof * std::log(std::max(wide.rss, 1e-300) / dof) + rest.penalty +
                       0.5 * std::log(dof) * unknowns;
    if (now >= objective) return;
    objective = now;
    best = rest;
    for (const Family& family : search.families()) {  // its own shapes take up what they can
      if (!sameCause(round.set.candidates[family.candidates[0]].spec, cause)) continue;
      const Subset grown = search.withFamily(rest, family);
      if (grown.objective < rest.objective) best = grown;
    }
  };
  for (const ShapeInModel& shape : search.shapesInModel()) consider(shape.spec, shape.columns);
  if (found.chosen.size() > 1)
    for (const Chosen& c : found.chosen) consider(round.set.candidates[c.candidate].spec, search.shapeOf(c));
  return best;
}

}  // namespace mm
