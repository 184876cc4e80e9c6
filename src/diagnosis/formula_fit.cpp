#include "diagnosis/formula_fit.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <tuple>

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

/// Projected columns of terms, their orthonormal basis and what they leave.
struct Solved {
  Eigen::MatrixXd basis;
  Eigen::VectorXd left;
  Eigen::VectorXd coefficients;
  double rss = 1e300;
};

Solved solve(const FormulaView& view, int direction, const std::vector<Term>& terms) {
  Solved s;
  Eigen::MatrixXd c = view.columns(direction, terms);
  if (!c.allFinite()) return s;
  view.project(c);
  const Eigen::VectorXd size = c.colwise().norm().transpose().cwiseMax(1e-300);
  c = c * size.cwiseInverse().asDiagonal();
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(c);
  qr.setThreshold(1e-7);
  s.coefficients = qr.solve(view.left).cwiseQuotient(size);
  s.basis = qr.householderQ() * Eigen::MatrixXd::Identity(c.rows(), qr.rank());
  s.left = view.left - s.basis * (s.basis.transpose() * view.left);
  s.rss = s.left.squaredNorm();
  return s;
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

/// Keeps a constant where it means something.
void clamp(const std::vector<Symbol>& symbols, const Factor& start, Factor& f) {
  double low = symbols[f.symbol].low, high = symbols[f.symbol].high;
  if (f.other >= 0) {
    const double a = f.slope * symbols[f.other].low, b = f.slope * symbols[f.other].high;
    low += std::min(a, b);
    high += std::max(a, b);
  }
  const double range = high - low;
  f.slope = std::clamp(f.slope, -10.0, 10.0);
  double &c = f.constants[0], &w = f.constants[1];
  const double was = start.constants[0];
  switch (f.shape) {
    case Shape::kWave:
      c = std::clamp(c, 0.7 * was, 1.4 * was);
      break;
    case Shape::kDecay:
      c = was > 0.0 ? std::clamp(c, 0.02 * range, 3.0 * range) : std::clamp(c, -3.0 * range, -0.02 * range);
      break;
    case Shape::kPower:
      c = std::clamp(c, 0.2, 5.0);
      break;
    case Shape::kStribeck:
      c = std::clamp(c, 0.02 * range, 2.0 * range);
      break;
    case Shape::kOffset:
      c = std::clamp(c, low - 3.0 * range, high + 3.0 * range);
      break;
    default:
      c = std::clamp(c, low - 0.1 * range, high + 0.1 * range);
      w = std::clamp(w, 0.01 * range, 2.0 * range);
  }
}

double scaleOf(const FormulaView& view, const Factor& f, int constant) {
  if (f.freeSlope && constant + 1 == f.fittedCount()) return 1.0;
  if (f.shape == Shape::kPower) return 1.0;
  return f.shape == Shape::kWave || f.shape == Shape::kDecay || f.shape == Shape::kStribeck
             ? std::abs(f.constants[0])
             : view.symbols[f.symbol].range();
}

/// Shapes whose place acts from datum to datum: there is no slope to follow.
bool jumps(Shape shape) { return shape == Shape::kStep || shape == Shape::kAfter; }

/// Constants that jump from datum to datum are scanned before the others are fitted.
void scan(const FormulaView& view, int direction, std::vector<Term>& terms, std::size_t term, double share,
          Solved& best) {
  constexpr int kLooks = 16;
  for (std::size_t k = 0; k < terms[term].factors.size(); ++k) {
    const Factor start = terms[term].factors[k];
    if (!jumps(start.shape)) continue;
    const double range = view.symbols[start.symbol].range();
    Factor chosen = start;
    for (int look = -kLooks; look <= kLooks; ++look) {
      Factor& f = terms[term].factors[k];
      f = start;
      f.constants[0] += share * range * look / kLooks;
      const Solved now = solve(view, direction, terms);
      if (now.rss < best.rss) {
        best = now;
        chosen = f;
      }
    }
    terms[term].factors[k] = chosen;
  }
}

/// Gauss-Newton on the constants of all terms; the coefficients are solved for at each step (variable
/// projection).
Solved fitConstants(const FormulaView& view, int direction, std::vector<Term>& terms) {
  const std::vector<Term> start = terms;
  Solved best = solve(view, direction, terms);
  struct Place {
    std::size_t term, factor;
    int constant;
  };
  std::vector<Place> places;
  for (std::size_t t = 0; t < terms.size(); ++t)
    for (std::size_t f = 0; f < terms[t].factors.size(); ++f)
      for (int c = 0; c < terms[t].factors[f].fittedCount(); ++c)
        if (c > 0 || !jumps(terms[t].factors[f].shape)) places.push_back({t, f, c});
  if (places.empty() || !std::isfinite(best.rss) || best.coefficients.size() == 0) return best;
  const int n = static_cast<int>(places.size());
  double damping = 1e-3;
  for (int round = 0; round < 12; ++round) {
    Eigen::MatrixXd slopes(view.length(), n);
    Eigen::VectorXd step(n);
    for (int i = 0; i < n; ++i) {
      const Place& p = places[i];
      Term one = terms[p.term];
      const double h = 1e-4 * scaleOf(view, one.factors[p.factor], p.constant);
      step[i] = h;
      int at = 0;
      for (std::size_t t = 0; t < p.term; ++t) at += terms[t].coefficients();
      const Eigen::VectorXd k = best.coefficients.segment(at, one.coefficients());
      *one.factors[p.factor].fitted()[p.constant] += h;
      const Eigen::VectorXd up = view.columns(direction, {one}) * k;
      *one.factors[p.factor].fitted()[p.constant] -= 2.0 * h;
      slopes.col(i) = (up - view.columns(direction, {one}) * k) / 2.0;  // a step of h
    }
    if (!slopes.allFinite()) break;
    view.project(slopes);
    slopes -= best.basis * (best.basis.transpose() * slopes);
    Eigen::MatrixXd normal = slopes.transpose() * slopes;
    for (int i = 0; i < n; ++i)  // what the coefficients do as well stays
      if (normal(i, i) < 1e-12 * best.rss) normal(i, i) = best.rss;
    const Eigen::VectorXd right = slopes.transpose() * best.left;
    bool moved = false;
    for (int attempt = 0; attempt < 4 && !moved; ++attempt) {
      Eigen::MatrixXd damped = normal;
      damped.diagonal() += damping * normal.diagonal() + Eigen::VectorXd::Constant(n, 1e-300);
      const Eigen::VectorXd move = damped.ldlt().solve(right).cwiseProduct(step);
      std::vector<Term> next = terms;
      for (int i = 0; i < n; ++i)
        *next[places[i].term].factors[places[i].factor].fitted()[places[i].constant] += move[i];
      for (std::size_t t = 0; t < next.size(); ++t)
        for (std::size_t f = 0; f < next[t].factors.size(); ++f)
          clamp(view.symbols, start[t].factors[f], next[t].factors[f]);
      const Solved now = solve(view, direction, next);
      if (now.rss < best.rss) {
        moved = now.rss < best.rss * (1.0 - 3e-4);
        best = now;
        terms = next;
        damping = std::max(1e-9, damping * 0.2);
        if (!moved) return best;
      } else {
        damping *= 8.0;
      }
    }
    if (!moved) break;
  }
  return best;
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
    scan(view_, direction_, terms, last, 0.075, best);
    best = fitConstants(view_, direction_, terms);
    if (std::none_of(terms[last].factors.begin(), terms[last].factors.end(),
                     [](const Factor& f) { return f.shape == Shape::kAfter; }))
      return best;
    scan(view_, direction_, terms, last, 0.02, best);
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
