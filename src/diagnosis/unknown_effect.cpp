#include "diagnosis/unknown_effect.h"

#include <algorithm>

#include "diagnosis/structure.h"

namespace mm {
namespace {

constexpr double kShapeOfNamed =
    0.5;                    // of what named effects explain: what their shape may explain beside it
constexpr int kSimple = 4;  // unknowns of a formula that may take the place of a named effect
constexpr double kWorthSaying =
    0.95;                        // of the held-out RMS: noise that follows itself yields formulas of less
constexpr double kLittle = 0.3;  // of what is left, that a profile's shape may be without a formula for it
constexpr double kStructure = 1e-4;     // p-value below which structure is left
constexpr double kFormulaMargin = 5.0;  // log-likelihood by which a formula must beat the catalogue

/// Significant, and large enough to matter: a residual RMS more than about 2.5 % above the noise.
bool isStructure(const Structure& s) { return s.pValue < kStructure && s.share > 0.05; }

/// A function of one position along one direction, where just that profile was found: the same cause in
/// other words.
bool isProfile(const Round& round, const Subset& found, const FoundFormula& formula) {
  if (formula.variables.size() != 1) return false;
  const std::string &position = formula.variables[0], direction = formula.spec.text("direction");
  return std::any_of(found.chosen.begin(), found.chosen.end(), [&](const Chosen& c) {
    const EffectSpec& s = round.set.candidates[c.candidate].spec;
    if (s.text("axis") != position) return false;
    return s.type == "straightness" ? s.text("direction") == direction
                                    : s.type == "positioning_polynomial" && position == direction;
  });
}

int unknownsOf(const Round& round, const Subset& subset) {
  int n = 0;
  for (const Chosen& c : subset.chosen) n += round.set.candidates[c.candidate].freeParameters;
  return n;
}

/// Whether a formula is simple enough to take the place of effects with a name.
bool simpleBeside(const FoundFormula& formula, int replaced) {
  return formula.unknowns() <= std::max(kSimple, replaced);
}

/// What is left of the effects found when the formula counts beside them: one that is no longer significant
/// stood in for a part of it. @param formulaFirst whether the formula explains more than any of them.
Subset besideFormula(const Round& round, const FoundFormula& formula, const Subset& found,
                     bool& formulaFirst) {
  const SubsetSearch& search = round.search;
  Subset kept = search.countingBeside(found, formula.columns);
  if (!simpleBeside(formula, unknownsOf(round, found) - unknownsOf(round, kept))) kept = found;
  double largest = 0.0;
  for (std::size_t i = 0; i < kept.chosen.size(); ++i)
    largest = std::max(largest, search.gainBeside(kept, i, formula.columns).drop);
  formulaFirst =
      simpleBeside(formula, 0) && kept.rss - search.withColumns(kept, formula.columns).rss > largest;
  return kept;
}

/// Whether a short formula explains more, for its length, than the effects of the catalogue do, alone or
/// beside some.
void lookForFormulas(const Round& round, const FormulaSearch& formulaSearch, const Subset& found,
                     bool structure, bool beyondShapes, const std::function<void()>& step, Subset& kept,
                     std::vector<FoundFormula>& formulas) {
  const SubsetSearch& search = round.search;
  const int causes = search.causes(found);
  const bool left = structure || formulaSearch.promising(found, search.degreesOfFreedom());
  if (!left && causes < 2) return;
  const double dof = search.degreesOfFreedom();
  double best = found.objective - kFormulaMargin;
  bool rest = true;  // something is left by the best so far
  // a profile in other words is an answer only where the named ones leave structure, and it leaves none
  const auto explainsAll = [&](const Subset& with, const FoundFormula& f) {
    const Subset grown = search.withColumns(with, f.columns);
    return beyondShapes &&
           !isStructure(structureLeft(round.space, grown.left, grown.basis, search.modulations(with)));
  };
  const auto consider = [&](const Subset& with) {
    step();
    std::vector<FoundFormula> tried = formulaSearch.run(with, dof, search.significance, 5);
    if (tried.empty()) return;
    // what takes the place of effects with a name must be about as simple as these
    if (&with != &found)
      tried.erase(std::remove_if(tried.begin(), tried.end(),
                                 [&](const FoundFormula& f) {
                                   return !simpleBeside(f,
                                                        unknownsOf(round, found) - unknownsOf(round, with)) ||
                                          (isProfile(round, found, f) && !explainsAll(with, f));
                                 }),
                  tried.end());
    if (tried.empty()) return;
    // what takes the place of found effects must do better than these in whatever shape they have
    const double free = tried[0].objective + with.penalty;
    // a function of what a found effect depends on is the same cause in another shape, where it is the
    // lesser part
    const double named = round.space.target().squaredNorm() - with.rss;
    const Subset wide = with.chosen.empty() ? with : search.withColumns(with, search.withShapes(with));
    tried.erase(std::remove_if(tried.begin(), tried.end(),
                               [&](const FoundFormula& f) {
                                 return !with.chosen.empty() &&
                                        with.rss - f.fitted.rss < kShapeOfNamed * named &&
                                        !search.beyond(wide, f.columns, f.choices);
                               }),
                tried.end());
    if (tried.empty()) {
      if (&with == &found) best = std::min(best, free - kFormulaMargin);
      return;
    }
    const double objective = tried[0].objective + with.penalty;
    // beside effects that have a name rather than in their place, where the data hardly decide
    if (objective >= best - (formulas.empty() || &with == &found ? 0.0 : kFormulaMargin)) return;
    best = objective;
    const Subset grown = search.withColumns(with, tried[0].columns);
    rest = isStructure(structureLeft(round.space, grown.left, grown.basis, search.modulations(with)));
    kept = with;
    formulas = std::move(tried);
  };
  if (left) consider(found);
  if (!found.chosen.empty() && (causes >= 2 || beyondShapes)) consider(search.empty());
  if (beyondShapes && causes >= 2)
    for (std::size_t i = 0; i < std::min<std::size_t>(2, found.chosen.size()) && rest; ++i) {
      consider(search.without(found, found.chosen.size() - 1 - i));  // the least, and
      if (found.chosen.size() > 2)
        consider(search.extend(search.empty(), found.chosen[i]));  // only the greatest
    }
}

}  // namespace

UnknownEffect lookBeyond(const Round& round, const HeldOutJudge& judge, const Subset& found,
                         const std::function<void()>& step) {
  UnknownEffect out;
  const Eigen::MatrixXd modulations = round.search.modulations(found);
  const Structure structure = structureLeft(round.space, found.left, found.basis, modulations);
  out.beyondShapes = isStructure(structure);
  const double named = round.space.target().squaredNorm() - found.rss;
  if (out.beyondShapes && !found.chosen.empty() && structure.share * found.rss < kShapeOfNamed * named) {
    const Subset wide = round.search.withColumns(found, round.search.withShapes(found));
    out.beyondShapes = isStructure(structureLeft(round.space, wide.left, wide.basis, modulations));
  }
  out.kept = found;
  if (out.beyondShapes) {
    double explained = 0.0;
    Subset wide =
        found.chosen.empty() ? found : round.search.withColumns(found, round.search.withShapes(found));
    for (const ShapeInModel& shape : round.search.shapesInModel()) {
      explained += shape.explained;
      wide = round.search.withColumns(wide, shape.columns);
    }
    if (structure.share < kLittle && structure.share * found.rss < kShapeOfNamed * explained &&
        !isStructure(structureLeft(round.space, wide.left, wide.basis, modulations))) {
      out.beyondShapes = false;
      out.shapeLeft = true;
      return out;
    }
  }
  out.shapeLeft = isStructure(structure) && !out.beyondShapes;
  const FormulaSearch formulaSearch(round.space);
  std::vector<FoundFormula> formulas;
  lookForFormulas(round, formulaSearch, found, isStructure(structure), out.beyondShapes, step, out.kept,
                  formulas);
  if (!formulas.empty()) out.kept = besideFormula(round, formulas.front(), out.kept, out.formulaFirst);
  const double before = judge.rms(out.kept.basis);
  for (FoundFormula& f : formulas) {
    const double after = formulaSearch.heldOut(f, out.kept, judge);
    if (after < kWorthSaying * before) out.formulas.push_back({std::move(f), before, after});
  }
  // a formula takes the place of effects only where it does as well on held-out data
  const bool replaces = out.kept.chosen.size() < found.chosen.size();
  if (replaces && (out.formulas.empty() || out.formulas[0].after > judge.rms(found.basis))) {
    out.kept = found;
    out.formulas.clear();
    out.formulaFirst = false;
  }
  return out;
}

}  // namespace mm
