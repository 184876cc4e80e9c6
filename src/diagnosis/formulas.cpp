#include "diagnosis/formulas.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

#include "diagnosis/structure.h"
#include "machine/units.h"

namespace mm {
namespace {

/// One term of a formula: a function of the variables with one free factor.
struct Term {
  std::string text;              // without the factor: "x*y"
  std::vector<int> variables;
  Eigen::VectorXd values;        // a used row, in the units of formulas
  double cost = 1.0;             // description length in parameters: factor 1, constants inside 1 each
};

std::string number(double v) {
  char text[32];
  std::snprintf(text, sizeof text, "%.5g", v);
  return text;
}

Eigen::VectorXd rawOf(const Variable& v) { return v.values.array() * v.half + v.centre; }

/// Single-variable shapes, then products of two and three variables.
std::vector<Term> makeTerms(const std::vector<Variable>& variables) {
  std::vector<Term> terms;
  std::vector<int> continuous;
  for (int i = 0; i < static_cast<int>(variables.size()); ++i)
    if (!variables[i].symbol.empty()) continuous.push_back(i);
  const auto add = [&](const std::string& text, std::vector<int> on, const Eigen::VectorXd& values, double cost) {
    if (values.allFinite() && values.maxCoeff() > values.minCoeff()) terms.push_back({text, std::move(on), values, cost});
  };
  const auto isSpeed = [&](int i) { return variables[i].symbol.find("_velocity") != std::string::npos; };
  std::map<int, std::vector<Term>> shapes;  // of one variable, for products
  for (int i : continuous) {
    const std::string& s = variables[i].symbol;
    const Eigen::ArrayXd raw = rawOf(variables[i]).array();
    const std::size_t first = terms.size();
    add(s, {i}, raw, 1);
    add(s + "^2", {i}, raw.square(), 1);
    add(s + "^3", {i}, raw.cube(), 1);
    if (raw.minCoeff() < 0 && raw.maxCoeff() > 0) {
      add("abs(" + s + ")", {i}, raw.abs(), 1);
      add("sign(" + s + ")", {i}, raw.sign(), 1);
    }
    shapes[i].assign(terms.begin() + static_cast<long>(first), terms.end());
    // temperatures count from the reference, so that products mean something
    const double centre = variables[i].centre, half = variables[i].half;
    for (int step = -6; step <= 6; ++step) {
      const double at = centre + half * step / 7.0;
      add("(" + s + ">" + number(at) + ")", {i}, (raw > std::stod(number(at))).cast<double>(), 2);
      add("abs(" + s + "-" + number(at) + ")", {i}, (raw - std::stod(number(at))).abs(), 2);
    }
    if (!isSpeed(i)) {
      for (double waves = 0.5; waves <= 24.0; waves += waves < 4 ? 0.25 : 0.5) {
        const double period = std::stod(number(2.0 * half / waves));
        add("sin(2*pi*" + s + "/" + number(period) + ")", {i}, (2.0 * kPi / period * raw).sin(), 2);
        add("cos(2*pi*" + s + "/" + number(period) + ")", {i}, (2.0 * kPi / period * raw).cos(), 2);
      }
      for (double tau : {0.05, 0.1, 0.2, 0.4, 0.8}) {
        const double scale = std::stod(number(2.0 * half * tau));
        add("exp(-(" + s + "-" + number(centre - half) + ")/" + number(scale) + ")", {i}, (-(raw - (centre - half)) / scale).exp(), 2);
        add("exp((" + s + "-" + number(centre + half) + ")/" + number(scale) + ")", {i}, ((raw - (centre + half)) / scale).exp(), 2);
      }
    }
  }
  for (std::size_t a = 0; a < continuous.size(); ++a)
    for (std::size_t b = a + 1; b < continuous.size(); ++b) {
      for (const Term& ta : shapes[continuous[a]])
        for (const Term& tb : shapes[continuous[b]])
          add(ta.text + "*" + tb.text, {continuous[a], continuous[b]}, ta.values.cwiseProduct(tb.values), 1);
      for (int both : {1, -1}) {  // powers of a sum or a difference: a distance along a diagonal
        const Eigen::ArrayXd sum = rawOf(variables[continuous[a]]).array() + both * rawOf(variables[continuous[b]]).array();
        const std::string text = "(" + variables[continuous[a]].symbol + (both > 0 ? "+" : "-") + variables[continuous[b]].symbol + ")";
        add("abs" + text, {continuous[a], continuous[b]}, sum.abs(), 1);
        add("sign" + text, {continuous[a], continuous[b]}, sum.sign(), 1);
        if (sum.minCoeff() > 0) add("sqrt" + text, {continuous[a], continuous[b]}, sum.sqrt(), 1);
      }
      if (isSpeed(continuous[a]) || isSpeed(continuous[b])) continue;
      const Eigen::ArrayXd ra = rawOf(variables[continuous[a]]).array(), rb = rawOf(variables[continuous[b]]).array();
      const std::string &sa = variables[continuous[a]].symbol, &sb = variables[continuous[b]].symbol;
      add("sqrt(" + sa + "^2+" + sb + "^2)", {continuous[a], continuous[b]}, (ra.square() + rb.square()).sqrt(), 1);
      const double half = variables[continuous[a]].half;
      for (double waves : {0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0}) {
        const double period = std::stod(number(2.0 * half / waves));
        add(sb + "*sin(2*pi*" + sa + "/" + number(period) + ")", {continuous[a], continuous[b]}, rb * (2 * kPi / period * ra).sin(), 2);
        add(sb + "*cos(2*pi*" + sa + "/" + number(period) + ")", {continuous[a], continuous[b]}, rb * (2 * kPi / period * ra).cos(), 2);
        const double other = std::stod(number(2.0 * variables[continuous[b]].half / waves));
        add(sa + "*sin(2*pi*" + sb + "/" + number(other) + ")", {continuous[a], continuous[b]}, ra * (2 * kPi / other * rb).sin(), 2);
        add(sa + "*cos(2*pi*" + sb + "/" + number(other) + ")", {continuous[a], continuous[b]}, ra * (2 * kPi / other * rb).cos(), 2);
      }
      for (std::size_t c = b + 1; c < continuous.size(); ++c)
        if (!isSpeed(continuous[c])) {
          const Eigen::ArrayXd rc = rawOf(variables[continuous[c]]).array();
          add(sa + "*" + sb + "*" + variables[continuous[c]].symbol, {continuous[a], continuous[b], continuous[c]}, ra * rb * rc, 1);
        }
    }
  return terms;
}

/// Columns of the terms in one direction, projected on the model; rows + priors long.
Eigen::MatrixXd columnsOf(const ResidualSpace& space, const std::vector<Term>& terms, const Eigen::VectorXd& factor, double unit) {
  Eigen::MatrixXd all = Eigen::MatrixXd::Zero(space.problem().rowCount(), terms.size());
  for (std::size_t t = 0; t < terms.size(); ++t)
    for (int i = 0; i < space.rows(); ++i) all(space.used()[i], static_cast<int>(t)) = factor[i] * terms[t].values[i] * unit;
  Eigen::MatrixXd columns = space.whiten(all);
  space.project(columns);
  return columns;
}

/// A formula in the making: terms in one direction.
struct Pick {
  int direction = 0;
  std::vector<int> terms;
  double objective = 1e300;
  double cost = 0.0;
};

/// Greedy choice of terms with a backward look, on columns that are orthogonal to what is already found.
class Greedy {
 public:
  Greedy(const Eigen::MatrixXd& columns, const std::vector<double>& costs, const Subset& rest, double dof, double logTried)
      : columns_(columns), costs_(costs), rest_(rest), dof_(dof), logTried_(logTried) {}

  double objectiveOf(double rss, double cost) const {
    return 0.5 * dof_ * std::log(std::max(rss, 1e-300) / dof_) + (0.5 * std::log(dof_) + 0.5 * logTried_) * cost;
  }

  /// From one first term on. @param most terms.
  Pick from(int first, std::size_t most) const {
    Pick pick;
    Eigen::VectorXd left = rest_.left;
    Eigen::MatrixXd basis(columns_.rows(), 0);
    Eigen::VectorXd room = Eigen::VectorXd::Ones(columns_.cols());  // share of each column outside the basis
    double rss = rest_.rss, objective = objectiveOf(rss, 0.0);
    for (int next = first; next >= 0 && pick.terms.size() < most;) {
      Eigen::VectorXd q = columns_.col(next);
      for (int pass = 0; pass < 2; ++pass)
        if (basis.cols() > 0) q -= basis * (basis.transpose() * q);
      q.normalize();
      const double gain = q.dot(left), now = objectiveOf(rss - gain * gain, pick.cost + costs_[next]);
      if (!(now < objective - 3.0)) break;
      objective = now;
      rss -= gain * gain;
      pick.cost += costs_[next];
      pick.terms.push_back(next);
      left -= gain * q;
      basis.conservativeResize(Eigen::NoChange, basis.cols() + 1);
      basis.rightCols<1>() = q;
      room -= (columns_.transpose() * q).cwiseAbs2();
      const Eigen::VectorXd score = columns_.transpose() * left;
      next = -1;
      double best = 1e300;
      for (int t = 0; t < columns_.cols(); ++t) {
        if (room[t] < 0.0025) continue;
        const double o = objectiveOf(rss - score[t] * score[t] / room[t], pick.cost + costs_[t]);
        if (o < best) best = o, next = t;
      }
    }
    pick.objective = objective;
    for (std::size_t i = 0; i < pick.terms.size() && pick.terms.size() > 1;) {
      std::vector<int> fewer = pick.terms;
      fewer.erase(fewer.begin() + static_cast<long>(i));
      const double cost = pick.cost - costs_[pick.terms[i]], o = objectiveOf(rssOf(fewer), cost);
      if (o < pick.objective + 1e-9) {
        pick.terms = fewer;
        pick.cost = cost;
        pick.objective = o;
        i = 0;
      } else {
        ++i;
      }
    }
    return pick;
  }

  double rssOf(const std::vector<int>& members) const {
    Eigen::MatrixXd c(columns_.rows(), members.size());
    for (std::size_t i = 0; i < members.size(); ++i) c.col(static_cast<int>(i)) = columns_.col(members[i]);
    return (rest_.left - c * c.colPivHouseholderQr().solve(rest_.left)).squaredNorm();
  }

 private:
  const Eigen::MatrixXd& columns_;  // normalised
  const std::vector<double>& costs_;
  const Subset& rest_;
  double dof_, logTried_;
};

}  // namespace

struct FormulaSearch::Dictionary {
  std::vector<Variable> variables;
  Directions directions;
  std::vector<Term> terms;
  std::vector<Eigen::MatrixXd> columns;  // a direction: projected columns of all terms
};

FormulaSearch::FormulaSearch(const ResidualSpace& space) : space_(space), dictionary_(std::make_unique<Dictionary>()) {
  dictionary_->variables = variablesOf(space);
  dictionary_->directions = directionsOf(space);
  dictionary_->terms = makeTerms(dictionary_->variables);
  for (int d = 0; d < static_cast<int>(dictionary_->directions.names.size()); ++d) {
    const Domain& domain = space.problem().model().domain();
    const int joint = domain.findJoint(dictionary_->directions.names[d]);
    const bool rotary = joint >= 0 && domain.joints[joint].kind == JointKind::kRotary;
    dictionary_->columns.push_back(columnsOf(space, dictionary_->terms, dictionary_->directions.factors.col(d), rotary ? kArcsecond : kMicrometre));
  }
}

FormulaSearch::~FormulaSearch() = default;

std::vector<FoundFormula> FormulaSearch::run(const Subset& rest, double dof, double significance, int count) const {
  constexpr std::size_t kKept = 900, kStarts = 5, kMostTerms = 4;
  const Dictionary& book = *dictionary_;
  std::vector<FoundFormula> found;
  if (book.terms.empty() || book.directions.names.empty()) return found;
  const double logTried = std::log(static_cast<double>(book.terms.size() * book.directions.names.size()));

  std::vector<Pick> picks;
  for (int d = 0; d < static_cast<int>(book.directions.names.size()); ++d) {
    // the terms that explain most alone; the rest rarely helps and costs time
    const Eigen::MatrixXd& all = book.columns[d];
    const Eigen::MatrixXd inBasis = rest.basis.transpose() * all;
    const Eigen::VectorXd score = all.transpose() * rest.left;
    std::vector<std::pair<double, int>> order;
    for (int t = 0; t < all.cols(); ++t) {
      const double total = all.col(t).squaredNorm(), room = total - inBasis.col(t).squaredNorm();
      if (room > 1e-6 * total && room > 0.0)
        order.emplace_back(0.5 * dof * std::log(std::max(1e-9, 1.0 - score[t] * score[t] / room / rest.rss)) +
                               book.terms[t].cost * 0.5 * (std::log(dof) + logTried), t);
    }
    const std::size_t kept = std::min(kKept, order.size());
    std::partial_sort(order.begin(), order.begin() + static_cast<long>(kept), order.end());
    Eigen::MatrixXd columns(all.rows(), kept);
    std::vector<double> costs;
    for (std::size_t k = 0; k < kept; ++k) {
      columns.col(static_cast<int>(k)) = all.col(order[k].second);
      costs.push_back(book.terms[order[k].second].cost);
    }
    if (rest.basis.cols() > 0) columns -= rest.basis * (rest.basis.transpose() * columns);
    columns.colwise().normalize();
    const Greedy greedy(columns, costs, rest, dof, logTried);
    for (std::size_t k = 0; k < std::min(kStarts, kept); ++k) {
      Pick pick = greedy.from(static_cast<int>(k), kMostTerms);
      if (pick.terms.empty()) continue;
      pick.direction = d;
      for (int& t : pick.terms) t = order[t].second;
      std::sort(pick.terms.begin(), pick.terms.end());
      picks.push_back(std::move(pick));
    }
  }
  std::stable_sort(picks.begin(), picks.end(), [](const Pick& a, const Pick& b) { return a.objective < b.objective; });
  for (const Pick& pick : picks) {
    if (static_cast<int>(found.size()) >= count) break;
    FoundFormula f;
    f.columns.resize(space_.length(), pick.terms.size());
    std::string text;
    for (std::size_t i = 0; i < pick.terms.size(); ++i) {
      const Term& t = book.terms[pick.terms[i]];
      f.columns.col(static_cast<int>(i)) = book.columns[pick.direction].col(pick.terms[i]);
      text += (i > 0 ? "+k" : "k") + std::to_string(i + 1) + "*" + t.text;
      for (int v : t.variables)
        if (std::find(f.variables.begin(), f.variables.end(), book.variables[v].name) == f.variables.end())
          f.variables.push_back(book.variables[v].name);
    }
    Eigen::MatrixXd c = f.columns;
    if (rest.basis.cols() > 0) c -= rest.basis * (rest.basis.transpose() * c);
    c.colwise().normalize();
    const double after = (rest.left - c * c.colPivHouseholderQr().solve(rest.left)).squaredNorm();
    const double logP = logPValueF((rest.rss - after) / pick.cost / (after / std::max(1.0, dof - pick.cost)), pick.cost, dof - pick.cost) +
                        static_cast<double>(pick.terms.size()) * logTried;
    if (logP > std::log(significance)) continue;
    f.spec = EffectSpec("formula");
    f.spec.set("direction", book.directions.names[pick.direction]).set("formula", text);
    f.objective = pick.objective;
    if (std::none_of(found.begin(), found.end(), [&](const FoundFormula& o) { return o.spec == f.spec; })) found.push_back(std::move(f));
  }
  return found;
}

}  // namespace mm
