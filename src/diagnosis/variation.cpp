#include "diagnosis/variation.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

#include "diagnosis/search.h"
#include "diagnosis/shape_maker.h"
#include "effects/inputs.h"
#include "effects/linearity.h"
#include "effects/registry.h"

namespace mm {
namespace {

const double kNoChance = std::log(1e-4);
constexpr double kWorthSaying = 0.5;  // of the noise: less is not seen beside it
constexpr int kDegrees = 3;           // a line, a bow, a worn end
constexpr std::size_t kMostTold = 3;  // alternatives

/// A play that changes is followed by these; the model's own constant part stays.
std::string formulaOver(const std::string& joint) {
  return "k1*" + joint + "*" + joint + "_travel + k2*" + joint + "^2*" + joint + "_travel";
}

/// What columns take from what the model leaves, root mean square and its standard uncertainty, that of the
/// noise along it, in units of a whitened residual, and how much they are worth, in nats, by Schwarz's
/// criterion; 0 where chance would do as well.
struct Taken {
  double rms = 0.0, std = 0.0, worth = 0.0;
};
Taken takenBy(const ResidualSpace& space, Eigen::MatrixXd columns) {
  space.project(columns);
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(columns);
  const auto taken = static_cast<double>(qr.rank());
  const double freedoms = space.rows() - space.baseRank() - taken;
  if (taken < 1.0 || freedoms < 1.0) return {};
  const Eigen::VectorXd part = columns * qr.solve(space.target());
  const double rest = (space.target() - part).squaredNorm();
  if (!(rest > 0.0) ||
      logPValueF(part.squaredNorm() / taken / (rest / freedoms), taken, freedoms) > kNoChance)
    return {};
  const double worth =
      0.5 * (space.rows() * std::log(space.target().squaredNorm() / rest) - taken * std::log(space.rows()));
  return {std::sqrt(part.squaredNorm() / space.rows()), std::sqrt(rest / freedoms / space.rows()), worth};
}

Taken takenBy(const ResidualSpace& space, const EffectSpec& spec) {
  const EffectPtr effect = createEffect(spec, space.problem().model().domain());
  return takenBy(space, linearColumns(*effect, space.columns(*effect, startsAt(*effect, {}))));
}

/// Causes that are worth as much as what was found to be `worth` so much, with their probabilities beside it.
std::vector<Alternative> alternatives(const ResidualSpace& space, const std::vector<CandidateResult>& causes,
                                      const EffectSpec& found, double worth) {
  std::vector<Alternative> all;
  double sum = 1.0;  // of the weights, that of what was found among them
  for (const CandidateResult& cause : causes) {
    if (cause.effect == found || inModel(space.problem().model(), cause.effect)) continue;
    const Taken taken = takenBy(space, cause.effect);
    const double more = taken.worth - worth;
    if (!(taken.rms > 0.0) || more < -kIndistinct) continue;
    all.push_back({cause.effect, std::exp(std::min(kMostNats, more))});
    sum += all.back().probability;
  }
  for (Alternative& a : all) a.probability /= sum;
  std::stable_sort(all.begin(), all.end(),
                   [](const auto& a, const auto& b) { return a.probability > b.probability; });
  if (all.size() > kMostTold) all.resize(kMostTold);
  return all;
}

/// Another shape of the effect that takes most, where one takes more than `least`.
Variation otherShapeOf(const ResidualSpace& space, const Effect& effect,
                       const std::vector<CandidateResult>& causes, double unit, double least) {
  const Model& model = space.problem().model();
  Variation most;
  double worth = 0.0;
  for (const ShapeFreedom& f : effect.freedom(model.domain())) {
    if (inModel(model, f.spec)) continue;
    const Taken taken = takenBy(space, f.spec);
    if (unit * taken.rms <= std::max(least, most.rms)) continue;
    most = {effect.spec(), "", unit * taken.rms, unit * taken.std, f.spec, {}};
    worth = taken.worth;
  }
  if (most.rms > 0.0) most.instead = alternatives(space, causes, most.formula, worth);
  return most;
}

/// The effect times a polynomial over a joint.
Variation changeAlong(const ResidualSpace& space, const Effect& effect, const std::vector<double>& p,
                      int joint, const std::vector<CandidateResult>& causes, double unit) {
  const Model& model = space.problem().model();
  RowMatrix varied = linearColumns(effect, space.columns(effect, p));
  const int one = static_cast<int>(varied.cols());
  Eigen::MatrixXd columns(varied.rows(), kDegrees * one);
  Taken taken;
  double worth = -std::numeric_limits<double>::infinity();  // of the degree that has the most
  for (int d = 0; d < kDegrees; ++d) {
    varyAlong(space.problem(), space.used(), joint, varied);
    columns.middleCols(d * one, one) = varied;
    taken = takenBy(space, columns.leftCols((d + 1) * one));
    if (taken.rms > 0.0) worth = std::max(worth, taken.worth);
  }
  Variation v{effect.spec(), model.domain().joints[joint].name, unit * taken.rms, unit * taken.std, {}, {}};
  const std::vector<int> travels = inputsOf(effect, model.domain()).travels;
  const EffectSpec formula =
      EffectSpec("formula").set("direction", v.along).set("formula", formulaOver(v.along));
  if (std::find(travels.begin(), travels.end(), joint) != travels.end() && !inModel(model, formula))
    v.formula = formula;
  if (v.rms > 0.0) v.instead = alternatives(space, causes, formula, worth);
  return v;
}

}  // namespace

std::vector<Variation> variationsOf(const ResidualSpace& space, const std::vector<CandidateResult>& causes,
                                    double unit, double least) {
  std::vector<Variation> found;
  const Model& model = space.problem().model();
  const auto add = [&](Variation v) {
    if (v.rms > kWorthSaying * least) found.push_back(std::move(v));
  };
  for (std::size_t e = 0; e < model.effects().size(); ++e) {
    const Effect& effect = *model.effects()[e];
    std::vector<double> p;
    for (int k = 0; k < effect.parameterCount(); ++k)
      p.push_back(space.fitted().x[model.offset(static_cast<int>(e)) + k]);
    add(otherShapeOf(space, effect, causes, unit, kWorthSaying * least));
    for (const int joint : effect.variesAlong(model.domain()))
      add(changeAlong(space, effect, p, joint, causes, unit));
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const Variation& a, const Variation& b) { return a.rms > b.rms; });
  return found;
}

}  // namespace mm
