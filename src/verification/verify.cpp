#include "verification/verify.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "base/error.h"
#include "estimation/residual_space.h"
#include "session/session_hash.h"
#include "verification/figures.h"
#include "verification/loading_evidence.h"
#include "verification/verify_words.h"

namespace mm {
namespace {

constexpr double kNearer = 0.8;  // of the residual: below, another point to linearise at is nearer
constexpr int kOutlierRounds = 3;

bool isLinear(const FreshPoints& points) {
  for (const EffectPtr& effect : points.effects())
    if (!effect->linear() || effect->network() != nullptr) return false;
  return true;
}

/// Linearised where the readings are: with nothing corrected, as calibrated, or to the other side.
std::unique_ptr<FreshPoints> nearestPoints(const Session& session, const Calibration& calibration,
                                           const VerifyOptions& options, const Eigen::VectorXd& weights) {
  const auto at = [&](int factor) {
    if (options.calibrate.cancelled && options.calibrate.cancelled())
      throw Cancelled("stopped before the points were judged; nothing was changed");
    return std::make_unique<FreshPoints>(session, calibration, options.calibrate, factor, weights,
                                         options.exported.get());
  };
  std::unique_ptr<FreshPoints> best = at(options.loaded ? 0 : 1);
  std::vector<int> others = {options.loaded ? 1 : 0};
  if (isLinear(*best)) others.push_back(options.loaded ? 2 : -1);
  for (const int factor : others) {
    std::unique_ptr<FreshPoints> other = at(factor);
    if (other->space().target().norm() < kNearer * best->space().target().norm()) best = std::move(other);
  }
  return best;
}

std::string findingOf(const Decision& decision) {
  if (!decision.tablesSeen && !decision.offsetsSeen) return "too_small";
  if (!decision.hypothesis.exchanges.empty()) return "exchanged";
  if (!decision.hypothesis.uniform()) return "partly";
  return factsOf(decision.hypothesis.state()).finding;
}

/// Whether more is left than the calibration left of its own session.
void compareWithCalibrated(const Calibration& calibration, const ComparedFigures& figures,
                           Verification& found) {
  constexpr double kMore = 1e-3;  // chance
  found.calibratedRms = figures.angular ? calibration.heldOutRmsAngular : calibration.heldOutRms;
  if (!(found.calibratedRms > 0.0) || !(figures.unforeseen > 0.0) || !(calibration.degreesOfFreedom > 0.0))
    return;
  // Correlated noise has fewer freedoms than residuals, there as here.
  const double share = figures.freedoms / std::max<double>(1.0, figures.residuals);
  found.moreLeftPValue = std::exp(logPValueF(std::pow(figures.unforeseen / found.calibratedRms, 2),
                                             figures.freedoms, share * calibration.degreesOfFreedom));
  found.moreLeft = found.moreLeftPValue < kMore;
}

/// What the session and the calibration state of the compensation that was active, against what is asked.
void checkStatements(const Session& session, const Calibration& calibration, const VerifyOptions& options) {
  using Stated = ControllerCompensation::Stated;
  const ControllerCompensation &here = session.compensation, &then = calibration.compensation;
  if (here.stated == Stated::kNot) return;
  const std::string says = session.source + ": states as compensation that was active: " + here.inWords();
  if (options.exported && here != options.exported->statement())
    throw InputError(says + "; the folder of --export holds " + options.exported->statement().inWords() +
                     ": name the folder that was loaded, or import with --compensation FOLDER");
  if (options.loaded && here.stated == Stated::kNone)
    throw InputError(says +
                     ", which contradicts --loaded: omit --loaded, or import with --compensation FOLDER");
  if (!options.loaded && then.stated != Stated::kNot && here != then)
    throw InputError(says + "; the calibration was measured with: " + then.inWords() +
                     ". If its correction was loaded, give --loaded; otherwise measure with the same "
                     "compensation");
}

}  // namespace

std::string whyNotFresh(const Calibration& calibration, const Session& session) {
  std::vector<std::string> used = {calibration.sessionHash}, asked = {sessionHash(session)};
  for (const SessionPart& part : calibration.sessionParts) used.push_back(part.hash);
  for (const Recording& part : session.recordings) asked.push_back(part.hash);
  const auto isUsed = [&](const std::string& hash) {
    return !hash.empty() && std::find(used.begin(), used.end(), hash) != used.end();
  };
  if (std::none_of(asked.begin(), asked.end(), isUsed)) return {};
  return "the calibration was fitted to this session, so none of its points is fresh; measure a few others "
         "(mm plan verify selects them) and verify with them";
}

Verification verify(const Session& session, const Calibration& calibration, const VerifyOptions& options) {
  if (options.exported && !options.loaded)
    throw InputError("--export names the tables that corrected while " + session.source +
                     " was measured: give --loaded as well, or omit --export");
  checkStatements(session, calibration, options);
  std::unique_ptr<FreshPoints> points = nearestPoints(session, calibration, options, {});
  auto system = std::make_unique<PointSystem>(*points, calibration);
  Eigen::VectorXd weights = points->fitted().weight;
  Verification found;
  for (int round = 0; round < kOutlierRounds && !system->outliers().empty(); ++round) {
    for (const int i : system->outliers()) {
      const int row = points->space().used()[i];
      weights[row] = 0.0;
      found.outliers.push_back({row, points->fitted().residuals[row]});
    }
    system.reset();
    points = nearestPoints(session, calibration, options, weights);
    system = std::make_unique<PointSystem>(*points, calibration);
  }
  static_cast<Decision&>(found) = decide(*points, *system, calibration, options.loaded);
  const ComparedFigures figures = beforeAndAfter(*points, *system, found.hypothesis, options.loaded);
  static_cast<BeforeAndAfter&>(found) = figures;
  found.loaded = options.loaded;
  found.finding = findingOf(found);
  std::set<int> observations;
  for (int i = 0; i < points->rows(); ++i) observations.insert(points->row(i).observation);
  found.observations = observations.size();
  fillShares(*points, *system, calibration, options.loaded, found);
  found.better = figures.improvement > kFiguresDiffer;
  compareWithCalibrated(calibration, figures, found);
  if (options.exported) {
    found.target = options.exported->target();
    found.notCarried = rmsOf(*points, points->rest())[0];
  }
  found.verdict = verdictOf(found, figures.improvement);
  found.inWords = sentenceOf(found);
  return found;
}

std::string keepAnswer(const CalibrationStore& store, const Calibration& calibration, const Session& session,
                       const Verification& found) {
  try {
    if (calibration.id.empty() || !store.keeps(calibration.id)) return {};
    CalibrationStore::Verified answer;
    answer.id = calibration.id;
    answer.verdict = nameOf(found.verdict);
    answer.before = found.before.rms;
    answer.after = found.after.rms;
    answer.beforeStd = found.before.std;
    answer.afterStd = found.after.std;
    answer.angular = found.angular;
    answer.points = found.observations;
    answer.session = session.source;
    store.note(answer);
    return {};
  } catch (const InputError& e) {
    return std::string("the verdict is not stored with the calibration: ") + e.what();
  }
}

}  // namespace mm
