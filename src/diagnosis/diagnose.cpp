#include "diagnosis/diagnose.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <memory>

#include "diagnosis/alternatives.h"
#include "diagnosis/harmonics.h"
#include "diagnosis/imitators.h"
#include "diagnosis/judge.h"
#include "diagnosis/next_measurement.h"
#include "diagnosis/round.h"
#include "diagnosis/structure.h"
#include "diagnosis/unknown_effect.h"
#include "diagnosis/wording.h"
#include "effects/registry.h"
#include "machine/cancel_scope.h"
#include "machine/error.h"
#include "machine/units.h"

namespace mm {
namespace {

constexpr double kStable = 0.3;   // share of resampled sessions in which an effect must be the choice
constexpr double kChance = 1.05;  // what an effect of chance may lower the held-out RMS by
constexpr double kAlike = 0.7;    // of what an effect explains, that others in its place explain
constexpr std::size_t kMostAlike = 4;
constexpr int kFewestFreedoms = 5;  // residuals beyond the unknowns

Model modelWith(const Model& model, const std::vector<EffectPtr>& more) {
  std::vector<EffectPtr> effects = model.effects();
  effects.insert(effects.end(), more.begin(), more.end());
  return Model(model.machine(), model.domain(), effects);
}

/// RMS (m or rad) of a whitened length-squared over the rows.
double unitOf(const ResidualSpace& space, bool angular) {
  double sum = 0.0;
  int n = 0;
  for (int i : space.used())
    if (space.problem().rows()[i].angular == angular) sum += space.fitted().sigma[i], ++n;
  return n > 0 ? sum / n : 1.0;
}

class Diagnoser {
 public:
  Diagnoser(const Session& session, const Model& model, const DiagnoseOptions& options, Diagnosis& out)
      : session_(session), model_(model), options_(options), out_(out) {}

  void run(const Eigen::VectorXd& start) {
    report("fit", 0.0);
    CalibrateOptions fit = options_.calibrate;
    fit.method = Method::kLeastSquares;
    fit.progress = {};
    fit.cancelled = options_.cancelled;
    out_.base = calibrate(session_, model_, fit, start);
    out_.base.problem->linearise(out_.base.x);
    model_ = out_.base.problem->model();  // its networks have learned
    out_.angular = !std::isfinite(out_.base.figures.rms);
    if (out_.base.figures.degreesOfFreedom < kFewestFreedoms)
      throw NumericalError(std::to_string(out_.base.problem->rowCount()) + " residuals leave " +
                           std::to_string(out_.base.figures.degreesOfFreedom) +
                           " degrees of freedom, too few to tell a missing effect from noise; measure more");

    // outliers may have been structure, and structure may have hidden outliers: look again with what was
    // found in
    CalibrationResult fitted = out_.base;
    std::vector<Chosen> before;
    std::vector<EffectSpec> harmonics;
    for (int round = 0;; ++round) {
      auto at = std::make_unique<Round>(fitted, harmonics);
      at->search.cancelled = options_.cancelled;
      report("search", 0.2 + 0.2 * round);
      Subset found = at->search.run();
      std::vector<EffectSpec> more = harmonicsBeside(*at, found);
      if (!more.empty()) {
        more.insert(more.end(), harmonics.begin(), harmonics.end());
        auto other = std::make_unique<Round>(fitted, more);
        other->search.cancelled = options_.cancelled;
        Subset again = other->search.run();
        if (keepsCauses(*at, found, *other, again)) {
          at = std::move(other);
          found = std::move(again);
          harmonics = std::move(more);
        }
      }
      const Round& now = *at;
      if (round == 0) {
        const HeldOutJudge judge(now.space);
        listCandidates(now, judge);
        listCannotShow(now);
      }
      if (round == 2 || found.chosen.empty()) {
        conclude(now, found);
        return;
      }
      // the weights of the observations under the refitted model decide whether to search again
      std::vector<EffectPtr> effects;
      Eigen::VectorXd full = startOf(now, found, effects);
      const CalibrationResult refitted = calibrate(session_, modelWith(model_, effects), fit, full);
      if (refitted.weight == fitted.weight) {
        conclude(now, found);
        return;
      }
      CalibrationResult again = out_.base;
      again.weight = refitted.weight;
      again = refit(again);
      fitted = again;
    }
  }

 private:
  void report(const std::string& stage, double share) const {
    if (options_.cancelled && options_.cancelled()) throw Cancelled("diagnosis cancelled");
    if (options_.progress) options_.progress(stage, share);
  }

  /// The base model fitted with given weights.
  CalibrationResult refit(const CalibrationResult& with) const {
    CalibrateOptions fit = options_.calibrate;
    fit.method = Method::kLeastSquares;
    fit.progress = {};
    fit.rejectOutliers = false;
    fit.weights = with.weight;
    CalibrationResult r = calibrate(session_, model_, fit, with.x.head(model_.parameterCount()));
    r.problem->linearise(r.x);
    return r;
  }

  /// Start values of the model's and the chosen effects' parameters, from the linearised solution.
  Eigen::VectorXd startOf(const Round& round, const Subset& subset, std::vector<EffectPtr>& effects) const {
    Eigen::VectorXd start = round.space.fitted().x.head(model_.parameterCount());
    for (std::size_t i = 0; i < subset.chosen.size(); ++i) {
      const Chosen& c = subset.chosen[i];
      const Candidate& candidate = round.set.candidates[c.candidate];
      effects.push_back(candidate.effect);
      const int first = static_cast<int>(start.size());
      start.conservativeResize(first + candidate.effect->parameterCount());
      for (int k = 0; k < candidate.effect->parameterCount(); ++k)
        start[first + k] = candidate.effect->parameters()[k].start;
    }
    Eigen::MatrixXd all(round.space.length(), 0);
    for (const Chosen& c : subset.chosen) {
      const Eigen::MatrixXd columns = round.set.columnsAt(round.space, c.candidate, c.nonlinear);
      all.conservativeResize(Eigen::NoChange, all.cols() + columns.cols());
      all.rightCols(columns.cols()) = columns;
    }
    if (all.cols() == 0) return start;
    const Eigen::VectorXd values = all.colPivHouseholderQr().solve(round.space.target());
    int at = 0, first = model_.parameterCount();
    for (const Chosen& c : subset.chosen) {
      const Candidate& candidate = round.set.candidates[c.candidate];
      for (int k : candidate.linear)
        start[first + k] += values[at++] * candidate.effect->parameters()[k].scale;
      const std::vector<int> nonlinear = candidate.effect->nonlinearParameters();
      for (std::size_t k = 0; k < nonlinear.size(); ++k) start[first + nonlinear[k]] = c.nonlinear[k];
      first += candidate.effect->parameterCount();
    }
    return start;
  }

  CandidateResult resultOf(const Round& round, const HeldOutJudge& judge, const Subset& rest,
                           const Gain& gain) const {
    CandidateResult r;
    const Candidate& candidate = round.set.candidates[gain.candidate];
    const double unit = unitOf(round.space, out_.angular);
    r.effect = candidate.spec;
    r.cause = candidate.effect->cause();
    r.remedy = candidate.effect->remedy();
    r.pValue = std::exp(round.search.correctedLogP(gain));
    r.size = std::sqrt(gain.drop / std::max(1, round.space.rows())) * unit;
    const Subset with = round.search.extend(rest, {gain.candidate, gain.nonlinear, gain.columns});
    r.heldOutBefore = judge.rms(rest.basis) * unit;
    r.heldOutAfter = judge.rms(with.basis) * unit;
    // values by the projected columns
    Eigen::MatrixXd columns = round.set.columnsAt(round.space, gain.candidate, gain.nonlinear);
    if (rest.basis.cols() > 0) columns -= rest.basis * (rest.basis.transpose() * columns);
    const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(columns);
    const Eigen::VectorXd values = qr.solve(rest.left);
    const double variance = with.rss / std::max(1.0, round.search.degreesOfFreedom() - with.basis.cols());
    const Eigen::MatrixXd inverse =
        (columns.transpose() * columns).completeOrthogonalDecomposition().pseudoInverse();
    for (std::size_t k = 0; k < candidate.linear.size(); ++k) {
      const Parameter& p = candidate.effect->parameters()[candidate.linear[k]];
      r.parameters.push_back(
          {p.name, p.unit, values[static_cast<int>(k)] * p.scale * p.toUnit,
           std::sqrt(std::max(0.0, variance * inverse(k, k))) * p.scale * std::abs(p.toUnit)});
    }
    const std::vector<int> nonlinear = candidate.effect->nonlinearParameters();
    for (std::size_t k = 0; k < nonlinear.size(); ++k) {
      const Parameter& p = candidate.effect->parameters()[nonlinear[k]];
      r.parameters.push_back({p.name, p.unit, gain.nonlinear[k] * p.toUnit, kNotMeasured});
    }
    return r;
  }

  void listCandidates(const Round& round, const HeldOutJudge& judge) {
    const Subset none = round.search.empty();
    for (const Gain& g : round.search.bestGains(none, static_cast<int>(round.set.candidates.size()), false))
      out_.candidates.push_back(resultOf(round, judge, none, g));
  }

  void listCannotShow(const Round& round) {
    constexpr double kHidden = 30.0;  // an effect may be this many times the noise and still not be seen
    for (std::size_t i = 0; i < round.set.candidates.size(); ++i) {
      const Candidate& c = round.set.candidates[i];
      std::string why = c.why;
      if (c.tried) {
        double best = 0.0;  // share of the effect that is left after refit
        for (const Atom& a : round.set.atoms) {
          if (a.candidate != static_cast<int>(i)) continue;
          std::vector<double> p;
          for (const Parameter& q : c.effect->parameters()) p.push_back(q.start);
          const std::vector<int> nonlinear = c.effect->nonlinearParameters();
          for (std::size_t k = 0; k < nonlinear.size(); ++k) p[nonlinear[k]] = a.nonlinear[k];
          const Eigen::MatrixXd raw = round.space.columns(*c.effect, p);
          Eigen::MatrixXd left = raw;
          round.space.project(left);
          for (int k : c.linear)
            if (raw.col(k).norm() > 0.0) best = std::max(best, left.col(k).norm() / raw.col(k).norm());
          if (best * std::sqrt(static_cast<double>(round.space.rows())) * kHidden > 5.0) break;
        }
        if (best * std::sqrt(static_cast<double>(round.space.rows())) * kHidden > 5.0) continue;
        why = "the model's other unknowns absorb nearly all of it here";
      }
      out_.cannotShow.push_back(
          {c.spec, why.empty() ? "nothing in this session excites it" : why, c.effect->shownBy()});
    }
  }

  /// The members in the order in which the held-out RMS falls fastest.
  static Subset inOrder(const Round& round, const HeldOutJudge& judge, const Subset& found) {
    Subset sorted = round.search.empty();
    std::vector<Chosen> left = found.chosen;
    while (!left.empty()) {
      std::size_t first = 0;
      double best = 1e300;
      for (std::size_t i = 0; i < left.size(); ++i) {
        const double rms = judge.rms(round.search.extend(sorted, left[i]).basis);
        if (rms < best) best = rms, first = i;
      }
      sorted = round.search.extend(sorted, left[first]);
      left.erase(left.begin() + static_cast<long>(first));
    }
    return sorted;
  }

  void conclude(const Round& round, Subset found) {
    report("unknown effects", 0.7);
    const HeldOutJudge judge(round.space);
    // a member must also help on held-out data
    for (std::size_t i = 0; i < found.chosen.size();) {
      const Subset rest = round.search.without(found, i);
      if (judge.rms(found.basis) < judge.rms(rest.basis)) {
        ++i;
      } else {
        found = rest;
        i = 0;
      }
    }
    found = inOrder(round, judge, withoutImitators(round, found));
    const UnknownEffect beyond = lookBeyond(round, judge, found, [this] { report("unknown effects", 0.75); });
    out_.shapeLeft = beyond.shapeLeft;
    const Subset& kept = beyond.kept;

    const double unit = unitOf(round.space, out_.angular);
    report("judge", 0.85);
    Subset grown = round.search.empty();
    for (std::size_t i = 0; i < kept.chosen.size(); ++i) {
      const Chosen& c = kept.chosen[i];
      Gain g;
      g = round.search.gainOf(grown, c.candidate, c.nonlinear, false);
      CandidateResult r = resultOf(round, judge, grown, g);
      std::vector<Gain> rivals;
      r.confusableWith = alternatives(round, kept, i, rivals);
      const Subset rest = round.search.without(kept, i);
      const Gain own = round.search.gainOf(rest, c.candidate, c.nonlinear, false);
      r.pValue = std::exp(round.search.correctedLogP(own));
      r.size = std::sqrt(own.drop / std::max(1, round.space.rows())) * unit;
      std::vector<Gain> apart;  // what cannot be told apart is no loss of stability
      for (const Gain& v : rivals)
        if (std::none_of(r.confusableWith.begin(), r.confusableWith.end(), [&](const Confusable& f) {
              return f.effect == round.set.candidates[v.candidate].spec;
            }))
          apart.push_back(v);
      r.stability = stability(round.space, round.set, rest, own, apart, round.search.degreesOfFreedom(),
                              options_.seed + i);
      if (r.stability < kStable && judge.rms(rest.basis) < kChance * judge.rms(kept.basis)) {
        out_.missing.clear();  // without it, then
        conclude(round, round.search.without(kept, i));
        return;
      }
      if (r.stability < kStable)  // something like it acts: what takes its place is as likely
        for (const Gain& v : apart)
          if (v.drop > kAlike * own.drop && r.confusableWith.size() < kMostAlike)
            r.confusableWith.push_back(
                {round.set.candidates[v.candidate].spec, std::max(0.0, v.objective - own.objective)});
      out_.missing.push_back(std::move(r));
      grown = round.search.extend(grown, c);
    }
    refinedParameters(round, kept);
    for (const JudgedFormula& f : beyond.formulas)
      out_.formulas.push_back({f.formula.spec, f.before * unit, f.after * unit});
    out_.where =
        explainedByVariable(round.space, round.space.target(), Eigen::MatrixXd(round.space.length(), 0));
    out_.formulaFirst = beyond.formulaFirst && !out_.formulas.empty();
    const bool unknown = !out_.formulas.empty() || beyond.beyondShapes;
    const bool confusable = std::any_of(out_.missing.begin(), out_.missing.end(),
                                        [](auto& m) { return !m.confusableWith.empty(); });
    out_.verdict = unknown                 ? Verdict::kUnknownEffect
                   : confusable            ? Verdict::kConfusable
                   : !out_.missing.empty() ? Verdict::kMissingEffect
                                           : Verdict::kExplained;
    if (confusable) separate(round, kept);
    out_.sentence = sentenceOf(out_, explainedByVariable(round.space, kept.left, kept.basis));
  }

  /// Values and uncertainties by a full refit of the model with everything that was accepted.
  void refinedParameters(const Round& round, const Subset& kept) {
    if (kept.chosen.empty()) return;
    std::vector<EffectPtr> effects;
    const Eigen::VectorXd start = startOf(round, kept, effects);
    CalibrateOptions fit = options_.calibrate;
    fit.method = Method::kLeastSquares;
    fit.progress = {};
    fit.rejectOutliers = false;
    fit.weights = round.space.fitted().weight;
    const CalibrationResult full = calibrate(session_, modelWith(model_, effects), fit, start);
    int at = model_.parameterCount();
    for (std::size_t i = 0; i < effects.size(); ++i) {
      out_.missing[i].parameters.clear();
      for (const Parameter& p : effects[i]->parameters()) {
        out_.missing[i].parameters.push_back(
            {p.name, p.unit, full.x[at] * p.toUnit, full.std(at) * std::abs(p.toUnit)});
        ++at;
      }
    }
  }

  void separate(const Round& round, const Subset& kept) {
    for (std::size_t i = 0; i < kept.chosen.size(); ++i) {
      if (out_.missing[i].confusableWith.empty()) continue;
      const Subset rest = round.search.without(kept, i);
      std::vector<Hypothesis> rivals;
      for (const Confusable& c : out_.missing[i].confusableWith)
        for (std::size_t k = 0; k < round.set.candidates.size(); ++k)
          if (round.set.candidates[k].spec == c.effect) {
            for (const Gain& g : round.search.bestGains(rest, 12, true))
              if (g.candidate == static_cast<int>(k))
                rivals.push_back({round.set.candidates[k].effect, g.nonlinear});
          }
      const Hypothesis own{round.set.candidates[kept.chosen[i].candidate].effect, kept.chosen[i].nonlinear};
      out_.nextMeasurement = nextMeasurement(round.space, own, rivals);
      return;
    }
  }

  const Session& session_;
  Model model_;
  const DiagnoseOptions& options_;
  Diagnosis& out_;
};

}  // namespace

Diagnosis diagnose(const Session& session, const Model& model, const DiagnoseOptions& options,
                   const Eigen::VectorXd& start) {
  Diagnosis out;
  const CancelScope scope(options.cancelled);
  try {
    Diagnoser(session, model, options, out).run(start);
  } catch (const NumericalError& error) {
    out.verdict = Verdict::kInsufficientData;
    out.sentence = std::string("The model cannot be fitted to this session: ") + error.what();
  }
  return out;
}

std::vector<WhereItFails> whereItFails(const CalibrationResult& fitted) {
  fitted.problem->linearise(fitted.x);
  const ResidualSpace space(fitted);
  return explainedByVariable(space, space.target(), Eigen::MatrixXd(space.length(), 0));
}

}  // namespace mm
