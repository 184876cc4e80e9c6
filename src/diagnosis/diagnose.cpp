#include "diagnosis/diagnose.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <set>

#include "base/cancel_scope.h"
#include "base/error.h"
#include "base/parallel.h"
#include "diagnosis/answers.h"
#include "diagnosis/drift_report.h"
#include "diagnosis/full_fit.h"
#include "diagnosis/held_out.h"
#include "diagnosis/likely_shapes.h"
#include "diagnosis/model_shapes.h"
#include "diagnosis/name_checks.h"
#include "diagnosis/question_list.h"
#include "diagnosis/search.h"
#include "diagnosis/structure.h"
#include "diagnosis/verdict.h"
#include "diagnosis/wording.h"

namespace mm {
namespace {

constexpr int kFewestFreedoms = 5;  // residuals beyond the unknowns
constexpr int kMostLooks = 3;       // at what stands apart
constexpr int kMostSamples = 3;     // until none of all questions is likely beside what the last one found

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
    std::optional<LikelyShapes> likely;
    for (int round = 0; round < kMostLooks; ++round) {
      look = lookAt(fitted, round);
      likely.emplace(*look.space, look.questions, statedFreedomsOf(fitted));
      walk(look, *likely);
      // a look is of the fit that it had
      if (look.found.members.empty() || round + 1 == kMostLooks || !weighAgain(full, look, fitted)) break;
    }
    draw(look, *likely, statedFreedomsOf(fitted));
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
        " times the repeatability; first check units, signs and names in the session (mm check)");
  }

  /// Before a joint first moved its direction of travel is not known, nor its way since a reversal. A play
  /// has no value there, and what needs no direction, as a jump at the reversal, would explain these rows
  /// too, and win by them: all causes are judged by the same rows.
  std::vector<NotJudged> leaveOutUnknownTravel(Eigen::VectorXd& weight) const {
    std::vector<NotJudged> left;
    constexpr int kMost = 5;  // one observation in so many; more are a session without directions
    const Problem& problem = *out_.base.problem;
    const auto count = static_cast<int>(session_.observations.size());
    for (int j = 0; j < session_.machine.jointCount(); ++j) {
      bool up = false, down = false;
      std::vector<int> unknown, unknownWay;
      for (int o = 0; o < count; ++o) {
        const double travel = problem.state(o).travel[j];
        up |= travel > 0.0;
        down |= travel < 0.0;
        if (travel == 0.0) unknown.push_back(o);
        if (travel == 0.0 || std::isnan(problem.state(o).sinceReversalOf(j))) unknownWay.push_back(o);
      }
      const bool directionKnown = unknown.empty();
      if (static_cast<int>(unknownWay.size()) * kMost <= count) unknown = std::move(unknownWay);
      if (!up || !down || static_cast<int>(unknown.size()) * kMost > count) continue;
      if (!unknown.empty())
        left.push_back({session_.machine.joints()[static_cast<std::size_t>(j)].name,
                        static_cast<int>(unknown.size()), directionKnown});
      for (const int o : unknown)
        for (int i = problem.firstRow(o); i < problem.firstRow(o + 1); ++i) weight[i] = 0.0;
    }
    return left;
  }

  /// Bad readings come one at a time and anywhere: what came together was no bad reading.
  OutliersSetAside outliersOf(const CalibrationResult& fitted) const {
    constexpr double kByChance = 0.01;  // that so many bad readings have a ball in common
    constexpr int kFewest = 3;          // of which one after the other is no accident in any session
    const Problem& problem = *fitted.problem;
    const auto& all = session_.observations;
    Eigen::VectorXd known = Eigen::VectorXd::Ones(problem.rowCount());
    leaveOutUnknownTravel(known);
    OutliersSetAside out;
    std::set<int> observations;
    std::map<int, int> ofFeature, setAsideOf;  // observations
    for (std::size_t o = 0; o < all.size(); ++o)
      ofFeature[all[o].feature] += problem.uses(static_cast<int>(o));
    for (int i = 0; i < problem.rowCount(); ++i) {
      const int o = problem.rows()[i].observation;
      if (fitted.weight[i] > 0.0 || known[i] == 0.0 || !problem.uses(o)) continue;
      if (observations.insert(o).second) ++setAsideOf[all[o].feature];
      out.largest = std::max(out.largest, std::abs(fitted.residuals[i]));
    }
    out.readings = static_cast<int>(observations.size());
    if (out.readings < kFewest) return out;
    const auto& balls = session_.artifact.features;
    const int feature = setAsideOf.begin()->first;
    const double share = ofFeature[feature] / static_cast<double>(all.size());
    if (setAsideOf.size() == 1 && feature >= 0 && std::pow(share, out.readings - 1) < kByChance)
      out.inCommon = "of " + balls[static_cast<std::size_t>(feature)].name;
    else if (*observations.rbegin() - *observations.begin() + 1 == out.readings)
      out.inCommon = "one after the other";
    return out;
  }

  /// What is asked grows with the number of residuals, and a long session says more than enough: of the
  /// others the weight becomes 0.
  void askStretches(Eigen::VectorXd& weight) const {
    constexpr int kStretch = 10;
    std::vector<int> used;
    for (int i = 0; i < weight.size(); ++i)
      if (weight[i] > 0.0) used.push_back(i);
    if (static_cast<int>(used.size()) <= options_.mostRows) return;
    Eigen::VectorXd asked = Eigen::VectorXd::Zero(weight.size());
    for (const int k : stretches(static_cast<int>(used.size()), options_.mostRows, kStretch))
      asked[used[static_cast<std::size_t>(k)]] = weight[used[static_cast<std::size_t>(k)]];
    weight = std::move(asked);
  }

  Look lookAt(const CalibrationResult& fitted, int round) const {
    Look look;
    look.fitted = std::make_unique<CalibrationResult>(fitted);
    askStretches(look.fitted->weight);
    look.space = std::make_unique<ResidualSpace>(*look.fitted);
    Questions& q = look.questions;
    q.space = look.space.get();
    LinearisedRows rows = noiseRows(look.space->linearisation(), look.space->used(), fitted.sigma,
                                    look.space->target(), look.space->basis());
    q.rows = std::move(rows.rows);
    q.rows.sinceFirst = true;
    q.directions = std::move(rows.directions);
    q.directionScale = std::move(rows.directionScale);
    spreadOverResolution(q);
    addScatter(q);
    report("questions", 0.1 + 0.1 * round);
    return look;
  }

  /// What explains the session at first sight, and the weights of the rows beside it.
  static void walk(Look& look, LikelyShapes& likely) {
    look.variance = Eigen::VectorXd::Ones(look.questions.rows.rows());
    likely.walk(look.variance);
    look.found = likely.found();
    const Tails tails = tailsOf(Search(look.questions), look.found);
    look.tailDof = tails.dof;
    if (!(tails.dof > 0.0)) return;
    look.variance = tails.variance;
    likely.weigh(look.variance);
    look.found = likely.found();
  }

  /// The fit without causes, at the weights that the rows have beside what a look found.
  /// @return whether any is another.
  bool weighAgain(const FullFit& full, const Look& look, CalibrationResult& fitted) const {
    const FullFit::Start with = full.startOf(look, look.found);
    CalibrationResult refitted;
    try {
      refitted = calibrate(session_, full.with(with.found), fit_, with.x);
    } catch (const NumericalError&) {
      return false;  // the session cannot determine them beside the rest: they stay as they were found
    }
    leaveOutUnknownTravel(refitted.weight);
    if (refitted.weight == fitted.weight) return false;
    CalibrateOptions again = fit_;
    again.rejectOutliers = false;
    again.weights = refitted.weight;
    fitted = calibrate(session_, model_, again, fitted.x.head(model_.parameterCount()));
    return true;
  }

  /// All questions together, answered by one sample.
  void draw(Look& look, LikelyShapes& likely, double stated) const {
    report("posterior", 0.4);
    PosteriorProblem problem = problemOf(look.questions, look.questions.groups, stated);
    SampleOptions options;
    options.seed = options_.seed;
    options.starts = likely.starts();
    const int most = std::exchange(options.mostRounds, 1);  // where the posterior is, a short sample says
    for (int again = 0; again < kMostSamples; ++again) {
      if (!likely.extend(samplePosterior(problem, look.variance, options), again == 0)) break;
      problem = problemOf(look.questions, look.questions.groups, stated);
      options.starts = likely.starts();
    }
    options.mostRounds = most;
    look.posterior = answerOf(look.questions, problem, samplePosterior(problem, look.variance, options));
    look.found = look.posterior.found;
    likely.appendTheRest(look.posterior);
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
    out_.asked = look.space->rows();
    out_.residuals = static_cast<int>((fitted.weight.array() > 0.0).count());
    out_.outliers = outliersOf(fitted);
    if (!look.posterior.sample.settled) out_.chainsDiffer = look.posterior.sample.disagreement;
    out_.resolution = q.resolution;
    dropWhatPredictsNothing(look);
    report("held out", 0.7);
    Explanation whole;
    do {
      out_.missing.clear();
      out_.profiles.clear();
      sortByGain(search, found);
      fillAnswers(search, found, HeldOut(search, found), unit, out_);
      whole = withParts(q, look.posterior, found);
      full.takeSizes(look, whole, fitted, out_);
    } while (dropWhatHasNoSize(look, out_));
    const HeldOut held(search, found);
    out_.heldOutBefore = held.before() * unit;
    out_.heldOut = held.all() * unit;
    report("answers", 0.85);
    takeRegularised(search, whole, found.members.size(), out_);
    DriftReport drift = driftOf(search, whole, look.posterior);
    out_.drift = std::move(drift.drift);
    listCandidates(search, found, held, unit, out_);
    listCannotShow(q, found, out_);
    const double white = unit * std::sqrt(drift.spokenOf.noise.variance.mean());
    out_.where = explainedByVariable(*look.space, &search.evidenceAt(found)->whitener(), scatterOf(q, found));
    out_.noise = drift.spokenOf.white * white;
    out_.noiseStd = search.whiteStdOf(drift.spokenOf) * white;
    takeOdds(q, look.posterior, out_);
    fillScatter(search, whole, unit, out_);
    fillMissingInputs(q, out_);
    separate(search, found, out_);
    describeProfiles(search, found, held, unit, out_);
    if (out_.missing.empty() && out_.profiles.empty())
      out_.variations = variationsOf(search, found, out_.candidates, out_.noise,
                                     std::max(out_.noise, out_.base.repeatability));
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
