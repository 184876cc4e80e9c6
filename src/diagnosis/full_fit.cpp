#include "diagnosis/full_fit.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "effects/linearity.h"
#include "effects/registry.h"

namespace mm {
namespace {

void append(Eigen::VectorXd& x, const Eigen::VectorXd& more) {
  const auto before = x.size();
  x.conservativeResize(before + more.size());
  x.tail(more.size()) = more;
}

}  // namespace

Model FullFit::with(const std::vector<EffectPtr>& more) const {
  std::vector<EffectPtr> effects = model_.effects();
  effects.insert(effects.end(), more.begin(), more.end());
  return Model(model_.machine(), model_.domain(), effects);
}

FullFit::Start FullFit::startOf(const Look& look, const Explanation& found) const {
  Start start;
  start.x = look.space->fitted().x.head(model_.parameterCount());
  for (const Answer& a : answersOf(Search(look.questions), found)) {
    start.found.push_back(a.effect);
    append(start.x, a.start);
  }
  start.undetermined.assign(start.found.size(), 0);
  return start;
}

/// The session with an artifact that is known as well as it was found to be: balls that scatter would shift
/// the sizes of causes, and make them seem surer than they are.
Session FullFit::withScatter(const Look& look) const {
  Session session = session_;
  const double unit = look.found.white * unitOf(*look.space);
  const auto both = [](double stated, double found) { return std::sqrt(stated * stated + found * found); };
  for (std::size_t b = 0; b < look.questions.scatter.size(); ++b)
    for (Feature& f : session.artifact.features) {
      const double found = look.found.scatter[b] * unit;
      if (look.questions.scatterNames[b] == "centres" && f.known) f.positionStd = both(f.positionStd, found);
      if (look.questions.scatterNames[b] == "radii" && f.kind == FeatureKind::kBall)
        f.radiusStd = both(f.radiusStd, found);
    }
  return session;
}

/// @param fitted its weights stay.
CalibrationResult FullFit::fit(const Look& look, const CalibrationResult& fitted,
                               const std::vector<EffectPtr>& effects, const Eigen::VectorXd& start) const {
  CalibrateOptions again = options_;
  again.rejectOutliers = false;
  again.weights = fitted.weight;
  std::vector<EffectPtr> all = effects;
  Eigen::VectorXd from = start;
  for (std::size_t b = 0; b < look.questions.scatter.size(); ++b)
    if (look.questions.scatterNames[b] == kDatum && look.found.scatter[b] > 0.0)
      for (const char* direction : {"x", "y", "z"}) {  // the artifact is displaced as a whole
        all.push_back(createEffect(EffectSpec("formula").set("direction", direction).set("formula", "k1"),
                                   model_.domain()));
        append(from, Eigen::VectorXd::Zero(1));
      }
  return calibrate(withScatter(look), with(all), again, from);
}

/// A period or a time constant that runs off in the fit of everything is one that the session does not
/// determine: it is stated as it was found, where an effect of the catalogue has it as a key.
/// @return whether any is held.
bool FullFit::holdWhatRanOff(const Look& look, const Explanation& found, const CalibrationResult& full,
                             Start& start, Diagnosis& out) const {
  const std::vector<Answer> answers = answersOf(Search(look.questions), found);
  const std::vector<char> ranOff =
      whatRanOff(*look.space, answers, full, model_.parameterCount(), found.members.size());
  bool any = false;
  Eigen::VectorXd from = start.x.head(model_.parameterCount());
  for (std::size_t k = 0; k < answers.size(); ++k) {
    const Answer& a = answers[k];
    const std::vector<double>& nonlinear = found.members[static_cast<std::size_t>(a.member)].nonlinear;
    const EffectSpec held = a.effect->shapedAs(nonlinear);
    if (!ranOff[static_cast<std::size_t>(a.member)] || held == a.effect->spec()) {
      start.undetermined[k] = ranOff[static_cast<std::size_t>(a.member)];
      append(from, a.start);
      continue;
    }
    any = true;
    for (CandidateResult& m : out.missing)
      if (m.effect == a.effect->spec()) m.effect = held;
    start.found[k] = createEffect(held, model_.domain());
    for (const int p : linearParameters(*a.effect)) append(from, a.start.segment(p, 1));
  }
  start.x = from;
  return any;
}

void FullFit::takeSizes(const Look& look, const Explanation& found, const CalibrationResult& fitted,
                        Diagnosis& out) const {
  if (found.members.empty()) return;
  const int first = model_.parameterCount();
  Start start = startOf(look, found);
  try {
    CalibrationResult full = fit(look, fitted, start.found, start.x);
    if (holdWhatRanOff(look, found, full, start, out)) full = fit(look, fitted, start.found, start.x);
    takeParameters(full, first, start.found, start.undetermined, out);
    const Search search(look.questions);
    const std::vector<char> curves = curvesForTheRest(search, found);
    if (std::count(curves.begin(), curves.end(), 1) == 0) return;
    // the size of a cause with a curve for its rest is that without the curve
    const std::vector<Answer> answers = answersOf(search, found);
    std::vector<EffectPtr> others;
    std::vector<char> undetermined;
    Eigen::VectorXd startOfOthers = start.x.head(first);
    int at = first;
    for (std::size_t k = 0; k < start.found.size(); ++k) {
      const int count = start.found[k]->parameterCount();
      if (!curves[static_cast<std::size_t>(answers[k].member)]) {
        others.push_back(start.found[k]);
        undetermined.push_back(start.undetermined[k]);
        append(startOfOthers, start.x.segment(at, count));
      }
      at += count;
    }
    takeParameters(fit(look, fitted, others, startOfOthers), first, others, undetermined, out);
  } catch (const NumericalError&) {
    // what the linearised fit says stands
  }
}

}  // namespace mm
