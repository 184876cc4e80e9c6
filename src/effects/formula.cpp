#include <algorithm>
#include <cmath>
#include <map>

#include "base/error.h"
#include "base/nearest_name.h"
#include "effects/catalogue_effect.h"
#include "effects/expression.h"
#include "effects/formula_variables.h"
#include "effects/linearity.h"
#include "effects/numeric_derivative.h"
#include "effects/quantity.h"
#include "effects/special_laws.h"
#include "effects/touch.h"

namespace mm {
namespace {

/// Unit of an unknown that enters linearly: that of the value over those of the variables with whose powers
/// its term grows, "um/mm^2". Variables without a unit of their own and those in other functions have no part
/// in it.
std::string unitOfTerm(const Expression& expression, const FormulaVariables& variables, std::size_t unknown,
                       std::string unit) {
  constexpr double kBases[] = {1.3, 0.7}, kSame = 1e-9;
  Expression::Evaluation formula(expression);
  std::vector<double> k(expression.unknowns().size(), 0.0);
  k[unknown] = 1.0;
  const std::vector<int>& used = expression.usedVariables();
  const auto power = [&](std::size_t of, double base) {
    for (std::size_t v = 0; v < used.size(); ++v)
      formula.variables()[v] = base + 0.1 * static_cast<double>(v);
    const double before = formula(k.data());
    formula.variables()[of] *= 2.0;
    return std::log2(formula(k.data()) / before);
  };
  std::map<std::string, int> powers;  // of the units
  for (std::size_t v = 0; v < used.size(); ++v) {
    const std::string below = variables.unit(used[v]);
    const double first = power(v, kBases[0]), second = power(v, kBases[1]), whole = std::round(first);
    if (below.empty() || !(std::abs(first - whole) < kSame && std::abs(second - whole) < kSame) ||
        whole == 0.0)
      continue;
    powers[below.find('/') != std::string::npos ? "(" + below + ")" : below] += static_cast<int>(whole);
  }
  for (const auto& [of, power] : powers) {
    const int n = std::abs(power);
    if (n > 0) unit += (power > 0 ? "/" : "*") + of + (n > 1 ? "^" + std::to_string(n) : "");
  }
  return unit;
}

/// The user's own physics. Value in um, or arcsec where the direction is a rotary joint; the unknowns are in
/// the formula's own units. Without `start` each unknown starts at 1, except in a formula that is linear: at
/// 0.
class Formula : public CatalogueEffect {
 public:
  explicit Formula(SpecReader& read) : Formula(read, read.direction("direction", true)) {}

  void evaluate(const State& state, const double* p, ErrorSink& sink) const override {
    double along[3] = {1.0, 0.0, 0.0};
    int slots = 1;
    if (direction_.kind == Direction::Kind::kApproach) {
      slots = 3;
      const Touch touch = touchOf(state);
      if (touch == Touch::kNone) return;
      for (int k = 0; k < 3; ++k) along[k] = touch == Touch::kKnown ? state.approach[k] : kUnknown;
    }
    const auto slot = [&](int k) { return slots == 1 ? direction_.slot(layout_) : layout_.volume(k); };

    Expression::Evaluation formula(*expression_);
    variables_.values(state, expression_->usedVariables(), formula.variables());
    const int n = parameterCount();
    std::vector<double> k(p, p + n);
    if (linear()) {
      std::fill(k.begin(), k.end(), 0.0);
      for (int i = 0; i < n; ++i) {
        k[i] = 1.0;
        const double basis = formula(k.data()) * toSi_;
        k[i] = 0.0;
        for (int s = 0; s < slots; ++s) sink.add(slot(s), i, p[i], basis * along[s]);
      }
      return;
    }
    const double value = formula(k.data()) * toSi_;
    for (int s = 0; s < slots; ++s) sink.value(slot(s), value * along[s]);
    if (!sink.wantsDerivatives()) return;
    for (int i = 0; i < n; ++i) {
      const double derivative = std::isfinite(value) ? slope(formula, k, i) * toSi_ : kUnknown;
      for (int s = 0; s < slots; ++s) sink.derivative(slot(s), i, derivative * along[s]);
    }
  }

 private:
  Formula(SpecReader& read, const Direction& direction)
      : CatalogueEffect(read, direction),
        direction_(direction),
        toSi_(direction.quantity == JointKind::kLinear ? kMicrometre : kArcsecond),
        variables_(read.domain()) {
    const std::string text = read.text("formula");
    try {
      expression_ = std::make_unique<Expression>(text, variables_.names());
    } catch (const InputError& error) {
      read.fail(std::string("formula: ") + error.what());
    }
    const std::vector<double> start = read.numbers("start");
    const auto& unknowns = expression_->unknowns();
    if (!start.empty() && start.size() != unknowns.size())
      read.fail("start must hold " + std::to_string(unknowns.size()) + " numbers, for " + listOf(unknowns) +
                "; it holds " + std::to_string(start.size()));
    linearity_ = linearityOf(*expression_, variables_, start);
    nature_.linear = linearity_.linear;
    nature_.nonlinear = linearity_.nonlinear;
    nature_.statesDatum = nature_.ofUnknownSize = true;
    std::string names;
    for (const int v : expression_->usedVariables())
      names += (names.empty() ? "" : ", ") + variables_.names()[v];
    words_["names"] = names.empty() ? "all inputs" : names;
    for (std::size_t i = 0; i < unknowns.size(); ++i) {
      const std::string value = direction.quantity == JointKind::kLinear ? "um" : "arcsec";
      const std::string unit =
          linearity_.linear ? unitOfTerm(*expression_, variables_, i, value) : std::string("1");
      Parameter k = parameter(unknowns[i], {unit, 1.0}, 1.0, 1e9);
      if (linearity_.linear) {  // sized by what it moves: 1 um (arcsec) is typical, 0.1 m (28 deg) the bound
        k.scale = 1.0 / linearity_.typicalBasis[i];
        k.bound = 1e5 * k.scale;
      } else if (!start.empty() && start[i] != 0.0) {
        k.scale = std::abs(start[i]);
        k.bound = 1e9 * std::max(1.0, k.scale);
      }
      k.start = !start.empty() ? start[i] : linearity_.linear ? 0.0 : 1.0;
      parameters_.push_back(k);
    }
    if (nature_.linear || nature_.nonlinear.empty()) return;
    std::vector<double> starts;
    for (const int i : nature_.nonlinear) starts.push_back(parameters_[i].start);
    nature_.searchStarts = {starts};
  }

  /// d formula / d k_i at k: exact up to rounding where k_i enters linearly.
  double slope(const Expression::Evaluation& formula, std::vector<double>& k, int i) const {
    const double here = k[i];
    const auto at = [&](double value) {
      k[i] = value;
      return formula(k.data());
    };
    double result = kUnknown;
    if (std::find(linearity_.nonlinear.begin(), linearity_.nonlinear.end(), i) ==
        linearity_.nonlinear.end()) {
      const double h = std::max(std::abs(here), parameters_[i].scale);
      result = (at(here + h) - at(here - h)) / (2.0 * h);
    }
    if (!std::isfinite(result)) result = numericDerivative(at, here, parameters_[i].scale);
    k[i] = here;
    return result;
  }

  Direction direction_;
  double toSi_;
  FormulaVariables variables_;
  std::unique_ptr<const Expression> expression_;
  Linearity linearity_;
};

}  // namespace

EffectType formulaType() {
  const EffectSpec law("formula");
  return effectType<Formula>("formula", {"direction", "formula", "start"}, nullptr, false,
                             {EffectSpec(law).set("direction", "x").set("formula", "k1*x"),
                              EffectSpec(law).set("direction", "b").set("formula", "k1*x")});
}

}  // namespace mm
