#include "diagnosis/diagnose.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <memory>
#include <set>

#include "base/cancel_scope.h"
#include "base/error.h"
#include "diagnosis/answers.h"
#include "diagnosis/drift_report.h"
#include "diagnosis/held_out.h"
#include "diagnosis/search.h"
#include "diagnosis/structure.h"
#include "diagnosis/wording.h"

namespace mm {
namespace {

constexpr int kFewestFreedoms = 5;  // residuals beyond the unknowns
constexpr int kMostLooks = 3;       // at what stands apart
/// Residuals that the search looks at: of a longer session so many, in stretches. They show a cause of a
/// tenth of the noise (2,000 * 0.1^2 / 2 = 10 nats, the price of a cause); what is found is fitted to all.
constexpr int kMostRows = 2000;

Model modelWith(const Model& model, const std::vector<EffectPtr>& more) {
  std::vector<EffectPtr> effects = model.effects();
  effects.insert(effects.end(), more.begin(), more.end());
  return Model(model.machine(), model.domain(), effects);
}

/// One look at the session: what was fitted, what is asked, what was found.
struct Look {
  std::unique_ptr<ResidualSpace> space;
  Questions questions;
  Explanation found;
  double tailDof = 0.0;
};

class Diagnoser {
 public:
  Diagnoser(const Session& session, const Model& model, const DiagnoseOptions& options, Diagnosis& out)
      : session_(session), model_(model), options_(options), out_(out) {}

  void run(const Eigen::VectorXd& start) {
    report("fit", 0.0);
    fit_ = options_.calibrate;
    fit_.method = Method::kLeastSquares;
    fit_.progress = {};
    fit_.cancelled = options_.cancelled;
    out_.base = calibrate(session_, model_, fit_, start);
    out_.base.problem->linearise(out_.base.x);
    model_ = out_.base.problem->model();  // its networks have learned
    out_.angular = !std::isfinite(out_.base.figures.rms);
    if (out_.base.figures.degreesOfFreedom < kFewestFreedoms)
      throw NumericalError(std::to_string(out_.base.problem->rowCount()) + " residuals leave " +
                           std::to_string(out_.base.figures.degreesOfFreedom) +
                           " degrees of freedom, too few to tell a missing effect from noise; measure more");
    refuseWhatNoPhysicsExplains();
    out_.where = whereItFails(out_.base);

    // outliers may have been structure, and structure may have hidden outliers: look again with what was
    // found in
    CalibrationResult fitted = out_.base;
    Look look;
    for (int round = 0; round < kMostLooks; ++round) {
      look = lookAt(fitted, round);
      if (look.found.members.empty()) break;
      std::vector<EffectPtr> effects;
      const Eigen::VectorXd with = startOf(look, effects);
      CalibrationResult refitted;
      try {
        refitted = calibrate(session_, modelWith(model_, effects), fit_, with);
      } catch (const NumericalError&) {
        break;  // the session cannot determine them beside the rest: they stay as they were found
      }
      if (refitted.weight == fitted.weight) break;
      CalibrateOptions again = fit_;
      again.rejectOutliers = false;
      again.weights = refitted.weight;
      fitted = calibrate(session_, model_, again, fitted.x.head(model_.parameterCount()));
      fitted.problem->linearise(fitted.x);
    }
    conclude(look, fitted);
  }

 private:
  void report(const std::string& stage, double share) const {
    if (options_.cancelled && options_.cancelled()) throw Cancelled("diagnosis cancelled");
    if (options_.progress) options_.progress(stage, share);
  }

  /// No machine errs by a thousand times its repeatability in a way that one of its parts explains: units,
  /// signs or names of the session are asked first.
  void refuseWhatNoPhysicsExplains() const {
    constexpr double kMost = 1000.0;
    const double rms = out_.angular ? out_.base.figures.rmsAngular : out_.base.figures.rms;
    if (out_.base.repeatabilityFrom == "estimated" || !(rms > kMost * out_.base.repeatability)) return;
    throw NumericalError(
        "its residuals are " + shortNumber(rms / out_.base.repeatability) +
        " times the repeatability; look at units, signs and names in the session first (mm check "
        "asks about them)");
  }

  Look lookAt(const CalibrationResult& fitted, int round) const {
    Look look;
    look.space = std::make_unique<ResidualSpace>(fitted, kMostRows);
    Questions& q = look.questions;
    q.space = look.space.get();
    LinearisedRows rows = noiseRows(look.space->problem(), look.space->used(), fitted.sigma,
                                    look.space->target(), look.space->basis());
    q.rows = std::move(rows.rows);
    q.directions = std::move(rows.directions);
    q.directionScale = std::move(rows.directionScale);
    addScatter(q);
    report("questions", 0.1 + 0.2 * round);
    q.groups = makeGroups(*look.space);
    q.asked = q.groups.causes;
    Groups profiles = makeProfiles(*look.space);
    q.profiles = static_cast<int>(profiles.groups.size());
    append(q.groups, std::move(profiles));
    report("search", 0.2 + 0.2 * round);
    Search search(q);
    search.step = [this] { CancelScope::check(); };
    Eigen::VectorXd variance = Eigen::VectorXd::Ones(q.rows.rows());
    look.found = search.run(variance);
    const Tails tails = tailsOf(search, look.found);
    if (tails.dof > 0.0) {
      look.tailDof = tails.dof;
      look.found.noise.variance = tails.variance;
      look.found = search.improved(look.found);
    }
    lookAtPairs(look);
    look.found = Search(q).settled(std::move(look.found));
    return look;
  }

  /// Two variables at once, where what was found may be no more than their shadow.
  void lookAtPairs(Look& look) const {
    Questions& q = look.questions;
    report("two variables", 0.5);
    Questions pairs = q;
    pairs.groups = makePairProfiles(*look.space);
    if (pairs.groups.groups.empty()) return;
    q.pairs = pairs.pairs = static_cast<int>(pairs.groups.groups.size());
    const Search search(pairs);
    const auto evidence = search.evidenceAt(look.found);
    const auto worthAsking = [&](const std::vector<Member>& rest, double lost) {
      const Evidence::Given given = evidence->given(rest);
      for (const Gain& g : evidence->gains(given))
        if (g.value - search.priceOf(g.group) > lost) return true;
      return false;
    };
    const Search of(q);
    const double whole = evidence->given(look.found.members).logEvidence;
    bool ask = worthAsking(look.found.members, 0.0);
    double all = 0.0;
    for (std::size_t j = 0; j < look.found.members.size() && !ask; ++j) {
      std::vector<Member> others = look.found.members;
      others.erase(others.begin() + static_cast<long>(j));
      const double lost = whole - evidence->given(others).logEvidence - of.priceOf(look.found.members[j]);
      all += of.priceOf(look.found.members[j]);
      ask = worthAsking(others, lost + kIndistinct);
    }
    if (!ask && look.found.members.size() > 1)
      ask = worthAsking({}, whole - evidence->given({}).logEvidence - all + kIndistinct);
    if (!ask) return;
    Groups more = std::move(pairs.groups);
    append(q.groups, std::move(more));
    Search again(q);
    again.step = [this] { CancelScope::check(); };
    look.found = again.improved(look.found);
  }

  /// Start values of the model's and the found effects' parameters, from the linearised solution.
  Eigen::VectorXd startOf(const Look& look, std::vector<EffectPtr>& effects) const {
    const auto answers = answersOf(Search(look.questions), look.found);
    Eigen::VectorXd start = look.space->fitted().x.head(model_.parameterCount());
    for (const Answer& a : answers) {
      effects.push_back(a.effect);
      const int first = static_cast<int>(start.size());
      start.conservativeResize(first + a.effect->parameterCount());
      start.tail(a.effect->parameterCount()) = a.start;
    }
    return start;
  }

  void conclude(Look& look, const CalibrationResult& fitted) {
    const Questions& q = look.questions;
    Search search(q);
    search.step = [this] { CancelScope::check(); };
    Explanation& found = look.found;
    const double unit = unitOf(*look.space);
    out_.tailDof = look.tailDof;
    out_.searched = look.space->rows();
    out_.noise = found.white * unit * std::sqrt(found.noise.variance.mean());
    out_.noiseStd = found.whiteStd * unit * std::sqrt(found.noise.variance.mean());
    sortByGain(search, found);
    report("held out", 0.7);
    const HeldOut held(search, found);
    out_.heldOut = held.all() * unit;
    report("answers", 0.85);
    fillAnswers(search, found, held, unit, out_);
    refinedParameters(look, fitted);
    allowForForm(search, found, out_);
    listCandidates(search, found, held, unit, out_);
    listCannotShow(q, found, out_);
    out_.drift = driftOf(search, found);
    fillScatter(q, found, unit, out_);
    fillMissingInputs(q, out_);
    separate(search, found, out_);
    describeProfiles(search, found, held, unit, out_);
    decide(out_);
    out_.sentence = sentenceOf(out_);
  }

  /// The session with an artifact that is known as well as it was found to be: balls that scatter would shift
  /// the sizes of causes, and make them seem surer than they are.
  Session withScatter(const Look& look) const {
    Session session = session_;
    const double unit = look.found.white * unitOf(*look.space);
    const auto both = [](double stated, double found) { return std::sqrt(stated * stated + found * found); };
    for (std::size_t b = 0; b < look.questions.scatter.size(); ++b)
      for (Feature& f : session.artifact.features) {
        const double found = look.found.scatter[b] * unit;
        if (look.questions.scatterNames[b] == "centres" && f.known)
          f.positionStd = both(f.positionStd, found);
        if (look.questions.scatterNames[b] == "radii" && f.kind == FeatureKind::kBall)
          f.radiusStd = both(f.radiusStd, found);
      }
    return session;
  }

  /// Values and uncertainties by a full refit of the model with everything that was found.
  void refinedParameters(const Look& look, const CalibrationResult& fitted) {
    if (look.found.members.empty()) return;
    std::vector<EffectPtr> effects;
    const Eigen::VectorXd start = startOf(look, effects);
    CalibrateOptions again = fit_;
    again.rejectOutliers = false;
    again.weights = fitted.weight;
    const Session session = withScatter(look);
    try {
      const CalibrationResult full = calibrate(session, modelWith(model_, effects), again, start);
      takeParameters(full, model_.parameterCount(), effects, out_);
    } catch (const NumericalError&) {
      // what the linearised fit says stands
    }
  }

  const Session& session_;
  Model model_;
  const DiagnoseOptions& options_;
  Diagnosis& out_;
  CalibrateOptions fit_;
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
