#include "diagnosis/full_fit.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "diagnosis/fine_waves.h"
#include "effects/registry.h"

namespace mm {
namespace {

constexpr int kMostBans = 4;    // of shapes that ran off
constexpr double kAlike = 2.0;  // times: periods or time constants within which shapes are alike

/// A shape that is no more than part of a curve in the fit of everything (a wave that becomes longer than the
/// travel, a warm-up than the session), or the best of many by chance, is not asked again, with those of its
/// cause that are like it, and the search goes on without it. @return whether other shapes are left to be
/// asked.
bool ban(Look& look, std::size_t member) {
  const Member m = look.found.members[member];
  std::vector<Shape>& shapes = look.questions.groups.groups[m.group].shapes;
  if (m.nonlinear.empty()) return false;
  const Search search(look.questions);
  Explanation rest = search.without(look.found, member);
  const auto alike = [&](const Shape& s) {
    return !s.nonlinear.empty() && s.nonlinear[0] > m.nonlinear[0] / kAlike &&
           s.nonlinear[0] < m.nonlinear[0] * kAlike;
  };
  const bool shared = std::any_of(rest.members.begin(), rest.members.end(),
                                  [&](const Member& other) { return other.group == m.group; });
  if (shared || std::all_of(shapes.begin(), shapes.end(), alike)) return false;
  shapes.erase(std::remove_if(shapes.begin(), shapes.end(), alike), shapes.end());
  look.found = search.improved(rest);
  return true;
}

/// Marks waves that may be no more than the best of many (isBestByChance).
void byChance(const Search& search, const Look& look, const Evidence& evidence, std::vector<char>& imitates) {
  const std::vector<Member>& members = look.found.members;
  const Evidence::Fit fit = evidence.fit(members);
  for (std::size_t j = 0; j < members.size(); ++j) {
    const Member& m = members[j];
    if (m.nonlinear.size() != 1) continue;
    // beside waves of the same cause, several of which by chance explain anything, each must do so alone; and
    // what follows the place looks like quick drift
    Eigen::VectorXd left = search.questions().rows.target - fit.withoutDrift;
    for (std::size_t k = 0; k < members.size(); ++k)
      if (members[k].group == m.group) left += *members[k].columns * fit.values[k];
    const Shape& shape = look.questions.groups.groups[m.group].shapes[m.shape];
    if (isBestByChance(*look.space, *shape.effect, m.nonlinear[0], m.columns->leftCols(shape.main), left))
      imitates[j] = 1;
  }
}

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

FullFit::Start FullFit::startOf(const Look& look) const {
  Start start;
  start.x = look.space->fitted().x.head(model_.parameterCount());
  for (const Answer& a : answersOf(Search(look.questions), look.found)) {
    start.found.push_back(a.effect);
    append(start.x, a.start);
  }
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

void FullFit::dropWhatDoesNothing(Look& look, const CalibrationResult& fitted) const {
  int bans = 0;
  if (!dropOnce(look, fitted, bans)) return;
  look.found = Search(look.questions).settledWithPairs(std::move(look.found));
  // two that cancel may have come for one that was dropped
  if (dropOnce(look, fitted, bans)) look.found = Search(look.questions).settled(std::move(look.found));
}

bool FullFit::dropOnce(Look& look, const CalibrationResult& fitted, int& bans) const {
  bool dropped = false;
  while (!look.found.members.empty()) {
    const Search search(look.questions);
    const std::vector<Answer> answers = answersOf(search, look.found);
    const auto evidence = search.evidenceAt(look.found);
    const Start start = startOf(look);
    std::vector<double> sure;
    std::vector<char> ranOff;
    try {
      const CalibrationResult full = fit(look, fitted, start.found, start.x);
      sure = surenessOf(answers, full, model_.parameterCount(), look.found.members.size());
      ranOff = whatRanOff(*look.space, answers, full, model_.parameterCount(), look.found.members.size());
    } catch (const NumericalError&) {
      break;  // what the linearised fit says stands
    }
    byChance(search, look, *evidence, ranOff);
    const auto imitates = std::find(ranOff.begin(), ranOff.end(), 1);
    if (imitates != ranOff.end()) {
      const auto j = static_cast<std::size_t>(imitates - ranOff.begin());
      if (bans++ < kMostBans && ban(look, j)) {
        dropped = true;
        continue;
      }
      sure[j] = 0.0;
    }
    std::size_t least = sure.size();
    for (std::size_t j = 0; j < sure.size(); ++j)
      if (sure[j] < 1.0 && !look.questions.groups.groups[look.found.members[j].group].profile &&
          !search.hasCurve(*evidence, look.found.members, j) &&
          (least == sure.size() || sure[j] < sure[least]))
        least = j;
    if (least == sure.size()) break;
    dropped = true;
    // what came with it must now earn its place alone
    look.found = search.pruned(search.without(look.found, least));
  }
  return dropped;
}

void FullFit::takeSizes(const Look& look, const CalibrationResult& fitted, Diagnosis& out) const {
  if (look.found.members.empty()) return;
  const int first = model_.parameterCount();
  const Start start = startOf(look);
  try {
    takeParameters(fit(look, fitted, start.found, start.x), first, start.found, out);
    const Search search(look.questions);
    const std::vector<char> curves = curvesForTheRest(search, look.found);
    if (std::count(curves.begin(), curves.end(), 1) == 0) return;
    // the size of a cause with a curve for its rest is that without the curve
    const std::vector<Answer> answers = answersOf(search, look.found);
    std::vector<EffectPtr> others;
    Eigen::VectorXd startOfOthers = start.x.head(first);
    int at = first;
    for (std::size_t k = 0; k < start.found.size(); ++k) {
      const int count = start.found[k]->parameterCount();
      if (!curves[static_cast<std::size_t>(answers[k].member)]) {
        others.push_back(start.found[k]);
        append(startOfOthers, start.x.segment(at, count));
      }
      at += count;
    }
    takeParameters(fit(look, fitted, others, startOfOthers), first, others, out);
  } catch (const NumericalError&) {
    // what the linearised fit says stands
  }
}

}  // namespace mm
