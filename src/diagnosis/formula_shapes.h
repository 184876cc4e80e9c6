#pragma once
#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "diagnosis/formula_symbols.h"

namespace mm {

/// A function of one number, as machines show them: play, steps, cogging, saturation, resonance, recovery.
enum class Shape {
  kLinear,    // u
  kOffset,    // u - c
  kSquare,    // u^2
  kCube,      // u^3
  kAbs,       // |u|
  kSign,      // sign(u)
  kRoot,      // sign(u) sqrt|u|
  kFold,      // |u - c|
  kStep,      // 1 beyond c
  kHinge,     // u - c beyond c
  kRamp,      // tanh((u - c) / w)
  kBump,      // exp(-((u - c) / w)^2)
  kPeak,      // 1 / (1 + ((u - c) / w)^2)
  kBend,      // sqrt((u - c)^2 + w^2)
  kAfter,     // exp(-(u - c) / w) beyond c
  kDecay,     // exp((u - end) / w)
  kPower,     // (u - lowest)^p
  kStribeck,  // sign(u) exp(-(u / w)^2)
  kWave,      // sin and cos of 2 pi u / c, each with its factor
};

/// A shape of a symbol, or of the weighted sum of two.
struct Factor {
  Shape shape = Shape::kLinear;
  int symbol = 0;
  int other = -1;      // u = symbol + slope * other
  double slope = 1.0;  // kept at 1 or -1 unless `freeSlope`
  bool freeSlope = false;
  std::array<double, 2> constants{0.0, 0.0};  // c (period, p) and w, in the symbol's units

  /// Constants that are fitted, as pointers into this factor.
  std::vector<double*> fitted();
  int fittedCount() const;
};

/// A product of factors with one free coefficient, or two where one factor is a wave. Without factors: a
/// constant.
struct Term {
  std::vector<Factor> factors;
  bool sine = true, cosine = true;  // of a wave

  bool waves() const;
  int coefficients() const { return waves() ? int(sine) + int(cosine) : 1; }
  int constants() const;
  /// One column a coefficient; rows as in the symbols.
  Eigen::MatrixXd values(const std::vector<Symbol>& symbols, int rows) const;
  /// One text a coefficient, without the coefficient; empty for a constant.
  std::vector<std::string> texts(const std::vector<Symbol>& symbols) const;
  /// With the constants as the texts print them.
  Term rounded() const;
};

/// Shapes of one symbol without fitted constants, and with the constant that matters for products: what other
/// factors are multiplied with.
std::vector<Factor> simpleShapes(const std::vector<Symbol>& symbols, int symbol);
/// All shapes of one symbol on a grid of their constants.
std::vector<Factor> allShapes(const std::vector<Symbol>& symbols, int symbol);
/// Shapes of sums of two symbols of the same unit.
std::vector<Factor> sumShapes(const std::vector<Symbol>& symbols, int a, int b);

}  // namespace mm
