#include "diagnosis/diagnose.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <memory>
#include <set>

#include "base/cancel_scope.h"
#include "base/error.h"
#include "base/parallel.h"
#include "diagnosis/answers.h"
#include "diagnosis/drift_report.h"
#include "diagnosis/held_out.h"
#include "diagnosis/question_list.h"
#include "diagnosis/search.h"
#include "diagnosis/shortlist.h"
#include "diagnosis/structure.h"
#include "diagnosis/variation.h"
#include "diagnosis/verdict.h"
#include "diagnosis/wording.h"

namespace mm {
namespace {

constexpr int kFewestFreedoms = 5;  // residuals beyond the unknowns
constexpr int kMostLooks = 3;       // at what stands apart

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
      if (look.found.members.empty() || round + 1 == kMostLooks) break;  // a look is of the fit that it had
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
    }
    dropWhatDoesNothing(look, fitted);
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
    look.space = std::make_unique<ResidualSpace>(fitted);
    Questions& q = look.questions;
    q.space = look.space.get();
    LinearisedRows rows = noiseRows(look.space->linearisation(), look.space->used(), fitted.sigma,
                                    look.space->target(), look.space->basis());
    q.rows = std::move(rows.rows);
    q.directions = std::move(rows.directions);
    q.directionScale = std::move(rows.directionScale);
    addScatter(q);
    q.many = look.space->rows() > options_.manyRows;
    report("questions", 0.1 + 0.2 * round);
    if (q.many) {
      lookAtMany(look, round);
    } else {
      q.groups = QuestionList::causes(*look.space).all();
      q.asked = q.groups.causes;
      Groups profiles = QuestionList::profiles(*look.space).all();
      q.profiles = static_cast<int>(profiles.groups.size());
      append(q.groups, std::move(profiles));
      report("search", 0.2 + 0.2 * round);
      const Search search = searchOf(q);
      look.found = withTails(search, search.run(Eigen::VectorXd::Ones(q.rows.rows())), look);
    }
    lookAtPairs(look);
    look.found = settled(q, std::move(look.found));
    return look;
  }

  /// With all rivals of what was found.
  static Explanation settled(const Questions& q, Explanation found) {
    const Search search = searchOf(q);
    return search.withPairsAsRivals(search.settled(std::move(found)));
  }

  static Search searchOf(const Questions& q) {
    Search search(q);
    search.step = [] { CancelScope::check(); };
    return search;
  }

  /// The search on with the weights that the tails of the noise ask for.
  static Explanation withTails(const Search& search, Explanation found, Look& look) {
    const Tails tails = tailsOf(search, found);
    if (!(tails.dof > 0.0)) return found;
    look.tailDof = tails.dof;
    found.noise.variance = tails.variance;
    return search.improved(found);
  }

  /// A long session: what may be an answer is asked, and when something was found, all again beside it.
  void lookAtMany(Look& look, int round) const {
    Questions& q = look.questions;
    Shortlist list(*look.space, q);
    look.found = searchOf(q).none(Eigen::VectorXd::Ones(q.rows.rows()));
    list.extend(look.found);
    report("search", 0.2 + 0.2 * round);
    look.found = withTails(searchOf(q), searchOf(q).improved(look.found), look);
    if (searchOf(q).couldHideSeveral(look.found)) tryCausesAlone(look, list);
    for (int again = 0; again < kMostLooks && !look.found.members.empty() && list.extend(look.found);
         ++again) {
      report("search", 0.25 + 0.2 * round);
      look.found = searchOf(q).improved(look.found);
    }
  }

  /// The other way: what comes near to being an answer where neither drift nor scatter is there is asked,
  /// too.
  void tryCausesAlone(Look& look, Shortlist& list) const {
    Explanation causes = searchOf(look.questions).bare(look.found);
    for (int again = 0; again < kMostLooks; ++again) {
      if (!list.extend(causes, &look.found) && again > 0) break;
      causes = searchOf(look.questions).causesAlone(std::move(causes));
    }
    look.found = searchOf(look.questions).ofGreaterWorth(std::move(look.found), causes);
  }

  /// Two variables at once, where what was found may be no more than their shadow.
  void lookAtPairs(Look& look) const {
    Questions& q = look.questions;
    report("two variables", 0.5);
    const QuestionList list = QuestionList::pairs(*look.space);
    const Explanation& found = look.found;
    q.pairs = static_cast<int>(list.size());
    // beside what was found, in the place of one of it, in the place of all of it
    const Search of(q);
    const auto noise = of.evidenceAt(found);
    struct Beside {
      std::vector<Member> rest;
      double lost;
    };
    std::vector<Beside> asked = {{found.members, 0.0}};
    const double whole = noise->given(found.members).logEvidence;
    double all = 0.0;
    for (std::size_t j = 0; j < found.members.size(); ++j) {
      std::vector<Member> others = found.members;
      others.erase(others.begin() + static_cast<long>(j));
      const double price = of.priceOf(found.members[j]);
      const double lost = whole - noise->given(others).logEvidence - price;
      all += price;
      asked.push_back({std::move(others), lost + kIndistinct});
    }
    if (found.members.size() > 1)
      asked.push_back({{}, whole - noise->given({}).logEvidence - all + kIndistinct});
    Groups more;
    for (std::size_t first = 0, end = 0; first < list.size(); first = end) {
      end = q.many ? list.endOfPart(first, kShapesTogether) : list.size();
      Groups part = list.made(first, end - first);
      if (part.groups.empty()) continue;
      if (!q.many) q.pairs = static_cast<int>(part.groups.size());
      const Evidence evidence = noise->ofGroups(part);
      std::vector<char> worth(part.groups.size(), 0);
      for (const Beside& beside : asked) {
        for (const Gain& g : evidence.gains(evidence.given(beside.rest)))
          if (g.group >= 0 && g.value - of.priceOfOne(part.groups[g.group]) > beside.lost) worth[g.group] = 1;
        if (!q.many && std::count(worth.begin(), worth.end(), 1) > 0) break;
      }
      if (std::count(worth.begin(), worth.end(), 1) == 0) continue;
      if (!q.many) {
        more = std::move(part);
        break;
      }
      for (std::size_t g = 0; g < part.groups.size(); ++g)
        if (worth[g]) append(more, oneOf(part, g));
    }
    if (more.groups.empty()) return;
    append(q.groups, std::move(more));
    look.found = searchOf(q).improved(found);
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
    out_.noise = found.white * unit * std::sqrt(found.noise.variance.mean());
    out_.noiseStd = found.whiteStd * unit * std::sqrt(found.noise.variance.mean());
    sortByGain(search, found);
    report("held out", 0.7);
    const HeldOut held(search, found);
    out_.heldOutBefore = held.before() * unit;
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
    if (out_.missing.empty() && out_.profiles.empty())
      out_.variations =
          variationsOf(*look.space, out_.candidates, unit, std::max(out_.noise, out_.base.repeatability));
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

  /// Everything that was found in the model, and the weights as they are.
  CalibrationResult refit(const Look& look, const CalibrationResult& fitted,
                          const std::vector<EffectPtr>& effects, const Eigen::VectorXd& start) const {
    CalibrateOptions again = fit_;
    again.rejectOutliers = false;
    again.weights = fitted.weight;
    return calibrate(withScatter(look), modelWith(model_, effects), again, start);
  }

  /// A cause whose size in the model is within its expanded uncertainty was found for the freedom of its
  /// shape alone: its name says nothing, and to add it would do nothing.
  void dropWhatDoesNothing(Look& look, const CalibrationResult& fitted) const {
    bool dropped = false;
    while (!look.found.members.empty()) {
      const Search search = searchOf(look.questions);
      const std::vector<Answer> answers = answersOf(search, look.found);
      const auto evidence = search.evidenceAt(look.found);
      std::vector<EffectPtr> effects;
      const Eigen::VectorXd start = startOf(look, effects);
      std::vector<double> sure;
      try {
        sure = surenessOf(answers, refit(look, fitted, effects, start), model_.parameterCount(),
                          look.found.members.size());
      } catch (const NumericalError&) {
        return;  // what the linearised fit says stands
      }
      std::size_t least = sure.size();
      for (std::size_t j = 0; j < sure.size(); ++j)
        if (sure[j] < 1.0 && !look.questions.groups.groups[look.found.members[j].group].profile &&
            !search.hasCurve(*evidence, look.found.members, j) &&
            (least == sure.size() || sure[j] < sure[least]))
          least = j;
      if (least == sure.size()) break;
      dropped = true;
      // what came with it must now earn its place alone
      look.found = search.pruned(search.without(look.found, least));
    }
    if (dropped) look.found = settled(look.questions, std::move(look.found));
  }

  /// Values and uncertainties by a full refit of the model with everything that was found.
  void refinedParameters(const Look& look, const CalibrationResult& fitted) {
    if (look.found.members.empty()) return;
    std::vector<EffectPtr> effects;
    const Eigen::VectorXd start = startOf(look, effects);
    try {
      const CalibrationResult full = refit(look, fitted, effects, start);
      takeParameters(full, model_.parameterCount(), effects, out_);
      const Search search = searchOf(look.questions);
      const std::vector<char> curves = curvesForTheRest(search, look.found);
      if (std::count(curves.begin(), curves.end(), 1) == 0) return;
      // the size of a cause with a curve for its rest is that without the curve
      const std::vector<Answer> answers = answersOf(search, look.found);
      std::vector<EffectPtr> others;
      Eigen::VectorXd startOfOthers = start.head(model_.parameterCount());
      int at = model_.parameterCount();
      for (std::size_t k = 0; k < effects.size(); ++k) {
        const int count = effects[k]->parameterCount();
        if (!curves[static_cast<std::size_t>(answers[k].member)]) {
          others.push_back(effects[k]);
          const auto before = startOfOthers.size();
          startOfOthers.conservativeResize(before + count);
          startOfOthers.tail(count) = start.segment(at, count);
        }
        at += count;
      }
      const CalibrationResult without = refit(look, fitted, others, startOfOthers);
      takeParameters(without, model_.parameterCount(), others, out_);
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
    Threads(options.calibrate.threads).run([&] { Diagnoser(session, model, options, out).run(start); });
  } catch (const NumericalError& error) {
    out.verdict = Verdict::kInsufficientData;
    out.sentence = std::string("The model cannot be fitted to this session: ") + error.what();
  }
  return out;
}

std::vector<WhereItFails> whereItFails(const CalibrationResult& fitted) {
  const ResidualSpace space(fitted);
  return explainedByVariable(space, space.target(), Eigen::MatrixXd(space.length(), 0));
}

}  // namespace mm
