#include "diagnosis/formula_symbols.h"

#include <algorithm>
#include <cmath>

#include "machine/units.h"

namespace mm {
namespace {

constexpr std::size_t kMostDifferences = 30;

/// Range and number of distinct values.
void measure(Symbol& s) {
  Eigen::ArrayXd sorted = s.values;
  std::sort(sorted.begin(), sorted.end());
  s.low = sorted[0];
  s.high = sorted[sorted.size() - 1];
  const double apart = 1e-4 * s.range();
  s.distinct = 1;
  for (Eigen::Index i = 1; i < sorted.size(); ++i) s.distinct += sorted[i] - sorted[i - 1] > apart;
}

bool isSpeed(const Variable& v) {
  const std::string end = "_velocity";
  return v.symbol.size() > end.size() && v.symbol.compare(v.symbol.size() - end.size(), end.size(), end) == 0;
}

/// Speed of the tip and the share of each joint in it; where the speed never changes the joints' own
/// velocities say the same.
void addTipSpeed(std::vector<Symbol>& symbols) {
  Symbol speed;
  speed.kind = Symbol::Kind::kTipSpeed;
  speed.unit = "mm/s";
  std::vector<std::size_t> parts;
  for (std::size_t i = 0; i < symbols.size(); ++i) {
    if (symbols[i].kind != Symbol::Kind::kSpeed || symbols[i].unit != "mm/s") continue;
    parts.push_back(i);
    speed.text += (speed.text.empty() ? "sqrt(" : "+") + symbols[i].text + "^2";
    speed.variables.push_back(symbols[i].variables[0]);
    if (speed.values.size() == 0) speed.values = Eigen::ArrayXd::Zero(symbols[i].values.size());
    speed.values += symbols[i].values.square();
  }
  if (parts.size() < 2) return;
  speed.text += ")";
  speed.bare = speed.text;
  speed.values = speed.values.sqrt();
  measure(speed);
  if (!(speed.low > 0.0) || speed.range() < 0.01 * speed.high) return;
  for (std::size_t i : parts) {
    Symbol way = symbols[i];
    way.kind = Symbol::Kind::kWay;
    way.unit = "way";
    way.text = way.bare = "(" + symbols[i].text + "/" + speed.text + ")";
    way.variables = speed.variables;
    way.values = symbols[i].values / speed.values;
    measure(way);
    symbols.push_back(std::move(way));
  }
  symbols.push_back(std::move(speed));
}

}  // namespace

std::vector<Symbol> symbolsOf(const std::vector<Variable>& variables, const Domain& domain) {
  std::vector<Symbol> symbols;
  for (int i = 0; i < static_cast<int>(variables.size()); ++i) {
    const Variable& v = variables[i];
    if (v.symbol.empty()) continue;
    Symbol s;
    s.text = s.bare = v.symbol;
    s.variables = {i};
    s.values = v.values.array() * v.half + v.centre;
    const int joint = domain.findJoint(isSpeed(v) ? v.symbol.substr(0, v.symbol.size() - 9) : v.symbol);
    const std::string length = joint >= 0 && domain.joints[joint].kind == JointKind::kRotary ? "rad" : "mm";
    if (isSpeed(v)) {
      s.kind = Symbol::Kind::kSpeed;
      s.unit = length + "/s";
    } else if (joint >= 0) {
      s.kind = Symbol::Kind::kPosition;
      s.unit = length;
    } else if (v.name == "laser reading") {
      s.kind = Symbol::Kind::kPosition;
      s.unit = length;
    } else if (domain.findSensor(v.symbol) >= 0) {
      s.kind = Symbol::Kind::kTemperature;
      s.text = "(" + v.symbol + "-20)";
      s.zero = kReferenceTemperature;
      s.values -= kReferenceTemperature;
      s.unit = "degC";
    } else if (v.symbol == "t") {
      s.kind = Symbol::Kind::kTime;
      s.unit = "s";
    } else {
      s.unit = v.symbol;
    }
    measure(s);
    symbols.push_back(std::move(s));
  }
  addTipSpeed(symbols);
  const std::size_t single = symbols.size();
  std::vector<Symbol> differences;
  for (std::size_t a = 0; a < single; ++a)
    for (std::size_t b = a + 1; b < single; ++b) {
      if (symbols[a].kind != Symbol::Kind::kTemperature || symbols[b].kind != Symbol::Kind::kTemperature)
        continue;
      Symbol d;
      d.kind = Symbol::Kind::kDifference;
      d.unit = "degC";
      d.variables = {symbols[a].variables[0], symbols[b].variables[0]};
      d.text = "(" + variables[d.variables[0]].symbol + "-" + variables[d.variables[1]].symbol + ")";
      d.bare = d.text;
      d.values = symbols[a].values - symbols[b].values;
      measure(d);
      differences.push_back(std::move(d));
    }
  if (differences.size() <= kMostDifferences)
    symbols.insert(symbols.end(), differences.begin(), differences.end());
  return symbols;
}

}  // namespace mm
