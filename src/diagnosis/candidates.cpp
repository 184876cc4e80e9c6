#include "diagnosis/candidates.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "diagnosis/harmonics.h"
#include "effects/registry.h"
#include "machine/cancel_scope.h"
#include "machine/error.h"
#include "machine/two_threads.h"

namespace mm {
namespace {

/// Distinct positions that a periodic term of an axis needs: its parameters and three more.
constexpr int kMoreThanParameters = 3;
const char* const kScrew = "lead_screw_periodic";

bool sameSpec(const EffectSpec& a, const EffectSpec& b) {
  if (a.type != b.type || a.keys.size() != b.keys.size()) return false;
  for (const auto& [key, value] : a.keys) {
    const EffectSpec::Value* other = b.find(key);
    if (other == nullptr || !(*other == value)) return false;
  }
  return true;
}

int distinctPositions(const Problem& problem, int joint) {
  std::vector<double> q;
  for (std::size_t o = 0; o < problem.session().observations.size(); ++o)
    q.push_back(problem.state(static_cast<int>(o)).position[joint]);
  std::sort(q.begin(), q.end());
  const double apart = 1e-4 * std::max(q.back() - q.front(), 1e-9);
  int count = 1;
  for (std::size_t i = 1; i < q.size(); ++i) count += q[i] - q[i - 1] > apart;
  return count;
}

/// Nonlinear parameters at `nonlinear`, all others at their scale (their columns do not depend on it).
std::vector<double> pointOf(const Effect& effect, const std::vector<double>& nonlinear) {
  std::vector<double> p;
  for (const Parameter& q : effect.parameters()) p.push_back(q.start);
  const std::vector<int> indices = effect.nonlinearParameters();
  for (std::size_t k = 0; k < indices.size(); ++k) p[indices[k]] = nonlinear[k];
  return p;
}

Eigen::MatrixXd rawColumns(const ResidualSpace& space, const Candidate& c,
                           const std::vector<double>& nonlinear, int* missing) {
  const Eigen::MatrixXd all = space.columns(*c.effect, pointOf(*c.effect, nonlinear), missing);
  Eigen::MatrixXd columns(all.rows(), c.linear.size());
  for (std::size_t k = 0; k < c.linear.size(); ++k) columns.col(static_cast<int>(k)) = all.col(c.linear[k]);
  return columns;
}

/// Candidate::cost of the linear parameters. @param columns projected, in units of the parameters' scale.
double costOf(const Eigen::MatrixXd& columns, double observations) {
  constexpr double kUnseen = 1e-9;
  const Eigen::VectorXd seen =
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(columns.transpose() * columns, Eigen::EigenvaluesOnly)
          .eigenvalues();
  double cost = 0.0;
  for (const double s : seen)
    if (s > kUnseen * seen.maxCoeff())
      cost += 0.5 * std::max(1.0, std::log1p(observations * s / seen.maxCoeff()));
  return cost;
}

/// Decides whether the session can show the candidate at all, from raw and projected columns of one of its
/// atoms.
std::string invisible(const Eigen::MatrixXd& raw, const Eigen::MatrixXd& projected) {
  const double before = raw.norm(), after = projected.norm();
  if (!(before > 0.0)) return "nothing in this session excites it";
  if (after < 1e-4 * before) return "the model's other unknowns absorb it completely";
  return "";
}

}  // namespace

Eigen::MatrixXd CandidateSet::columnsAt(const ResidualSpace& space, int candidate,
                                        const std::vector<double>& nonlinear) const {
  Eigen::MatrixXd columns = rawColumns(space, candidates[candidate], nonlinear, nullptr);
  space.project(columns);
  return columns;
}

namespace {

/// Whether the session cannot show an effect for reasons that need no columns; empty: it may.
std::string notTried(const Problem& problem, const Candidate& c) {
  const Domain& domain = problem.model().domain();
  std::string why;
  for (const char* key :
       {"axis", "of", "with", "joint"}) {  // a law of a position needs more than one position
    const int joint = domain.findJoint(c.spec.text(key));
    const bool names = c.spec.type == "thermal_bending" || c.spec.type == "backlash" ||
                       c.spec.type.rfind("rotary_zero", 0) == 0;
    if (joint < 0 || names || domain.upper[joint] - domain.lower[joint] > 1e-9) continue;
    why = c.spec.text(key) + " never moved";
  }
  if (c.spec.type == kScrew && why.empty()) {
    const int joint = domain.findJoint(c.spec.text("axis"));
    if (joint >= 0 && distinctPositions(problem, joint) < c.freeParameters + kMoreThanParameters)
      why = "too few distinct positions of " + c.spec.text("axis") + " to tell a period";
  }
  return why;
}

}  // namespace

CandidateSet makeCandidates(const ResidualSpace& space, const std::vector<EffectSpec>& extra) {
  CandidateSet set;
  const Problem& problem = space.problem();
  const Domain& domain = problem.model().domain();
  std::vector<EffectSpec> harmonics = harmonicsInModel(space);
  harmonics.insert(harmonics.end(), extra.begin(), extra.end());
  for (const EffectType& type : effectRegistry()) {
    if (type.composite || !type.candidates) continue;
    std::vector<EffectSpec> specs = type.candidates(domain);
    for (const EffectSpec& spec : harmonics)
      if (spec.type == type.type) specs.push_back(spec);
    for (const EffectSpec& spec : specs) {
      const auto& in = problem.model().effects();
      if (std::any_of(in.begin(), in.end(), [&](const EffectPtr& e) { return sameSpec(e->spec(), spec); }))
        continue;
      Candidate c;
      c.spec = spec;
      c.effect = type.create(spec, domain);
      const std::vector<int> nonlinear = c.effect->nonlinearParameters();
      for (int k = 0; k < c.effect->parameterCount(); ++k)
        if (std::find(nonlinear.begin(), nonlinear.end(), k) == nonlinear.end()) c.linear.push_back(k);
      c.freeParameters = c.effect->parameterCount();
      c.why = notTried(problem, c);
      c.tried = c.why.empty();
      set.candidates.push_back(std::move(c));
    }
  }

  // columns, by two threads: each candidate is independent of the others
  struct Made {
    std::vector<Atom> atoms;
    std::vector<Eigen::MatrixXd> columns;
  };
  std::vector<Made> made(set.candidates.size());
  const CancelScope* scope = CancelScope::current();
  const double observations = std::max(2.0, static_cast<double>(space.length() - space.baseRank()));
  const auto work = [&](std::size_t begin, std::size_t stride) {
    for (std::size_t i = begin; i < set.candidates.size(); i += stride) {
      Candidate& c = set.candidates[i];
      if (!c.tried) continue;
      std::vector<std::vector<double>> starts = c.effect->searchStarts();
      if (starts.empty()) starts.push_back({});
      std::string why;
      // a wave of which the session saw less than two lengths is a smooth profile, not a period
      double longest = 1e300;
      if (c.spec.type == kScrew) {
        const int joint = domain.findJoint(c.spec.text("axis"));
        if (joint >= 0) longest = 0.5 * (domain.upper[joint] - domain.lower[joint]);
      }
      for (const std::vector<double>& start : starts) {
        if (scope != nullptr && scope->asked()) return;
        if (!start.empty() && start[0] > longest) continue;
        int missing = 0;
        const Eigen::MatrixXd raw = rawColumns(space, c, start, &missing);
        if (10 * missing > space.rows()) {
          why = "an input is not known for " + std::to_string(missing) + " of " +
                std::to_string(space.rows()) + " residuals";
          break;
        }
        Eigen::MatrixXd columns = raw;
        space.project(columns);
        why = invisible(raw, columns);
        if (!why.empty()) continue;
        if (made[i].atoms.empty()) c.raw = raw.colwise().norm();
        if (made[i].atoms.empty())
          c.cost = costOf(columns, observations) +
                   0.5 * std::log(observations) * static_cast<double>(c.effect->nonlinearParameters().size());
        Atom atom;
        atom.candidate = static_cast<int>(i);
        atom.nonlinear = start;
        atom.count = static_cast<int>(columns.cols());
        atom.norms = columns.colwise().norm();
        for (int k = 0; k < columns.cols(); ++k)
          if (atom.norms[k] > 0.0) columns.col(k) /= atom.norms[k];
        made[i].atoms.push_back(atom);
        made[i].columns.push_back(std::move(columns));
      }
      if (made[i].atoms.empty()) {
        c.tried = false;
        c.why = why;
      }
      c.logTried = std::log(std::max<std::size_t>(1, made[i].atoms.size()));
    }
  };
  inTwo([&](std::size_t half) { work(half, 2); });
  CancelScope::check();

  int total = 0;
  for (const Made& m : made)
    for (const Atom& a : m.atoms) total += a.count;
  set.columns.resize(space.length(), total);
  int at = 0;
  for (Made& m : made)
    for (std::size_t k = 0; k < m.atoms.size(); ++k) {
      m.atoms[k].first = at;
      set.columns.middleCols(at, m.atoms[k].count) = m.columns[k];
      at += m.atoms[k].count;
      set.atoms.push_back(m.atoms[k]);
    }
  set.logTried = std::log(std::max<std::size_t>(1, set.atoms.size()));
  return set;
}

}  // namespace mm
