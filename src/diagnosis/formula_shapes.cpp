#include "diagnosis/formula_shapes.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "machine/units.h"

namespace mm {
namespace {

constexpr int kFewValues = 9;  // with fewer distinct values a wave, a step or a decay is any profile

std::string number(double v) {
  char text[32];
  std::snprintf(text, sizeof text, "%.5g", v);
  return text;
}

double printed(double v) { return std::strtod(number(v).c_str(), nullptr); }

bool crossesZero(const Symbol& s) { return s.low < 0.0 && s.high > 0.0; }

Eigen::ArrayXd argument(const std::vector<Symbol>& symbols, const Factor& f) {
  if (f.other < 0) return symbols[f.symbol].values;
  return symbols[f.symbol].values + f.slope * symbols[f.other].values;
}

Eigen::ArrayXd valuesOf(const std::vector<Symbol>& symbols, const Factor& f) {
  const Eigen::ArrayXd u = argument(symbols, f);
  const double c = f.constants[0], w = f.constants[1];
  switch (f.shape) {
    case Shape::kLinear:
      return u;
    case Shape::kOffset:
      return u - c;
    case Shape::kSquare:
      return u.square();
    case Shape::kCube:
      return u.cube();
    case Shape::kAbs:
      return u.abs();
    case Shape::kSign:
      return u.sign();
    case Shape::kRoot:
      return u.sign() * u.abs().sqrt();
    case Shape::kFold:
      return (u - c).abs();
    case Shape::kStep:
      return (u > c).cast<double>();
    case Shape::kHinge:
      return (u - c).max(0.0);
    case Shape::kRamp:
      return ((u - c) / w).tanh();
    case Shape::kBump:
      return (-((u - c) / w).square()).exp();
    case Shape::kPeak:
      return 1.0 / (1.0 + ((u - c) / w).square());
    case Shape::kBend:
      return ((u - c).square() + w * w).sqrt();
    case Shape::kAfter:
      return (u > c).select((-(u - c).max(0.0) / w).exp(), 0.0);
    case Shape::kDecay:
      return ((u - w) / c).min(50.0).exp();
    case Shape::kPower:
      return (u - w).max(0.0).pow(c);
    case Shape::kStribeck:
      return u.sign() * (-(u / c).square()).exp();
    default:
      return (2.0 * kPi / c * u).sin();
  }
}

std::string less(const std::string& text, double c) {
  return c < 0.0 ? text + "+" + number(-c) : text + "-" + number(c);
}

std::string textOf(const std::vector<Symbol>& symbols, const Factor& f, bool cosine) {
  const Symbol& s = symbols[f.symbol];
  std::string u = s.text, bare = s.bare;
  double zero = s.zero;
  if (f.other >= 0) {
    const std::string size = number(std::abs(f.slope));
    u = bare = s.text + (f.slope < 0.0 ? "-" : "+") + (size == "1" ? "" : size + "*") + symbols[f.other].text;
    zero = 0.0;
  }
  const std::string in = f.other >= 0 ? "(" + u + ")" : u;
  const std::string from = less(bare, f.constants[0] + zero), w = number(f.constants[1]);
  switch (f.shape) {
    case Shape::kLinear:
      return in;
    case Shape::kOffset:
      return "(" + from + ")";
    case Shape::kSquare:
      return in + "^2";
    case Shape::kCube:
      return in + "^3";
    case Shape::kAbs:
      return "abs(" + u + ")";
    case Shape::kSign:
      return "sign(" + u + ")";
    case Shape::kRoot:
      return crossesZero(s) || f.other >= 0 ? "sign(" + u + ")*sqrt(abs(" + u + "))" : "sqrt(abs(" + u + "))";
    case Shape::kFold:
      return "abs(" + from + ")";
    case Shape::kStep:
      return "(" + bare + ">" + number(f.constants[0] + zero) + ")";
    case Shape::kHinge:
      return "max(0," + from + ")";
    case Shape::kRamp:
      return "tanh((" + from + ")/" + w + ")";
    case Shape::kBump:
      return "exp(-((" + from + ")/" + w + ")^2)";
    case Shape::kPeak:
      return "1/(1+((" + from + ")/" + w + ")^2)";
    case Shape::kBend:
      return "sqrt((" + from + ")^2+" + w + "^2)";
    case Shape::kAfter:
      return "(" + bare + ">" + number(f.constants[0] + zero) + ")*exp(-max(0," + from + ")/" + w + ")";
    case Shape::kDecay:
      return "exp((" + less(bare, f.constants[1] + zero) + ")/" + "(" + number(f.constants[0]) + "))";
    case Shape::kPower:
      return "max(0," + less(bare, f.constants[1] + zero) + ")^" + number(f.constants[0]);
    case Shape::kStribeck:
      return "sign(" + u + ")*exp(-(" + u + "/" + number(f.constants[0]) + ")^2)";
    default:
      return (cosine ? "cos(2*pi*" : "sin(2*pi*") + in + "/" + number(f.constants[0]) + ")";
  }
}

Factor make(Shape shape, int symbol, double c = 0.0, double w = 0.0) {
  Factor f;
  f.shape = shape;
  f.symbol = symbol;
  f.constants = {c, w};
  return f;
}

/// Shapes with constants, for an argument of a given range.
void addGrid(std::vector<Factor>& out, Factor base, double low, double high) {
  const double range = high - low;
  const auto add = [&](Shape shape, double c, double w = 0.0) {
    base.shape = shape;
    base.constants = {c, w};
    out.push_back(base);
  };
  for (int k = 1; k <= 13; ++k) {
    const double c = low + range * k / 14.0;
    add(Shape::kFold, c);
    add(Shape::kStep, c);
    add(Shape::kHinge, c);
    for (double w : {0.06, 0.18}) add(Shape::kRamp, c, w * range);
    for (double w : {0.05, 0.12, 0.3}) add(Shape::kBump, c, w * range);
    if (k % 2 == 1) continue;
    for (double w : {0.06, 0.2}) add(Shape::kPeak, c, w * range);
    add(Shape::kBend, c, 0.1 * range);
    for (double w : {0.08, 0.25}) add(Shape::kAfter, c, w * range);
  }
  for (double tau : {0.05, 0.12, 0.3, 0.8}) {
    add(Shape::kDecay, tau * range, high);
    add(Shape::kDecay, -tau * range, low);
  }
  for (double waves = 0.5; waves <= 6.0; waves += 0.25) add(Shape::kWave, range / waves);
}

}  // namespace

std::vector<double*> Factor::fitted() {
  std::vector<double*> out;
  switch (shape) {
    case Shape::kRamp:
    case Shape::kBump:
    case Shape::kPeak:
    case Shape::kBend:
    case Shape::kAfter:
      out = {&constants[0], &constants[1]};
      break;
    case Shape::kOffset:
    case Shape::kFold:
    case Shape::kStep:
    case Shape::kHinge:
    case Shape::kDecay:
    case Shape::kPower:
    case Shape::kStribeck:
    case Shape::kWave:
      out = {&constants[0]};
      break;
    default:
      break;
  }
  if (freeSlope) out.push_back(&slope);
  return out;
}

int Factor::fittedCount() const {
  Factor copy = *this;
  return static_cast<int>(copy.fitted().size());
}

bool Term::waves() const {
  return std::any_of(factors.begin(), factors.end(), [](const Factor& f) { return f.shape == Shape::kWave; });
}

int Term::constants() const {
  int n = 0;
  for (const Factor& f : factors) n += f.fittedCount();
  return n;
}

Eigen::MatrixXd Term::values(const std::vector<Symbol>& symbols, int rows) const {
  Eigen::MatrixXd out(rows, coefficients());
  Eigen::ArrayXd product = Eigen::ArrayXd::Ones(rows);
  const Factor* wave = nullptr;
  for (const Factor& f : factors)
    if (f.shape == Shape::kWave)
      wave = &f;
    else
      product *= valuesOf(symbols, f);
  if (wave == nullptr) {
    out.col(0) = product;
    return out;
  }
  const Eigen::ArrayXd phase = 2.0 * kPi / wave->constants[0] * argument(symbols, *wave);
  int k = 0;
  if (sine) out.col(k++) = product * phase.sin();
  if (cosine) out.col(k) = product * phase.cos();
  return out;
}

std::vector<std::string> Term::texts(const std::vector<Symbol>& symbols) const {
  std::vector<std::string> out;
  for (int cosine = 0; cosine < 2; ++cosine) {
    if (waves() ? !(cosine ? this->cosine : sine) : cosine == 1) continue;
    std::string text;
    for (const Factor& f : factors) text += (text.empty() ? "" : "*") + textOf(symbols, f, cosine == 1);
    out.push_back(text);
  }
  return out;
}

Term Term::rounded() const {
  Term t = *this;
  for (Factor& f : t.factors) {
    for (double& c : f.constants) c = printed(c);
    f.slope = printed(f.slope);
  }
  return t;
}

std::vector<Factor> simpleShapes(const std::vector<Symbol>& symbols, int symbol) {
  const Symbol& s = symbols[symbol];
  std::vector<Factor> out{make(Shape::kLinear, symbol)};
  const bool speed = s.kind == Symbol::Kind::kSpeed;
  if (s.distinct > 2) out.push_back(make(Shape::kSquare, symbol));
  if (!speed) out.push_back(make(Shape::kOffset, symbol, s.middle()));
  if (crossesZero(s)) {
    out.push_back(make(Shape::kSign, symbol));
    if (s.distinct > 2) out.push_back(make(Shape::kAbs, symbol));
  }
  if (s.distinct > 3) {
    out.push_back(make(Shape::kCube, symbol));
    if (crossesZero(s) || s.low >= 0.0) out.push_back(make(Shape::kRoot, symbol));
  }
  return out;
}

std::vector<Factor> allShapes(const std::vector<Symbol>& symbols, int symbol) {
  const Symbol& s = symbols[symbol];
  std::vector<Factor> out = simpleShapes(symbols, symbol);
  if (s.kind == Symbol::Kind::kSpeed && crossesZero(s) && s.distinct > 4)
    for (double w : {0.1, 0.2, 0.4, 0.7})
      out.push_back(make(Shape::kStribeck, symbol, w * std::max(s.high, -s.low)));
  if (s.distinct < kFewValues) return out;
  addGrid(out, make(Shape::kFold, symbol), s.low, s.high);
  for (double p : {0.35, 0.7, 1.5, 2.5}) out.push_back(make(Shape::kPower, symbol, p, s.low));
  return out;
}

std::vector<Factor> sumShapes(const std::vector<Symbol>& symbols, int a, int b) {
  std::vector<Factor> out;
  if (symbols[a].unit != symbols[b].unit || symbols[a].kind != symbols[b].kind) return out;
  for (double slope : {1.0, -1.0, 0.4, -0.4, 2.5, -2.5}) {
    Factor f = make(Shape::kLinear, a);
    f.other = b;
    f.slope = slope;
    f.freeSlope = std::abs(slope) != 1.0;
    const Eigen::ArrayXd u = argument(symbols, f);
    const double low = u.minCoeff(), high = u.maxCoeff();
    if (!(high > low)) continue;
    for (Shape shape : {Shape::kSquare, Shape::kCube, Shape::kAbs, Shape::kSign}) {
      f.shape = shape;
      if (shape == Shape::kSquare || shape == Shape::kCube || (low < 0.0 && high > 0.0)) out.push_back(f);
    }
    if (std::min(symbols[a].distinct, symbols[b].distinct) < kFewValues) continue;
    addGrid(out, f, low, high);
  }
  return out;
}

}  // namespace mm
