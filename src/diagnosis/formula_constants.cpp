#include "diagnosis/formula_constants.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace mm {
namespace {

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

}  // namespace

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

void scanJumps(const FormulaView& view, int direction, std::vector<Term>& terms, std::size_t term,
               double share, Solved& best) {
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

}  // namespace mm
