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
  std::string text;  // without the factor: "x*y"
  std::vector<int> variables;
  Eigen::VectorXd values;  // a used row, in the units of formulas
  double cost = 1.0;       // description length in parameters: factor 1, constants inside 1 each
};

std::string number(double v) {
  char text[32];
  std::snprintf(text, sizeof text, "%.5g", v);
  return text;
}

/// How a variable is written in formulas, and its values there. Temperatures count from the reference
/// temperature.
struct Written {
  std::string text;
  Eigen::ArrayXd values;
  std::string unit;  // sums are only made of equal units
  bool speed = false;
};

Written writtenAs(const Variable& v, const Domain& domain) {
  Written w;
  w.text = v.symbol;
  w.values = v.values.array() * v.half + v.centre;
  w.speed = v.symbol.find("_velocity") != std::string::npos;
  if (domain.findSensor(v.symbol) >= 0) {
    w.text = "(" + v.symbol + "-20)";
    w.values -= kReferenceTemperature;
    w.unit = "degC";
  } else if (domain.findJoint(v.symbol) >= 0) {
    w.unit = domain.joints[domain.findJoint(v.symbol)].kind == JointKind::kLinear ? "mm" : "rad";
  }
  return w;
}

int distinctValues(Eigen::ArrayXd values) {
  std::sort(values.begin(), values.end());
  const double apart = 1e-4 * (values[values.size() - 1] - values[0]);
  int count = 1;
  for (Eigen::Index i = 1; i < values.size(); ++i) count += values[i] - values[i - 1] > apart;
  return count;
}

/// Single-variable shapes, then products of two and three variables and functions of sums of equal units.
std::vector<Term> makeTerms(const std::vector<Variable>& variables, const Domain& domain,
                            const std::vector<FoundPeriod>& periods) {
  constexpr int kFewValues = 9;  // with fewer distinct values a wave, a step or a decay is any profile
  constexpr double kMoreVariables = 0.3, kHigherPower = 0.15;  // description length beyond the factor itself
  std::vector<Term> terms;
  std::vector<int> continuous;
  std::vector<Written> written(variables.size());
  for (int i = 0; i < static_cast<int>(variables.size()); ++i)
    if (!variables[i].symbol.empty()) {
      continuous.push_back(i);
      written[i] = writtenAs(variables[i], domain);
    }
  const auto add = [&](const std::string& text, std::vector<int> on, const Eigen::VectorXd& values,
                       double cost) {
    if (!values.allFinite() || !(values.maxCoeff() > values.minCoeff())) return;
    cost += kMoreVariables * (static_cast<double>(on.size()) - 1.0);
    terms.push_back({text, std::move(on), values, cost});
  };
  std::map<int, std::vector<Term>> shapes;  // of one variable, for products
  for (int i : continuous) {
    const std::string& s = written[i].text;
    const Eigen::ArrayXd& raw = written[i].values;
    const std::size_t first = terms.size();
    add(s, {i}, raw, 1);
    add(s + "^2", {i}, raw.square(), 1 + kHigherPower);
    add(s + "^3", {i}, raw.cube(), 1 + 2 * kHigherPower);
    if (raw.minCoeff() < 0 && raw.maxCoeff() > 0) {
      add("abs(" + s + ")", {i}, raw.abs(), 1 + kHigherPower);
      add("sign(" + s + ")", {i}, raw.sign(), 1 + kHigherPower);
      add("sign(" + s + ")*sqrt(abs(" + s + "))", {i}, raw.sign() * raw.abs().sqrt(), 1 + 2 * kHigherPower);
    } else if (raw.minCoeff() >= 0) {
      add("sqrt(" + s + ")", {i}, raw.sqrt(), 1 + kHigherPower);
    }
    shapes[i].assign(terms.begin() + static_cast<long>(first), terms.end());
    const double half = variables[i].half, centre = 0.5 * (raw.minCoeff() + raw.maxCoeff());
    if (std::abs(centre) > 2.0 * half &&
        written[i].unit.empty()) {  // far from zero: deviations from the middle count
      const std::string middle = number(centre);
      shapes[i].push_back({"(" + s + "-" + middle + ")", {i}, raw - std::stod(middle), 1 + kHigherPower});
    }
    if (distinctValues(raw) < kFewValues) continue;
    for (int step = -6; step <= 6; ++step) {
      const std::string at = number(centre + half * step / 7.0);
      const Eigen::ArrayXd from = raw - std::stod(at);
      const std::string difference = at[0] == '-' ? s + "+" + at.substr(1) : s + "-" + at;
      add("(" + s + ">" + at + ")", {i}, (from > 0.0).cast<double>(), 2);
      add("abs(" + difference + ")", {i}, from.abs(), 2);
      for (double width : {0.1, 0.25}) {
        const std::string w = number(2.0 * half * width);
        add("tanh((" + difference + ")/" + w + ")", {i}, (from / std::stod(w)).tanh(), 3);
      }
    }
    if (!written[i].speed) {
      const bool joint = !written[i].unit.empty() && written[i].unit != "degC";
      for (double waves = 0.5; waves <= (joint ? 24.0 : 10.0); waves += waves < 4 ? 0.125 : 0.25) {
        const std::string period = number(2.0 * half / waves);
        const double k = 2.0 * kPi / std::stod(period);
        add("sin(2*pi*" + s + "/" + period + ")", {i}, (k * raw).sin(), 2);
        add("cos(2*pi*" + s + "/" + period + ")", {i}, (k * raw).cos(), 2);
      }
      for (double tau : {0.05, 0.1, 0.2, 0.4, 0.8}) {
        const std::string scale = number(2.0 * half * tau);
        const std::string low = number(-(centre - half)), high = number(-(centre + half));
        const auto plus = [](const std::string& v) { return v[0] == '-' ? v : "+" + v; };
        add("exp(-(" + s + plus(low) + ")/" + scale + ")", {i},
            (-(raw + std::stod(low)) / std::stod(scale)).exp(), 2);
        add("exp((" + s + plus(high) + ")/" + scale + ")", {i},
            ((raw + std::stod(high)) / std::stod(scale)).exp(), 2);
      }
    }
  }
  for (const FoundPeriod& found : periods)
    for (int i : continuous) {
      if (variables[i].symbol != found.joint) continue;
      const std::string period = number(found.period / (written[i].unit == "mm" ? kMillimetre : 1.0));
      const Eigen::ArrayXd phase = 2.0 * kPi / std::stod(period) * written[i].values;
      const std::string inside = "(2*pi*" + written[i].text + "/" + period + ")";
      add("sin" + inside, {i}, phase.sin(), 2);
      add("cos" + inside, {i}, phase.cos(), 2);
      for (int k : continuous) {
        if (k == i) continue;
        add(written[k].text + "*sin" + inside, {k, i}, written[k].values * phase.sin(), 2);
        add(written[k].text + "*cos" + inside, {k, i}, written[k].values * phase.cos(), 2);
      }
    }
  for (std::size_t ia = 0; ia < continuous.size(); ++ia)
    for (std::size_t ib = ia + 1; ib < continuous.size(); ++ib) {
      const int a = continuous[ia], b = continuous[ib];
      const Written &wa = written[a], &wb = written[b];
      for (const Term& ta : shapes[a])
        for (const Term& tb : shapes[b])
          add(ta.text + "*" + tb.text, {a, b}, ta.values.cwiseProduct(tb.values), ta.cost + tb.cost - 1.0);
      if (wa.unit == wb.unit && !wa.unit.empty()) {
        for (int both : {1, -1}) {
          const Eigen::ArrayXd sum = wa.values + both * wb.values;
          const std::string text = wa.text + (both > 0 ? "+" : "-") + wb.text;
          add("abs(" + text + ")", {a, b}, sum.abs(), 1 + kHigherPower);
          add("sign(" + text + ")", {a, b}, sum.sign(), 1 + kHigherPower);
          add("(" + text + ")^2", {a, b}, sum.square(), 1 + kHigherPower);
          add("(" + text + ")^3", {a, b}, sum.cube(), 1 + 2 * kHigherPower);
          if (wa.unit == "degC" || distinctValues(sum) < kFewValues) continue;
          const double range = sum.maxCoeff() - sum.minCoeff();
          for (double waves = 1.0; waves <= 16.0; waves += waves < 4 ? 0.25 : 0.5) {
            const std::string period = number(range / waves);
            const double k = 2.0 * kPi / std::stod(period);
            add("sin(2*pi*(" + text + ")/" + period + ")", {a, b}, (k * sum).sin(), 2);
            add("cos(2*pi*(" + text + ")/" + period + ")", {a, b}, (k * sum).cos(), 2);
          }
        }
        add("sqrt(" + wa.text + "^2+" + wb.text + "^2)", {a, b},
            (wa.values.square() + wb.values.square()).sqrt(), 1 + kHigherPower);
      }
      const auto waving = [&](int over, int factor) {  // the wave's amplitude grows with another variable
        if (written[over].speed || distinctValues(written[over].values) < kFewValues) return;
        for (double waves : {0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 10.0}) {
          const std::string period = number(2.0 * variables[over].half / waves);
          const double k = 2.0 * kPi / std::stod(period);
          add(written[factor].text + "*sin(2*pi*" + written[over].text + "/" + period + ")", {factor, over},
              written[factor].values * (k * written[over].values).sin(), 2);
          add(written[factor].text + "*cos(2*pi*" + written[over].text + "/" + period + ")", {factor, over},
              written[factor].values * (k * written[over].values).cos(), 2);
        }
      };
      waving(a, b);
      waving(b, a);
      for (std::size_t ic = ib + 1; ic < continuous.size(); ++ic) {
        const int c = continuous[ic];
        add(wa.text + "*" + wb.text + "*" + written[c].text, {a, b, c},
            wa.values * wb.values * written[c].values, 1);
      }
    }
  return terms;
}

/// Columns of the terms in one direction, projected on the model; rows + priors long.
Eigen::MatrixXd columnsOf(const ResidualSpace& space, const std::vector<Term>& terms,
                          const Eigen::VectorXd& factor, double unit) {
  Eigen::MatrixXd all = Eigen::MatrixXd::Zero(space.problem().rowCount(), terms.size());
  for (std::size_t t = 0; t < terms.size(); ++t)
    for (int i = 0; i < space.rows(); ++i)
      all(space.used()[i], static_cast<int>(t)) = factor[i] * terms[t].values[i] * unit;
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
  Greedy(const Eigen::MatrixXd& columns, const std::vector<double>& costs, const Subset& rest, double dof,
         double logTried)
      : columns_(columns), costs_(costs), rest_(rest), dof_(dof), logTried_(logTried) {}

  double objectiveOf(double rss, double cost) const {
    return 0.5 * dof_ * std::log(std::max(rss, 1e-300) / dof_) +
           (0.5 * std::log(dof_) + 0.5 * logTried_) * cost;
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
    if (pick.terms.empty()) return pick;
    shorten(pick);
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

  /// The shortest formula that explains nearly as much: terms whose loss leaves the RMS within 3 % go.
  void shorten(Pick& pick) const {
    constexpr double kAsGood = 1.06;  // of the residual sum of squares
    const double full = rssOf(pick.terms);
    while (pick.terms.size() > 1) {
      double least = 1e300;
      std::size_t goes = 0;
      for (std::size_t i = 0; i < pick.terms.size(); ++i) {
        std::vector<int> fewer = pick.terms;
        fewer.erase(fewer.begin() + static_cast<long>(i));
        const double rss = rssOf(fewer);
        if (rss < least) least = rss, goes = i;
      }
      if (least > kAsGood * full) return;
      pick.cost -= costs_[pick.terms[goes]];
      pick.terms.erase(pick.terms.begin() + static_cast<long>(goes));
      pick.objective = objectiveOf(least, pick.cost);
    }
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

FormulaSearch::FormulaSearch(const ResidualSpace& space, const std::vector<FoundPeriod>& periods)
    : space_(space), dictionary_(std::make_unique<Dictionary>()) {
  dictionary_->variables = variablesOf(space);
  dictionary_->directions = directionsOf(space);
  dictionary_->terms = makeTerms(dictionary_->variables, space.problem().model().domain(), periods);
  for (int d = 0; d < static_cast<int>(dictionary_->directions.names.size()); ++d) {
    const Domain& domain = space.problem().model().domain();
    const int joint = domain.findJoint(dictionary_->directions.names[d]);
    const bool rotary = joint >= 0 && domain.joints[joint].kind == JointKind::kRotary;
    dictionary_->columns.push_back(columnsOf(space, dictionary_->terms,
                                             dictionary_->directions.factors.col(d),
                                             rotary ? kArcsecond : kMicrometre));
  }
}

FormulaSearch::~FormulaSearch() = default;

std::vector<FoundFormula> FormulaSearch::run(const Subset& rest, double dof, double significance,
                                             int count) const {
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
                               book.terms[t].cost * 0.5 * (std::log(dof) + logTried),
                           t);
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
  std::stable_sort(picks.begin(), picks.end(),
                   [](const Pick& a, const Pick& b) { return a.objective < b.objective; });
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
    const double logP = logPValueF((rest.rss - after) / pick.cost / (after / std::max(1.0, dof - pick.cost)),
                                   pick.cost, dof - pick.cost) +
                        static_cast<double>(pick.terms.size()) * logTried;
    if (logP > std::log(significance)) continue;
    f.spec = EffectSpec("formula");
    f.spec.set("direction", book.directions.names[pick.direction]).set("formula", text);
    f.objective = pick.objective;
    if (std::none_of(found.begin(), found.end(), [&](const FoundFormula& o) { return o.spec == f.spec; }))
      found.push_back(std::move(f));
  }
  return found;
}

}  // namespace mm
