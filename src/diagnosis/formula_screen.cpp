#include "diagnosis/formula_screen.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <complex>
#include <map>

#include "machine/units.h"

namespace mm {
namespace {

using Kind = Symbol::Kind;

constexpr double kShape = 2.8;  // as in FormulaView::priceOf
constexpr int kMostTerms = 4;

/// Smooth functions of one symbol: Legendre polynomials, or what speeds do; the first three are used in
/// products.
Eigen::MatrixXd smooth(const Symbol& s) {
  Eigen::ArrayXd u = (s.values - s.middle()) / (0.5 * s.range());
  if (s.kind == Kind::kSpeed && s.low < 0.0 && s.high > 0.0) {
    const double top = std::max(s.high, -s.low);
    u = s.values / top;
    Eigen::MatrixXd out(u.size(), s.distinct > 2 ? 5 : 1);
    out.col(0) = u.sign();
    if (s.distinct > 2) {
      out.col(1) = u;
      out.col(2) = u.abs();
      out.col(3) = u.square();
      out.col(4) = u.sign() * u.abs().sqrt();
    }
    return out;
  }
  const int order = std::min(s.kind == Kind::kPosition ? 5 : 4, s.distinct - 1);
  Eigen::MatrixXd out(u.size(), order);
  Eigen::ArrayXd before = Eigen::ArrayXd::Ones(u.size()), now = u;
  for (int k = 1; k <= order; ++k) {
    out.col(k - 1) = now;
    const Eigen::ArrayXd next = ((2 * k + 1) * u * now - k * before) / (k + 1);
    before = now;
    now = next;
  }
  return out;
}

/// Steps, kinks and recoveries along a symbol, which no low polynomial follows.
Eigen::MatrixXd sudden(const Symbol& s) {
  constexpr int kFewValues = 9, kPlaces = 13;
  const bool may = s.kind == Kind::kPosition || s.kind == Kind::kTime || s.kind == Kind::kTemperature ||
                   s.kind == Kind::kCovariate || s.kind == Kind::kTipSpeed;
  if (!may || s.distinct < kFewValues) return Eigen::MatrixXd(s.values.size(), 0);
  Eigen::MatrixXd out(s.values.size(), 4 * kPlaces);
  for (int k = 0; k < kPlaces; ++k) {
    const Eigen::ArrayXd from = s.values - (s.low + s.range() * (k + 1) / (kPlaces + 1.0));
    out.col(4 * k) = (from > 0.0).cast<double>();
    out.col(4 * k + 1) = from.abs();
    out.col(4 * k + 2) = (from > 0.0).select((-from.max(0.0) / (0.15 * s.range())).exp(), 0.0);
    out.col(4 * k + 3) = (-(from / (0.1 * s.range())).square()).exp();
  }
  return out;
}

/// Groups of columns of a matrix, one a choice of symbols.
struct Block {
  std::vector<int> symbols;
  std::vector<int> columns;
  std::vector<int> factors;  // a column: how many shapes it is a product of
};

/// All smooth columns and their groups.
struct Book {
  Eigen::MatrixXd values;  // rows x columns
  std::vector<Block> blocks;
};

bool pairs(const Symbol& a, const Symbol& b) {
  const auto position = [](const Symbol& s) { return s.kind == Kind::kPosition; };
  const auto derived = [](const Symbol& s) {
    return s.kind == Kind::kDifference || s.kind == Kind::kTipSpeed || s.kind == Kind::kWay;
  };
  if (derived(a) || derived(b)) return position(a) || position(b);
  return true;
}

Book makeBook(const std::vector<Symbol>& symbols, int rows) {
  constexpr int kInProducts = 3;
  Book book;
  std::vector<Eigen::VectorXd> all;
  const int n = static_cast<int>(symbols.size());
  std::vector<Eigen::MatrixXd> shapes(n);
  std::vector<std::vector<int>> own(n);
  const auto put = [&](Eigen::VectorXd c) {
    all.push_back(std::move(c));
    return static_cast<int>(all.size()) - 1;
  };
  for (int s = 0; s < n; ++s) {
    shapes[s] = smooth(symbols[s]);
    Block block;
    block.symbols = {s};
    for (int k = 0; k < shapes[s].cols(); ++k) {
      own[s].push_back(put(shapes[s].col(k)));
      block.columns.push_back(own[s].back());
      block.factors.push_back(1);
    }
    const Eigen::MatrixXd more = sudden(symbols[s]);
    for (int k = 0; k < more.cols(); ++k) {
      block.columns.push_back(put(more.col(k)));
      block.factors.push_back(1);
    }
    book.blocks.push_back(block);
  }
  const auto single = [&](int s) {
    return symbols[s].kind != Kind::kDifference && symbols[s].kind != Kind::kTipSpeed &&
           symbols[s].kind != Kind::kWay;
  };
  for (int a = 0; a < n; ++a)
    for (int b = a + 1; b < n; ++b) {
      if (!pairs(symbols[a], symbols[b])) continue;
      Block block;
      block.symbols = {a, b};
      for (int s : {a, b})
        for (int c : own[s]) {
          block.columns.push_back(c);
          block.factors.push_back(1);
        }
      for (int i = 0; i < std::min<int>(kInProducts, shapes[a].cols()); ++i)
        for (int j = 0; j < std::min<int>(kInProducts, shapes[b].cols()); ++j) {
          block.columns.push_back(put(shapes[a].col(i).cwiseProduct(shapes[b].col(j))));
          block.factors.push_back(2);
        }
      book.blocks.push_back(block);
      if (!single(a) || !single(b)) continue;
      for (int c = b + 1; c < n; ++c) {
        if (!single(c)) continue;
        Block triple;
        triple.symbols = {a, b, c};
        triple.columns = {
            put(shapes[a].col(0).cwiseProduct(shapes[b].col(0)).cwiseProduct(shapes[c].col(0)))};
        triple.factors = {3};
        book.blocks.push_back(triple);
      }
    }
  book.values.resize(rows, all.size());
  for (std::size_t k = 0; k < all.size(); ++k) book.values.col(static_cast<int>(k)) = all[k];
  return book;
}

/// Forward choice within one block, from Gram matrices.
double objectiveOf(const FormulaView& view, const Block& block, Eigen::MatrixXd gram, Eigen::VectorXd score) {
  const double unknown = 0.5 * std::log(view.dof);
  double rss = view.rss, price = view.priceOfChoice(block.symbols);
  double objective = 1e300;
  Eigen::VectorXd room = gram.diagonal();
  for (int step = 0; step < kMostTerms; ++step) {
    int best = -1;
    double now = objective;
    for (int k = 0; k < score.size(); ++k) {
      if (!(gram(k, k) > 1e-3 * room[k]) || !(room[k] > 0.0)) continue;
      const double o =
          view.misfit(rss - score[k] * score[k] / gram(k, k)) + price + unknown + kShape * block.factors[k];
      if (o < now) now = o, best = k;
    }
    if (best < 0) break;
    objective = now;
    price += unknown + kShape * block.factors[best];
    rss -= score[best] * score[best] / gram(best, best);
    const Eigen::VectorXd column = gram.col(best) / gram(best, best);
    score -= column * score[best];
    gram -= column * gram.row(best).eval();
  }
  return objective;
}

void screenSmooth(const FormulaView& view, std::vector<FormulaGuess>& guesses) {
  const Book book = makeBook(view.symbols, view.rows);
  const Eigen::MatrixXd data = view.basis.topRows(view.rows);
  for (int d = 0; d < static_cast<int>(view.directions.size()); ++d) {
    const Eigen::MatrixXd raw = view.factors.col(d).asDiagonal() * book.values;
    const Eigen::MatrixXd absorbed = data.transpose() * raw;
    const Eigen::VectorXd score = raw.transpose() * view.left.head(view.rows);
    const Eigen::VectorXd total = raw.colwise().squaredNorm();
    for (const Block& block : book.blocks) {
      const int n = static_cast<int>(block.columns.size());
      FormulaGuess guess;
      guess.direction = d;
      guess.symbols = block.symbols;
      // what the columns could explain at the very most decides whether to look closer
      const Eigen::MatrixXd c = raw(Eigen::all, block.columns), w = absorbed(Eigen::all, block.columns);
      Eigen::MatrixXd gram = c.transpose() * c - w.transpose() * w;
      Eigen::VectorXd s(n);
      for (int k = 0; k < n; ++k) {
        s[k] = score[block.columns[k]];
        if (gram(k, k) < 1e-6 * total[block.columns[k]]) gram(k, k) = -1.0;  // absorbed
      }
      guess.objective = objectiveOf(view, block, gram, s);
      guesses.push_back(std::move(guess));
    }
  }
}

/// An argument of waves.
struct Phase {
  std::vector<int> symbols;
  Factor factor;
  Eigen::ArrayXd values;
  double range = 0.0;
  int most = 0;  // waves
};

std::vector<Phase> phasesOf(const std::vector<Symbol>& symbols) {
  constexpr int kFewValues = 9;
  std::vector<Phase> phases;
  for (int a = 0; a < static_cast<int>(symbols.size()); ++a) {
    const Symbol& s = symbols[a];
    const bool may = s.kind == Kind::kPosition || s.kind == Kind::kTime || s.kind == Kind::kTemperature ||
                     s.kind == Kind::kCovariate;
    if (!may || s.distinct < kFewValues) continue;
    Phase p;
    p.symbols = {a};
    p.factor.shape = Shape::kWave;
    p.factor.symbol = a;
    p.values = s.values;
    p.range = s.range();
    p.most = std::min(s.kind == Kind::kPosition ? 240 : s.kind == Kind::kTime ? 60 : 8, s.distinct / 3);
    phases.push_back(p);
    if (s.kind != Kind::kPosition) continue;
    for (int b = a + 1; b < static_cast<int>(symbols.size()); ++b) {
      if (symbols[b].kind != Kind::kPosition || symbols[b].unit != s.unit || symbols[b].distinct < kFewValues)
        continue;
      for (double slope : {1.0, -1.0}) {
        Phase sum = p;
        sum.symbols = {a, b};
        sum.factor.other = b;
        sum.factor.slope = slope;
        sum.values = s.values + slope * symbols[b].values;
        sum.range = sum.values.maxCoeff() - sum.values.minCoeff();
        sum.most = 40;
        phases.push_back(sum);
      }
    }
  }
  return phases;
}

/// Waves, constant or growing with another symbol. Of fast waves the model absorbs next to nothing: their
/// columns are not projected here.
void screenWaves(const FormulaView& view, std::vector<FormulaGuess>& guesses) {
  constexpr double kStep = 0.25;  // waves
  const int n = view.rows, directions = static_cast<int>(view.directions.size());
  const double unknown = 0.5 * std::log(view.dof);
  struct Amplitude {
    int symbol;
    Eigen::ArrayXd values;
  };
  std::vector<Amplitude> amplitudes{{-1, Eigen::ArrayXd::Ones(n)}};
  for (int s = 0; s < static_cast<int>(view.symbols.size()); ++s)
    if (view.symbols[s].kind != Kind::kDifference && view.symbols[s].kind != Kind::kWay &&
        view.symbols[s].kind != Kind::kTipSpeed)
      amplitudes.push_back({s, smooth(view.symbols[s]).col(0).array()});
  const int count = static_cast<int>(amplitudes.size());
  Eigen::MatrixXd seen(n, directions * count);
  Eigen::VectorXd norm(directions * count);
  for (int d = 0; d < directions; ++d)
    for (int a = 0; a < count; ++a) {
      const Eigen::ArrayXd f = view.factors.col(d).array() * amplitudes[a].values;
      seen.col(d * count + a) = f * view.left.head(n).array();
      norm[d * count + a] = 0.5 * f.square().sum();
    }
  for (const Phase& phase : phasesOf(view.symbols)) {
    const int steps = static_cast<int>((phase.most - 1.0) / kStep);
    if (steps < 1) continue;
    Eigen::MatrixXd sine(n, steps), cosine(n, steps);
    for (int i = 0; i < n; ++i) {
      const double u = 2.0 * kPi * phase.values[i] / phase.range;
      std::complex<double> at = std::polar(1.0, u);
      const std::complex<double> turn = std::polar(1.0, u * kStep);
      for (int k = 0; k < steps; ++k) {
        sine(i, k) = at.imag();
        cosine(i, k) = at.real();
        at *= turn;
      }
    }
    const Eigen::MatrixXd power =
        (sine.transpose() * seen).cwiseAbs2() + (cosine.transpose() * seen).cwiseAbs2();  // steps x seen
    for (int d = 0; d < directions; ++d)
      for (int a = 0; a < count; ++a) {
        const int symbol = amplitudes[a].symbol, at = d * count + a;
        if (std::count(phase.symbols.begin(), phase.symbols.end(), symbol) > 0 || !(norm[at] > 0.0)) continue;
        int best = 0;
        power.col(at).maxCoeff(&best);
        const double drop = std::min(0.999 * view.rss, power(best, at) / norm[at]);
        FormulaGuess guess;
        guess.direction = d;
        guess.symbols = phase.symbols;
        if (symbol >= 0) guess.symbols.push_back(symbol);
        std::sort(guess.symbols.begin(), guess.symbols.end());
        Factor wave = phase.factor;
        wave.constants[0] = phase.range / (1.0 + kStep * best);
        guess.waves = {wave};
        guess.objective = view.misfit(view.rss - drop) + view.priceOfChoice(guess.symbols) + 3.0 * unknown +
                          1.0 + kShape * (symbol >= 0 ? 2.0 : 1.0);
        guesses.push_back(std::move(guess));
      }
  }
}

}  // namespace

std::vector<FormulaGuess> screenFormulas(const FormulaView& view, int count) {
  std::vector<FormulaGuess> all;
  screenSmooth(view, all);
  screenWaves(view, all);
  std::stable_sort(all.begin(), all.end(),
                   [](const FormulaGuess& a, const FormulaGuess& b) { return a.objective < b.objective; });
  constexpr std::size_t kMostWaves = 3;
  constexpr double kHopeless = 40.0;  // beyond nothing at all
  std::vector<FormulaGuess> out;
  for (FormulaGuess& g : all) {
    if (g.objective > view.misfit() + kHopeless) break;
    const auto same = std::find_if(out.begin(), out.end(), [&](const FormulaGuess& o) {
      return o.direction == g.direction && o.symbols == g.symbols;
    });
    if (same != out.end()) {
      if (same->waves.size() < kMostWaves)
        same->waves.insert(same->waves.end(), g.waves.begin(), g.waves.end());
    } else if (static_cast<int>(out.size()) < count) {
      out.push_back(std::move(g));
    }
  }
  return out;
}

}  // namespace mm
