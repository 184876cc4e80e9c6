#include "diagnosis/formula_fit.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <tuple>

#include "diagnosis/formula_constants.h"

namespace mm {
namespace {

constexpr double kWorthIt = 3.0;  // nats that one more term must bring
constexpr std::size_t kMostTerms = 4;
constexpr double kAsGood = 1.04;  // of the residual sum of squares: what a term less may cost

std::vector<Term> dictionaryOf(const FormulaView& view, const FormulaGuess& guess) {
  std::vector<Term> terms;
  terms.push_back({});
  std::vector<std::vector<Factor>> simple, all;
  for (int s : guess.symbols) {
    simple.push_back(simpleShapes(view.symbols, s));
    all.push_back(allShapes(view.symbols, s));
    for (const Factor& w : guess.waves) {
      if (w.symbol != s || w.other >= 0) continue;
      for (int harmonic = 1; harmonic <= 3; ++harmonic) {
        all.back().push_back(w);
        all.back().back().constants[0] /= harmonic;
      }
    }
    for (const Factor& f : all.back()) terms.push_back({{f}});
  }
  const std::size_t n = guess.symbols.size();
  for (std::size_t a = 0; a < n; ++a)
    for (std::size_t b = 0; b < n; ++b) {
      if (a == b) continue;
      for (std::size_t i = 0; i < simple[a].size(); ++i)
        for (std::size_t j = 0; j < all[b].size(); ++j) {
          if (a > b && j < simple[b].size()) continue;  // simple with simple is there already
          terms.push_back({{simple[a][i], all[b][j]}});
        }
      // what fades or grows along one symbol with what waves or steps along the other
      for (const Factor& f : all[a]) {
        if (f.shape != Shape::kDecay && f.shape != Shape::kBump) continue;
        for (const Factor& w : guess.waves)
          if (w.symbol == guess.symbols[b] && w.other < 0) terms.push_back({{f, w}});
      }
    }
  for (std::size_t a = 0; a < n; ++a)
    for (std::size_t b = a + 1; b < n; ++b) {
      for (const Factor& f : sumShapes(view.symbols, guess.symbols[a], guess.symbols[b]))
        terms.push_back({{f}});
      for (std::size_t c = b + 1; c < n; ++c)
        for (const Factor& f : simple[a])
          for (const Factor& g : simple[b])
            for (const Factor& h : simple[c]) terms.push_back({{f, g, h}});
    }
  for (const Factor& w : guess.waves)
    if (w.other >= 0) {
      terms.push_back({{w}});
      for (std::size_t a = 0; a < n; ++a)
        if (guess.symbols[a] != w.symbol && guess.symbols[a] != w.other)
          for (const Factor& f : simple[a]) terms.push_back({{f, w}});
    }
  return terms;
}

/// Columns of many terms that share their factors, data rows only: each factor is evaluated once.
Eigen::MatrixXd columnsOf(const FormulaView& view, int direction, const std::vector<Term>& terms) {
  using Key = std::tuple<int, int, int, double, double, double>;
  std::map<Key, Eigen::MatrixXd> known;
  const auto valuesOf = [&](const Factor& f) -> const Eigen::MatrixXd& {
    const Key key{static_cast<int>(f.shape), f.symbol, f.other, f.slope, f.constants[0], f.constants[1]};
    const auto at = known.find(key);
    if (at != known.end()) return at->second;
    return known[key] = Term{{f}}.values(view.symbols, view.rows);
  };
  int count = 0;
  for (const Term& t : terms) count += t.coefficients();
  Eigen::MatrixXd out(view.rows, count);
  int at = 0;
  for (const Term& t : terms) {
    const int n = t.coefficients();
    for (int k = 0; k < n; ++k) {
      out.col(at) = view.factors.col(direction);
      for (const Factor& f : t.factors) {
        const Eigen::MatrixXd& v = valuesOf(f);
        out.col(at).array() *= v.col(v.cols() > 1 ? k : 0).array();
      }
      ++at;
    }
  }
  return out;
}

double priceOf(const FormulaView& view, const std::vector<Term>& terms) {
  std::set<int> symbols;
  double price = 0.0;
  for (const Term& t : terms) {
    price += view.priceOf(t);
    for (const Factor& f : t.factors) {
      symbols.insert(f.symbol);
      if (f.other >= 0) symbols.insert(f.other);
    }
  }
  return price + view.priceOfChoice(symbols);
}

/// Terms hang together by the symbols that they share: what does not is two causes, and not one formula.
bool oneCause(const std::vector<Term>& terms) {
  std::set<int> reached;
  std::vector<bool> in(terms.size(), false);
  const auto touches = [&](const Term& t) {
    return std::any_of(t.factors.begin(), t.factors.end(), [&](const Factor& f) {
      return reached.count(f.symbol) > 0 || (f.other >= 0 && reached.count(f.other) > 0);
    });
  };
  for (bool grown = true; grown;) {
    grown = false;
    for (std::size_t t = 0; t < terms.size(); ++t) {
      if (in[t] || (!reached.empty() && !terms[t].factors.empty() && !touches(terms[t]))) continue;
      in[t] = grown = true;
      for (const Factor& f : terms[t].factors) {
        reached.insert(f.symbol);
        if (f.other >= 0) reached.insert(f.other);
      }
    }
  }
  return std::all_of(in.begin(), in.end(), [](bool b) { return b; });
}

/// Chooses from the dictionary of one guess.
class Fitter {
 public:
  Fitter(const FormulaView& view, const FormulaGuess& guess)
      : view_(view), direction_(guess.direction), terms_(dictionaryOf(view, guess)) {
    raw_.resize(view.rows, 0);
    int count = 0;
    for (const Term& t : terms_) {
      first_.push_back(count);
      count += t.coefficients();
    }
    raw_ = columnsOf(view, direction_, terms_);
    for (int k = 0; k < raw_.cols(); ++k)
      if (!raw_.col(k).allFinite()) raw_.col(k).setZero();
    total_ = raw_.colwise().squaredNorm();
    const Eigen::MatrixXd data = view.basis.topRows(view.rows);
    room_ = total_ - (data.transpose() * raw_).colwise().squaredNorm().transpose();
  }

  /// Formulas grown from the terms that explain most alone, one of a kind. @param from, to which of them.
  std::vector<FittedFormula> run(std::size_t from, std::size_t to) const {
    std::vector<FittedFormula> out;
    std::set<std::vector<std::pair<int, int>>> kinds;
    for (const auto& one : ranked(view_.left, Eigen::MatrixXd(view_.length(), 0), view_.rss, 0.0)) {
      const int t = one.second;
      if (terms_[t].factors.empty()) continue;  // a constant is no cause
      std::vector<std::pair<int, int>> kind;
      for (const Factor& f : terms_[t].factors) kind.emplace_back(static_cast<int>(f.shape), f.symbol);
      if (!kinds.insert(kind).second) continue;
      if (kinds.size() > to) break;
      if (kinds.size() > from) out.push_back(grow(terms_[t]));
    }
    return out;
  }

 private:
  /// Terms by what they add, best first; a few.
  std::vector<std::pair<double, int>> ranked(const Eigen::VectorXd& left, const Eigen::MatrixXd& basis,
                                             double rss, double price) const {
    const Eigen::VectorXd score = raw_.transpose() * left.head(view_.rows);
    Eigen::VectorXd room = room_;
    if (basis.cols() > 0)
      room -= (basis.topRows(view_.rows).transpose() * raw_).colwise().squaredNorm().transpose();
    std::vector<std::pair<double, int>> order;
    for (std::size_t t = 0; t < terms_.size(); ++t) {
      const int k = first_[t];
      double drop = 0.0;
      for (int c = 0; c < terms_[t].coefficients(); ++c)  // sine and cosine are nearly orthogonal
        if (room[k + c] > 1e-4 * total_[k + c]) drop += score[k + c] * score[k + c] / room[k + c];
      order.emplace_back(view_.misfit(std::max(rss - drop, 1e-3 * rss)) + price + view_.priceOf(terms_[t]),
                         static_cast<int>(t));
    }
    const std::size_t kept = std::min<std::size_t>(60, order.size());
    std::partial_sort(order.begin(), order.begin() + static_cast<long>(kept), order.end());
    order.resize(kept);
    return order;
  }

  FittedFormula grow(const Term& first) const {
    FittedFormula f;
    f.direction = direction_;
    f.terms = {first};
    Solved now = improve(f.terms, 0);
    double objective = objectiveOf(now, f.terms);
    while (f.terms.size() < kMostTerms && now.rss < 1e299) {
      const auto order = ranked(now.left, now.basis, now.rss, priceOf(view_, f.terms));
      std::vector<Term> more = f.terms;
      for (const auto& [promised, t] : order) {
        if (promised > objective) break;
        more.push_back(terms_[t]);
        if (oneCause(more)) break;
        more.pop_back();
      }
      if (more.size() == f.terms.size()) break;
      const Solved next = improve(more, more.size() - 1);
      const double o = objectiveOf(next, more);
      if (!(o < objective - kWorthIt)) break;
      f.terms = more;
      now = next;
      objective = o;
    }
    shorten(f, now);
    return f;
  }

  Solved improve(std::vector<Term>& terms, std::size_t last) const {
    Solved best = solve(view_, direction_, terms);
    scanJumps(view_, direction_, terms, last, 0.075, best);
    best = fitConstants(view_, direction_, terms);
    if (std::none_of(terms[last].factors.begin(), terms[last].factors.end(),
                     [](const Factor& f) { return f.shape == Shape::kAfter; }))
      return best;
    scanJumps(view_, direction_, terms, last, 0.02, best);
    return fitConstants(view_, direction_, terms);
  }

  double objectiveOf(const Solved& s, const std::vector<Term>& terms) const {
    return view_.misfit(s.rss) + priceOf(view_, terms);
  }

  /// Without the terms, or halves of waves, that do not pay or whose loss hardly shows.
  void shorten(FittedFormula& f, Solved now) const {
    const double full = now.rss;
    for (bool again = true; again;) {
      again = false;
      double best = 1e300;
      std::vector<Term> chosen;
      Solved left;
      const auto consider = [&](const std::vector<Term>& terms) {
        if (std::all_of(terms.begin(), terms.end(), [](const Term& t) { return t.factors.empty(); }) ||
            !oneCause(terms))
          return;
        const Solved s = solve(view_, direction_, terms);
        const double o = objectiveOf(s, terms);
        if ((s.rss < kAsGood * full || o < objectiveOf(now, f.terms)) && o < best) {
          best = o;
          chosen = terms;
          left = s;
        }
      };
      for (std::size_t i = 0; i < f.terms.size(); ++i) {
        std::vector<Term> terms = f.terms;
        if (terms[i].waves() && terms[i].sine && terms[i].cosine) {
          terms[i].sine = false;
          consider(terms);
          terms[i].sine = true;
          terms[i].cosine = false;
          consider(terms);
        }
        terms = f.terms;
        terms.erase(terms.begin() + static_cast<long>(i));
        consider(terms);
      }
      if (chosen.empty()) break;
      f.terms = chosen;
      now = fitConstants(view_, direction_, f.terms);
      again = true;
    }
    for (Term& t : f.terms) t = t.rounded();
    now = solve(view_, direction_, f.terms);
    f.rss = now.rss;
    f.price = priceOf(view_, f.terms);
    f.objective = view_.misfit(f.rss) + f.price;
  }

  const FormulaView& view_;
  int direction_;
  std::vector<Term> terms_;
  std::vector<int> first_;
  Eigen::MatrixXd raw_;
  Eigen::VectorXd total_, room_;
};

}  // namespace

int FittedFormula::unknowns() const {
  int n = 0;
  for (const Term& t : terms) n += t.coefficients() + t.constants();
  return n;
}

std::vector<FittedFormula> fitFormulas(const FormulaView& view, const FormulaGuess& guess, std::size_t from,
                                       std::size_t to) {
  return Fitter(view, guess).run(from, to);
}

FittedFormula refit(const FormulaView& view, FittedFormula f) {
  fitConstants(view, f.direction, f.terms);
  for (Term& t : f.terms) t = t.rounded();
  f.rss = solve(view, f.direction, f.terms).rss;
  f.price = priceOf(view, f.terms);
  f.objective = view.misfit(f.rss) + f.price;
  return f;
}

}  // namespace mm
