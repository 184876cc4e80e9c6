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

struct Pick {
  int direction = 0;
  std::vector<int> terms;
  Eigen::MatrixXd columns;
  double objective = 1e300;
  double cost = 0.0;
};

}  // namespace

std::vector<FoundFormula> searchFormulas(const ResidualSpace& space, const Subset& rest, double dof, double significance, int count) {
  const std::vector<Variable> variables = variablesOf(space);
  const Directions directions = directionsOf(space);
  const std::vector<Term> terms = makeTerms(variables);
  std::vector<FoundFormula> found;
  if (terms.empty() || directions.names.empty()) return found;
  const double base = 0.5 * dof * std::log(std::max(rest.rss, 1e-300) / dof);
  const double unitPenalty = 0.5 * std::log(dof);
  const double logTried = std::log(static_cast<double>(terms.size() * directions.names.size()));

  std::vector<Pick> picks;
  for (int d = 0; d < static_cast<int>(directions.names.size()); ++d) {
    const int joint = space.problem().model().domain().findJoint(directions.names[d]);
    const bool rotary = joint >= 0 && space.problem().model().domain().joints[joint].kind == JointKind::kRotary;
    Eigen::MatrixXd columns = columnsOf(space, terms, directions.factors.col(d), rotary ? kArcsecond : kMicrometre);
    Eigen::MatrixXd fresh = columns;
    if (rest.basis.cols() > 0) fresh -= rest.basis * (rest.basis.transpose() * fresh);
    std::vector<char> usable(terms.size(), 1);
    for (int t = 0; t < fresh.cols(); ++t) {
      const double norm = fresh.col(t).norm();
      if (norm < 1e-3 * columns.col(t).norm() || !(norm > 0.0)) usable[t] = 0;
      else fresh.col(t) /= norm;
    }
    // greedy from each of the best first terms: up to four terms in one direction
    const Eigen::VectorXd score = fresh.transpose() * rest.left;
    const auto objectiveOf = [&](double rss, double cost) {
      return 0.5 * dof * std::log(std::max(rss, 1e-300) / dof) + unitPenalty * cost + 0.5 * logTried * cost;
    };
    std::vector<std::pair<double, int>> order;
    for (int t = 0; t < static_cast<int>(terms.size()); ++t)
      if (usable[t]) order.emplace_back(objectiveOf(rest.rss - score[t] * score[t], terms[t].cost), t);
    std::sort(order.begin(), order.end());
    for (std::size_t k = 0; k < std::min<std::size_t>(4, order.size()); ++k) {
      Pick pick;
      pick.direction = d;
      Eigen::MatrixXd left = rest.left;
      Eigen::MatrixXd work = fresh;
      int next = order[k].second;
      double rss = rest.rss, objective = base;
      while (next >= 0 && pick.terms.size() < 4) {
        const Eigen::VectorXd q = work.col(next);
        const double gain = q.dot(left.col(0));
        const double cost = pick.cost + terms[next].cost;
        const double now = objectiveOf(rss - gain * gain, cost);
        if (!(now < objective - 3.0)) break;
        objective = now;
        rss -= gain * gain;
        pick.terms.push_back(next);
        pick.cost = cost;
        left -= q * gain;
        work -= q * (q.transpose() * work);
        const Eigen::VectorXd norms = work.colwise().norm();
        const Eigen::VectorXd s = work.transpose() * left.col(0);
        next = -1;
        double best = 1e300;
        for (int t = 0; t < work.cols(); ++t) {
          if (!usable[t] || norms[t] < 0.05) continue;
          const double drop = s[t] * s[t] / (norms[t] * norms[t]);
          const double o = objectiveOf(rss - drop, pick.cost + terms[t].cost);
          if (o < best) best = o, next = t;
        }
        if (next >= 0) work.col(next) /= norms[next];
      }
      if (pick.terms.empty()) continue;
      // backward look: a term found early may no longer count
      const auto fit = [&](const std::vector<int>& members) {
        Eigen::MatrixXd c(space.length(), members.size());
        for (std::size_t i = 0; i < members.size(); ++i) c.col(static_cast<int>(i)) = fresh.col(members[i]);
        const Eigen::VectorXd r = rest.left - c * c.colPivHouseholderQr().solve(rest.left);
        return r.squaredNorm();
      };
      for (std::size_t i = 0; i < pick.terms.size() && pick.terms.size() > 1;) {
        std::vector<int> fewer = pick.terms;
        fewer.erase(fewer.begin() + static_cast<long>(i));
        const double cost = pick.cost - terms[pick.terms[i]].cost;
        const double o = objectiveOf(fit(fewer), cost);
        if (o < objective + 1e-9) {
          pick.terms = fewer;
          pick.cost = cost;
          objective = o;
          i = 0;
        } else {
          ++i;
        }
      }
      pick.objective = objective;
      pick.columns.resize(space.length(), pick.terms.size());
      for (std::size_t i = 0; i < pick.terms.size(); ++i) pick.columns.col(static_cast<int>(i)) = columns.col(pick.terms[i]);
      picks.push_back(std::move(pick));
    }
  }
  std::stable_sort(picks.begin(), picks.end(), [](const Pick& a, const Pick& b) { return a.objective < b.objective; });
  for (const Pick& pick : picks) {
    if (static_cast<int>(found.size()) >= count) break;
    Eigen::MatrixXd c = pick.columns;
    if (rest.basis.cols() > 0) c -= rest.basis * (rest.basis.transpose() * c);
    const Eigen::VectorXd left = rest.left - c * c.colPivHouseholderQr().solve(rest.left);
    const double drop = rest.rss - left.squaredNorm(), free = pick.cost;
    const double logP = logPValueF(drop / free / (left.squaredNorm() / std::max(1.0, dof - free)), free, dof - free) +
                        static_cast<double>(pick.terms.size()) * logTried;
    if (logP > std::log(significance)) continue;
    FoundFormula f;
    std::string text;
    for (std::size_t i = 0; i < pick.terms.size(); ++i) {
      const Term& t = terms[pick.terms[i]];
      text += (i > 0 ? "+k" : "k") + std::to_string(i + 1) + "*" + t.text;
      for (int v : t.variables)
        if (std::find(f.variables.begin(), f.variables.end(), variables[v].name) == f.variables.end())
          f.variables.push_back(variables[v].name);
    }
    f.spec = EffectSpec("formula");
    f.spec.set("direction", directions.names[pick.direction]).set("formula", text);
    f.columns = pick.columns;
    f.objective = pick.objective;
    if (std::none_of(found.begin(), found.end(), [&](const FoundFormula& o) { return o.spec == f.spec; })) found.push_back(std::move(f));
  }
  return found;
}

}  // namespace mm
