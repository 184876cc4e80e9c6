// What the shape of a found effect may account for, and which sizes are no explanation.
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <set>

#include "diagnosis/fresh_basis.h"
#include "diagnosis/subset_search.h"

namespace mm {
namespace {

/// Keys that describe the shape of an effect, not its cause.
bool isShape(const std::string& key) {
  static const std::set<std::string> kShapes = {"degree", "power",     "order",     "harmonic",
                                                "lag",    "period_mm", "period_deg"};
  return kShapes.count(key) > 0;
}

/// The variables that an effect's columns depend on, by the names of `variablesOf`.
std::set<std::string> variablesIn(const EffectSpec& spec) {
  std::set<std::string> names;
  for (const auto& [key, value] : spec.keys)
    for (const std::string& item : value.items) {
      if (key == "axis" || key == "of" || key == "with" || key == "joint") names.insert(item);
      if (key == "sensor" || key == "sensors") names.insert({"temperature " + item, "time"});
      if (key == "covariate") names.insert({item});
    }
  if (spec.type == "backlash") names.insert(spec.text("axis") + " speed");
  if (spec.type == "time_drift" || spec.type == "warm_up") names.insert("time");
  if (spec.type == "speed_lag") names.insert({"x speed", "y speed", "z speed"});
  if (spec.type.rfind("probe_", 0) == 0 || spec.type.rfind("laser_", 0) == 0 ||
      spec.type == "artifact_expansion")
    names.insert({"approach x", "approach y", "approach z"});
  return names;
}

}  // namespace

bool sameCause(const EffectSpec& a, const EffectSpec& b) {
  if (a.type != b.type) return false;
  for (const auto& [key, value] : a.keys)
    if (!isShape(key) && (b.find(key) == nullptr || !(*b.find(key) == value))) return false;
  for (const auto& [key, value] : b.keys)
    if (!isShape(key) && a.find(key) == nullptr) return false;
  return true;
}

Eigen::MatrixXd SubsetSearch::shaped(const EffectSpec& spec, const Eigen::MatrixXd& raw) const {
  const std::set<std::string> names = variablesIn(spec);
  std::vector<Eigen::VectorXd> columns;
  for (int k = 0; k < raw.cols(); ++k) {
    if (!(raw.col(k).norm() > 0.0)) continue;
    columns.push_back(raw.col(k));
    for (const Variable& v : variables_) {
      if (names.count(v.name) == 0) continue;
      const bool position = v.symbol == v.name;
      const int order = position ? 6 : 3;
      Eigen::VectorXd before = Eigen::VectorXd::Ones(space_.rows()), now = v.values;
      for (int n = 1; n <= order; ++n) {
        Eigen::VectorXd c = raw.col(k);
        c.head(space_.rows()) = c.head(space_.rows()).cwiseProduct(now);
        columns.push_back(c);
        const Eigen::VectorXd next = ((2 * n + 1) * v.values.cwiseProduct(now) - n * before) / (n + 1);
        before = now;
        now = next;
      }
    }
  }
  Eigen::MatrixXd all(space_.length(), columns.size());
  for (std::size_t k = 0; k < columns.size(); ++k) all.col(static_cast<int>(k)) = columns[k];
  space_.project(all);
  return all;
}

const Eigen::MatrixXd& SubsetSearch::shapeOf(const Chosen& chosen) const {
  const auto key = std::make_pair(chosen.candidate, chosen.nonlinear);
  const auto known = shapes_.find(key);
  if (known != shapes_.end()) return known->second;
  const Candidate& candidate = set_.candidates[chosen.candidate];
  std::vector<double> p;
  for (const Parameter& q : candidate.effect->parameters()) p.push_back(q.start);
  const std::vector<int> nonlinear = candidate.effect->nonlinearParameters();
  for (std::size_t k = 0; k < nonlinear.size(); ++k) p[nonlinear[k]] = chosen.nonlinear[k];
  return shapes_[key] = freshBasis(Eigen::MatrixXd(space_.length(), 0),
                                   shaped(candidate.spec, space_.columns(*candidate.effect, p)));
}

const std::vector<ShapeInModel>& SubsetSearch::shapesInModel() const {
  if (inModel_) return *inModel_;
  inModel_.emplace();
  const Model& model = space_.problem().model();
  const auto& effects = model.effects();
  for (std::size_t e = 0; e < effects.size(); ++e) {
    const EffectSpec& spec = effects[e]->spec();
    bool profile = spec.find("degree") != nullptr;
    for (std::size_t other = 0; other < effects.size(); ++other)
      profile |= other != e && sameCause(effects[other]->spec(), spec);
    if (!profile) continue;
    std::vector<double> p;
    Eigen::VectorXd values(effects[e]->parameterCount());
    for (int k = 0; k < effects[e]->parameterCount(); ++k) {
      p.push_back(space_.fitted().x[model.offset(static_cast<int>(e)) + k]);
      values[k] = p.back() / effects[e]->parameters()[static_cast<std::size_t>(k)].scale;
    }
    for (const int k : effects[e]->nonlinearParameters()) values[k] = 0.0;
    const Eigen::MatrixXd raw = space_.columns(*effects[e], p);
    inModel_->push_back({spec, freshBasis(Eigen::MatrixXd(space_.length(), 0), shaped(spec, raw)),
                         (raw * values).squaredNorm()});
  }
  return *inModel_;
}

Eigen::MatrixXd SubsetSearch::withShapes(const Subset& subset, const EffectSpec* but) const {
  Eigen::MatrixXd all = subset.basis;
  for (const Chosen& c : subset.chosen) {
    if (but != nullptr && sameCause(set_.candidates[c.candidate].spec, *but)) continue;
    const Eigen::MatrixXd fresh = freshBasis(all, shapeOf(c));
    const int before = static_cast<int>(all.cols());
    all.conservativeResize(Eigen::NoChange, before + fresh.cols());
    all.rightCols(fresh.cols()) = fresh;
  }
  return all;
}

bool SubsetSearch::beyond(const Subset& subset, const Eigen::MatrixXd& columns, double choices) const {
  const Subset with = withColumns(subset, columns);
  const double rank = static_cast<double>(with.basis.cols() - subset.basis.cols());
  const double rest = dof_ - static_cast<double>(with.basis.cols());
  if (rank < 1.0 || rest < 1.0) return false;
  return logPValueF((subset.rss - with.rss) / rank / (with.rss / rest), rank, rest) + choices <
         std::log(significance);
}

bool SubsetSearch::standsAlone(const Subset& subset, const Gain& gain) const {
  constexpr double kLeftOver = 0.12;  // of the largest member's share: (0.35)^2
  const EffectSpec& spec = set_.candidates[gain.candidate].spec;
  double largest = 0.0;
  for (std::size_t i = 0; i < subset.chosen.size(); ++i) {
    if (sameCause(set_.candidates[subset.chosen[i].candidate].spec, spec)) return true;
    largest = std::max(largest, without(subset, i).rss - subset.rss);
  }
  if (subset.chosen.empty() || gain.drop >= kLeftOver * largest) return true;
  Subset wide = subset;
  wide.basis = withShapes(subset, &spec);
  wide.left = space_.target() - wide.basis * (wide.basis.transpose() * space_.target());
  wide.rss = wide.left.squaredNorm();
  return significant(evaluate(wide, gain.candidate, gain.nonlinear, gain.columns));
}

bool SubsetSearch::hidden(int candidate, const Eigen::VectorXd& values) const {
  constexpr double kHidden = 30.0;
  return values.cwiseProduct(set_.candidates[candidate].raw).squaredNorm() >
         kHidden * kHidden * space_.target().squaredNorm();
}

bool SubsetSearch::cancelling(const Subset& subset, std::size_t& member) const {
  if (subset.chosen.size() < 2) return false;
  int count = 0;
  for (const Chosen& c : subset.chosen) count += static_cast<int>(c.columns.cols());
  Eigen::MatrixXd all(space_.length(), count);
  int at = 0;
  for (const Chosen& c : subset.chosen) {
    all.middleCols(at, c.columns.cols()) = c.columns;
    at += static_cast<int>(c.columns.cols());
  }
  const Eigen::VectorXd values = all.colPivHouseholderQr().solve(space_.target());
  at = 0;
  for (std::size_t i = 0; i < subset.chosen.size(); ++i) {
    const int n = static_cast<int>(subset.chosen[i].columns.cols());
    if (hidden(subset.chosen[i].candidate, values.segment(at, n))) {
      member = i;
      return true;
    }
    at += n;
  }
  return false;
}

bool SubsetSearch::plausible(const Subset& subset, int candidate, const Eigen::MatrixXd& columns) const {
  constexpr double kBeyond = 1.5;
  const Candidate& c = set_.candidates[candidate];
  Eigen::MatrixXd own = columns;
  if (subset.basis.cols() > 0) own -= subset.basis * (subset.basis.transpose() * columns);
  Eigen::MatrixXd gram = own.transpose() * own;
  Eigen::VectorXd bound(own.cols());  // in units of the scale, as the columns are
  const double variance = std::max(subset.rss, 1e-300) / dof_;
  for (int k = 0; k < own.cols(); ++k) {
    const Parameter& p = c.effect->parameters()[c.linear[static_cast<std::size_t>(k)]];
    bound[k] = p.bound / p.scale;
    gram(k, k) += variance / (bound[k] * bound[k]);  // what is not determined is within its bound
  }
  const Eigen::VectorXd values = gram.ldlt().solve(own.transpose() * subset.left);
  if ((values.cwiseAbs().array() > kBeyond * bound.array()).any()) return false;
  return !hidden(candidate, values);
}

Eigen::MatrixXd SubsetSearch::modulations(const Subset& subset) const {
  std::vector<Eigen::VectorXd> columns;
  for (const Chosen& c : subset.chosen)
    for (int k = 0; k < c.columns.cols(); ++k)
      for (const Variable& v : variables_) {
        if (v.category) continue;
        Eigen::VectorXd product = c.columns.col(k);
        product.head(space_.rows()) = product.head(space_.rows()).cwiseProduct(v.values);
        columns.push_back(product);
      }
  Eigen::MatrixXd all(space_.length(), columns.size());
  for (std::size_t k = 0; k < columns.size(); ++k) all.col(static_cast<int>(k)) = columns[k];
  return all;
}

}  // namespace mm
