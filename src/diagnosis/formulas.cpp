#include "diagnosis/formulas.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "diagnosis/formula_fit.h"
#include "diagnosis/formula_screen.h"
#include "machine/cancel_scope.h"
#include "machine/two_threads.h"

namespace mm {
namespace {

constexpr int kMostRows = 1500;  // for the search; what is found is judged on all
constexpr int kGuesses = 12;
constexpr std::size_t kStarts = 5;
constexpr double kNear = 25.0;  // nats

FoundFormula found(const ResidualSpace& space, const FormulaViews& views, const FormulaView& view,
                   const FittedFormula& fitted) {
  FoundFormula f;
  std::string text;
  int unknown = 0;
  const auto note = [&](int symbol) {
    for (int v : views.symbols()[symbol].variables) {
      const std::string& name = views.variables()[v].name;
      if (std::find(f.variables.begin(), f.variables.end(), name) == f.variables.end())
        f.variables.push_back(name);
    }
  };
  for (const Term& t : fitted.terms) {
    for (const std::string& part : t.texts(view.symbols))
      text += (text.empty() ? "k" : "+k") + std::to_string(++unknown) + (part.empty() ? "" : "*" + part);
    for (const Factor& factor : t.factors) {
      note(factor.symbol);
      if (factor.other >= 0) note(factor.other);
    }
  }
  f.columns = view.columns(fitted.direction, fitted.terms);
  space.project(f.columns);
  f.spec = EffectSpec("formula");
  f.spec.set("direction", view.directions[fitted.direction]).set("formula", text);
  f.fitted = fitted;
  f.objective = fitted.objective;
  return f;
}

}  // namespace

FormulaSearch::FormulaSearch(const ResidualSpace& space) : space_(space), views_(space) {}

bool FormulaSearch::promising(const Subset& rest, double dof) const {
  constexpr double kWorthALook = 3.0;  // nats
  if (views_.symbols().empty()) return false;
  FormulaView some = views_.view(rest, kMostRows);
  if (some.directions.empty()) return false;
  if (space_.rows() <= kMostRows) some.dof = dof;
  const std::vector<FormulaGuess> guesses = screenFormulas(some, 1);
  return !guesses.empty() && guesses[0].objective < some.misfit() - kWorthALook;
}

std::vector<FoundFormula> FormulaSearch::run(const Subset& rest, double dof, double significance,
                                             int count) const {
  std::vector<FoundFormula> out;
  if (views_.symbols().empty()) return out;
  FormulaView some = views_.view(rest, kMostRows);
  if (space_.rows() <= kMostRows) some.dof = dof;
  if (some.directions.empty()) return out;
  const std::vector<FormulaGuess> guesses = screenFormulas(some, kGuesses);
  std::vector<std::vector<FittedFormula>> fitted(guesses.size());
  std::vector<bool> worth(guesses.size(), true);
  const CancelScope* scope = CancelScope::current();
  const auto fitAll = [&](std::size_t from, std::size_t to) {
    const auto work = [&](std::size_t begin) {
      for (std::size_t i = begin; i < guesses.size(); i += 2) {
        if (!worth[i] || (scope != nullptr && scope->asked())) continue;
        for (FittedFormula& f : fitFormulas(some, guesses[i], from, to)) fitted[i].push_back(std::move(f));
      }
    };
    inTwo(work);
    CancelScope::check();
  };
  // one start each, then all starts where the first came near the best
  fitAll(0, 1);
  double best = 1e300;
  for (const auto& f : fitted)
    for (const FittedFormula& one : f) best = std::min(best, one.objective);
  for (std::size_t i = 0; i < guesses.size(); ++i)
    worth[i] = !fitted[i].empty() && fitted[i][0].objective < best + kNear;
  fitAll(1, kStarts);
  std::vector<FittedFormula> all;
  for (auto& f : fitted) all.insert(all.end(), f.begin(), f.end());
  const auto better = [](const FittedFormula& a, const FittedFormula& b) {
    return a.objective < b.objective;
  };
  std::stable_sort(all.begin(), all.end(), better);
  if (all.size() > 12) all.resize(12);
  FormulaView whole = views_.view(rest, space_.rows());
  whole.dof = dof;  // as the objectives of effects count it
  if (space_.rows() > kMostRows) {
    for (FittedFormula& f : all) f = refit(whole, f);
    std::stable_sort(all.begin(), all.end(), better);
  }
  for (const FittedFormula& f : all) {
    if (static_cast<int>(out.size()) >= count) break;
    const double unknowns = f.unknowns(), free = dof - static_cast<double>(rest.basis.cols()) - unknowns;
    if (!(free > 3.0) || !(f.rss < whole.rss)) continue;
    const double choices = f.price - 0.5 * std::log(some.dof) * unknowns;  // what was chosen among
    const double logP = logPValueF((whole.rss - f.rss) / unknowns / (f.rss / free), unknowns, free) + choices;
    if (logP > std::log(significance)) continue;
    FoundFormula one = found(space_, views_, whole, f);
    one.choices = choices;
    if (std::none_of(out.begin(), out.end(), [&](const FoundFormula& o) { return o.spec == one.spec; }))
      out.push_back(std::move(one));
  }
  return out;
}

double FormulaSearch::heldOut(const FoundFormula& formula, const Subset& rest,
                              const HeldOutJudge& judge) const {
  const FormulaView whole = views_.view(rest, space_.rows());
  double sum = 0.0;
  for (int fold = 0; fold < judge.folds(); ++fold) {
    std::vector<bool> out(space_.rows(), false);
    for (int row : judge.rowsOf(fold)) out[row] = true;
    std::vector<int> in;
    for (int row = 0; row < space_.rows(); ++row)
      if (!out[row]) in.push_back(row);
    std::vector<int> taken;
    const std::size_t stride = in.size() / kMostRows + 1;
    for (std::size_t i = 0; i < in.size(); i += stride) taken.push_back(in[i]);
    const FittedFormula fitted = refit(views_.viewOf(rest, taken), formula.fitted);
    Eigen::MatrixXd columns = whole.columns(fitted.direction, fitted.terms);
    whole.project(columns);
    const Eigen::VectorXd size = columns.colwise().norm().transpose().cwiseMax(1e-300);
    columns = columns * size.cwiseInverse().asDiagonal();
    const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(columns);
    Eigen::MatrixXd with(space_.length(), rest.basis.cols() + qr.rank());
    with << rest.basis, qr.householderQ() * Eigen::MatrixXd::Identity(columns.rows(), qr.rank());
    sum += judge.squares(with, fold);
  }
  return std::sqrt(sum / std::max(1, space_.rows()));
}

}  // namespace mm
