#include "diagnosis/diagnose.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <set>

#include "base/cancel_scope.h"
#include "base/error.h"
#include "base/parallel.h"
#include "diagnosis/answers.h"
#include "diagnosis/drift_report.h"
#include "diagnosis/full_fit.h"
#include "diagnosis/held_out.h"
#include "diagnosis/likely_shapes.h"
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
    if (!out_.questions.empty()) return;
    if (out_.base.figures.degreesOfFreedom < kFewestFreedoms)
      throw NumericalError(std::to_string(out_.base.problem->rowCount()) + " residuals leave " +
                           std::to_string(out_.base.figures.degreesOfFreedom) +
                           " degrees of freedom, too few to tell a missing effect from noise; measure more");
    refuseWhatNoPhysicsExplains();

    // outliers may have been structure, and structure may have hidden outliers: look again with what was
    // found in
    CalibrationResult fitted = out_.base;
    out_.notJudged = leaveOutUnknownTravel(fitted.weight);
    const FullFit full(session_, model_, fit_);
    Look look;
    for (int round = 0; round < kMostLooks; ++round) {
      look = lookAt(fitted, round);
      if (look.found.members.empty() || round + 1 == kMostLooks) break;  // a look is of the fit that it had
      const FullFit::Start with = full.startOf(look);
      CalibrationResult refitted;
      try {
        refitted = calibrate(session_, full.with(with.found), fit_, with.x);
      } catch (const NumericalError&) {
        break;  // the session cannot determine them beside the rest: they stay as they were found
      }
      leaveOutUnknownTravel(refitted.weight);
      if (refitted.weight == fitted.weight) break;
      CalibrateOptions again = fit_;
      again.rejectOutliers = false;
      again.weights = refitted.weight;
      fitted = calibrate(session_, model_, again, fitted.x.head(model_.parameterCount()));
    }
    if (look.posterior == nullptr) full.dropWhatDoesNothing(look, fitted);
    conclude(look, fitted, full);
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

  /// Before a joint first moved its direction of travel is not known. A play has no value there, and what
  /// needs no direction, as a jump at the reversal, would explain these rows too, and win by them: all causes
  /// are judged by the same rows.
  std::vector<NotJudged> leaveOutUnknownTravel(Eigen::VectorXd& weight) const {
    std::vector<NotJudged> left;
    constexpr int kMost = 5;  // one observation in so many; more are a session without directions
    const Problem& problem = *out_.base.problem;
    const auto count = static_cast<int>(session_.observations.size());
    for (int j = 0; j < session_.machine.jointCount(); ++j) {
      bool up = false, down = false;
      std::vector<int> unknown;
      for (int o = 0; o < count; ++o) {
        const double travel = problem.state(o).travel[j];
        up |= travel > 0.0;
        down |= travel < 0.0;
        if (travel == 0.0) unknown.push_back(o);
      }
      if (!up || !down || static_cast<int>(unknown.size()) * kMost > count) continue;
      if (!unknown.empty())
        left.push_back(
            {session_.machine.joints()[static_cast<std::size_t>(j)].name, static_cast<int>(unknown.size())});
      for (const int o : unknown)
        for (int i = problem.firstRow(o); i < problem.firstRow(o + 1); ++i) weight[i] = 0.0;
    }
    return left;
  }

  Look lookAt(const CalibrationResult& fitted, int round) const {
    Look look;
    look.space = std::make_unique<ResidualSpace>(fitted);
    Questions& q = look.questions;
    q.space = look.space.get();
    LinearisedRows rows = noiseRows(look.space->linearisation(), look.space->used(), fitted.sigma,
                                    look.space->target(), look.space->basis());
    q.rows = std::move(rows.rows);
    q.rows.sinceFirst = options_.method == DiagnosisMethod::kPosterior;
    q.directions = std::move(rows.directions);
    q.directionScale = std::move(rows.directionScale);
    spreadOverResolution(q);
    addScatter(q);
    q.many = look.space->rows() > options_.manyRows;
    report("questions", 0.1 + 0.2 * round);
    if (options_.method == DiagnosisMethod::kPosterior) {
      drawFromPosterior(look, fitted, round);
      return look;
    }
    if (q.many) {
      lookAtMany(look, round);
    } else {
      q.groups = QuestionList::causes(*look.space).all();
      q.asked = q.groups.causes;
      Groups profiles = QuestionList::profiles(*look.space).all();
      q.profiles = static_cast<int>(profiles.groups.size());
      append(q.groups, std::move(profiles));
      report("search", 0.2 + 0.2 * round);
      const Search search(q);
      look.found = withTails(search, search.run(Eigen::VectorXd::Ones(q.rows.rows())), look);
    }
    lookAtPairs(look);
    look.found = Search(q).settledWithPairs(std::move(look.found));
    return look;
  }

  /// All questions together, answered by one sample.
  void drawFromPosterior(Look& look, const CalibrationResult& fitted, int round) const {
    Questions& q = look.questions;
    const double stated = statedFreedomsOf(fitted);
    LikelyShapes likely(*look.space, q, stated);
    report("posterior", 0.2 + 0.2 * round);
    const auto draw = [&](const Eigen::VectorXd& variance) {
      if (look.posterior == nullptr)
        likely.walk(variance);
      else
        likely.weigh(variance, *look.posterior);
      for (int again = 0; again < kMostLooks; ++again) {
        look.posterior = std::make_shared<PosteriorAnswer>(
            explainByPosterior(q, variance, stated, likely.starts(), options_.seed));
        if (again + 1 == kMostLooks || !likely.extend(*look.posterior, again == 0)) break;
      }
      look.found = look.posterior->found;
    };
    draw(Eigen::VectorXd::Ones(q.rows.rows()));
    const Tails tails = tailsOf(Search(q), look.found);
    look.tailDof = tails.dof;
    if (tails.dof > 0.0) draw(tails.variance);
    likely.appendTheRest(*look.posterior);
  }

  /// A name must also predict: a cause that does not clearly lower the error of rows that were not seen may
  /// act, and is not named.
  static void dropWhatPredictsNothing(Look& look) {
    const Search search(look.questions);
    const Questions rows = rowsOf(look.questions);
    const Search ofRows(rows);
    look.likeliest = look.found;
    while (!look.found.members.empty()) {
      const HeldOut held(ofRows, look.found, false);
      const auto evidence = search.evidenceAt(look.found);
      std::size_t least = 0;
      double worth = std::numeric_limits<double>::infinity();
      for (std::size_t j = 0; j < look.found.members.size(); ++j) {
        const std::vector<Member> others = search.beside(*evidence, look.found.members, j);
        const double of = held.worthOf(look.found.members[j], others);
        if (of < worth) worth = of, least = j;
      }
      if (worth > kPredicts) break;
      const int group = look.found.members[least].group;
      const bool again = !look.doubted
                              .emplace(look.questions.groups.groups[static_cast<std::size_t>(group)].key,
                                       0.5 * std::erfc(-worth / std::sqrt(2.0)))
                              .second;
      if (look.posterior == nullptr) {
        look.found = search.without(look.found, least);
        if (!again) look.found = search.settledWithPairs(std::move(look.found));  // it may come back once
        continue;
      }
      for (Slot& slot : look.posterior->slots)
        if (slot.named && slot.causes.front() == group) slot.named = false;
      std::vector<Member> kept = look.found.members;
      kept.erase(kept.begin() + static_cast<long>(least));
      look.found = search.refitted(kept, look.found, false);
    }
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
    look.found = Search(q).none(Eigen::VectorXd::Ones(q.rows.rows()));
    list.extend(look.found);
    report("search", 0.2 + 0.2 * round);
    look.found = withTails(Search(q), Search(q).improved(look.found), look);
    if (Search(q).couldHideSeveral(look.found)) tryCausesAlone(look, list);
    for (int again = 0; again < kMostLooks && !look.found.members.empty() && list.extend(look.found);
         ++again) {
      report("search", 0.25 + 0.2 * round);
      look.found = Search(q).improved(look.found);
    }
  }

  /// The other way: what comes near to being an answer where neither drift nor scatter is there is asked,
  /// too.
  void tryCausesAlone(Look& look, Shortlist& list) const {
    Explanation causes = Search(look.questions).bare(look.found);
    for (int again = 0; again < kMostLooks; ++again) {
      if (!list.extend(causes, &look.found) && again > 0) break;
      causes = Search(look.questions).causesAlone(std::move(causes));
    }
    look.found = Search(look.questions).ofGreaterWorth(std::move(look.found), causes);
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
    look.found = Search(q).improved(found);
  }

  /// Columns of what scatters from place to place.
  static RowMatrix scatterOf(const Questions& q, const Explanation& found) {
    RowMatrix columns(q.rows.length(), 0);
    for (std::size_t b = 0; b < q.scatter.size(); ++b) {
      if (!(found.scatter[b] > 0.0)) continue;
      const RowMatrix& more = q.scatter[b].columns;
      columns.conservativeResize(Eigen::NoChange, columns.cols() + more.cols());
      columns.rightCols(more.cols()) = more;
    }
    return columns;
  }

  void conclude(Look& look, const CalibrationResult& fitted, const FullFit& full) {
    const Questions& q = look.questions;
    const Search search(q);
    Explanation& found = look.found;
    const double unit = unitOf(*look.space);
    out_.tailDof = look.tailDof;
    out_.resolution = q.resolution;
    dropWhatPredictsNothing(look);
    sortByGain(search, found);
    report("held out", 0.7);
    const HeldOut held(search, found, look.posterior == nullptr);
    out_.heldOutBefore = held.before() * unit;
    out_.heldOut = held.all() * unit;
    report("answers", 0.85);
    fillAnswers(search, found, held, unit, out_);
    full.takeSizes(look, fitted, out_);
    allowForForm(search, found, out_);
    DriftReport drift = driftOf(search, found);
    out_.drift = std::move(drift.drift);
    listCandidates(search, look.likeliest, look.doubted, held, unit, out_);
    listCannotShow(q, found, out_);
    const double white = unit * std::sqrt(drift.spokenOf.noise.variance.mean());
    out_.where = explainedByVariable(*look.space, &search.evidenceAt(found)->whitener(), scatterOf(q, found));
    out_.noise = drift.spokenOf.white * white;
    out_.noiseStd = search.whiteStdOf(drift.spokenOf) * white;
    if (look.posterior != nullptr) takeOdds(q, *look.posterior, out_);
    fillScatter(search, found, unit, out_);
    fillMissingInputs(q, out_);
    separate(search, found, out_);
    describeProfiles(search, found, held, unit, out_);
    if (look.posterior == nullptr && out_.missing.empty() && out_.profiles.empty())
      out_.variations =
          variationsOf(*look.space, out_.candidates, unit, std::max(out_.noise, out_.base.repeatability));
    decide(out_);
    out_.sentence = sentenceOf(out_);
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
  for (Doubt& d : sensibleDoubts(session))
    if (d.first) out.questions.push_back(std::move(d));
  try {
    Threads(options.calibrate.threads).run([&] { Diagnoser(session, model, options, out).run(start); });
  } catch (const NumericalError& error) {
    out.verdict = Verdict::kInsufficientData;
    out.sentence = std::string("The model cannot be fitted to this session: ") + error.what();
  }
  if (!out.questions.empty()) {
    out.verdict = Verdict::kQuestion;
    out.sentence = sentenceOf(out);
  }
  return out;
}

std::vector<WhereItFails> whereItFails(const CalibrationResult& fitted) {
  return explainedByVariable(ResidualSpace(fitted), nullptr, {});
}

}  // namespace mm
