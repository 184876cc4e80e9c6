#include "verification/verification_plan.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>

#include "base/dense.h"
#include "base/error.h"
#include "base/units.h"
#include "session/copied_rows.h"
#include "session/plan_selection.h"
#include "verification/loading_evidence.h"

namespace mm {
namespace {

constexpr double kFree =
    1e3;  // standard deviation of what nothing is known of, in orthonormal columns' units

Series constantSeries(const std::string& name, const std::string& unit, double lower, double upper) {
  return {name, unit, {0.0}, {0.5 * (lower + upper)}};
}

/// Inputs where they were in the middle of the calibration.
void addInputs(const Domain& domain, Session& session) {
  for (std::size_t s = 0; s < domain.sensors.size(); ++s)
    session.temperatures.push_back(
        constantSeries(domain.sensors[s], "degC", domain.sensorLower[s], domain.sensorUpper[s]));
  for (std::size_t c = 0; c < domain.covariates.size(); ++c)
    session.covariates.push_back(
        constantSeries(domain.covariates[c], "", domain.covariateLower[c], domain.covariateUpper[c]));
}

/// Where a move measures: the ball and the posture, or the position that is read.
std::string placeOf(const PlanMove& move, const Machine& machine) {
  std::string place = std::to_string(move.feature) + "/" + std::to_string(move.joint);
  for (std::size_t j = 0; j < move.position.size(); ++j) {
    if (!byInstrument(move.kind) && machine.joints()[j].kind == JointKind::kLinear) continue;
    constexpr double kSame = 1e-5;  // m or rad
    place += "/" + std::to_string(std::llround(move.position[j] / kSame));
  }
  return place;
}

/// Rows of what is to be learned, an observation each.
std::vector<Eigen::MatrixXd> rowsOf(const FreshPoints& points, const Calibration& calibration) {
  const Eigen::MatrixXd covariance = covarianceOf(points, calibration);
  const Eigen::VectorXd std = covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
  const Eigen::MatrixXd all = beside({kFree * points.space().basis(), points.crossed(),
                                      points.byParameter() * std.asDiagonal(), points.shapes()});
  std::vector<std::vector<int>> of(points.fitted().problem->session().observations.size());
  for (int i = 0; i < points.rows(); ++i) of[points.row(i).observation].push_back(i);
  std::vector<Eigen::MatrixXd> rows;
  for (const std::vector<int>& own : of) rows.emplace_back(all(own, Eigen::all));
  return rows;
}

/// What is known so far of unknowns that each scatter by 1.
class Knowledge {
 public:
  explicit Knowledge(Eigen::Index unknowns) : covariance_(Eigen::MatrixXd::Identity(unknowns, unknowns)) {}
  /// Logarithm by which the determinant would fall.
  double gain(const Eigen::MatrixXd& rows) const {
    Eigen::MatrixXd seen = rows * covariance_ * rows.transpose();
    seen.diagonal().array() += 1.0;
    return std::log(seen.determinant());
  }
  void learn(const Eigen::MatrixXd& rows) {
    const Eigen::MatrixXd across = covariance_ * rows.transpose();
    Eigen::MatrixXd seen = rows * across;
    seen.diagonal().array() += 1.0;
    covariance_ -= across * solveSymmetric(seen, across.transpose());
  }

 private:
  Eigen::MatrixXd covariance_;
};

}  // namespace

std::vector<std::size_t> verificationMoves(const Plan& plan, const Calibration& calibration,
                                           const VerificationSize& size) {
  const Machine machine(calibration.urdf, calibration.machineName);
  std::vector<std::size_t> moves;
  Session session = plannedSession(plan, machine, &moves);
  addInputs(calibration.domain, session);
  session.prepare();
  for (const SetAside& s :
       session.setAside)  // the repetition of a touch is planned to the bit: it is taken once
    if (s.field != kCopiedRow)
      throw InputError(plan.source + ":" + std::to_string(plan.moves[moves[s.row - 1]].line) +
                       ": gives no usable measurement: " + s.why);
  std::vector<std::size_t> usable;
  for (const Observation& o : session.observations) usable.push_back(moves[o.row - 1]);
  moves = std::move(usable);
  CalibrateOptions options;
  if (!(calibration.repeatability > 0.0)) options.repeatability = kMicrometre;
  const FreshPoints points(session, calibration, options, 0);
  const std::vector<Eigen::MatrixXd> rows = rowsOf(points, calibration);
  std::map<std::string, int> taken;
  std::vector<std::string> places;
  for (const std::size_t i : moves) places.push_back(placeOf(plan.moves[i], machine));
  const std::size_t available = std::set<std::string>(places.begin(), places.end()).size();
  const std::size_t wanted = std::min<std::size_t>(available, size.places);
  Knowledge knowledge(rows.empty() ? 0 : rows.front().cols());
  std::vector<char> chosen(moves.size(), 0);
  for (std::size_t pick = 0; pick < wanted * size.touches; ++pick) {
    std::size_t best = moves.size();
    double most = -1.0;
    for (std::size_t i = 0; i < moves.size(); ++i) {
      const auto at = taken.find(places[i]);
      const bool open = at == taken.end() ? taken.size() < wanted : at->second < size.touches;
      if (chosen[i] != 0 || !open || rows[i].rows() == 0) continue;
      const double gain = knowledge.gain(rows[i]);
      if (gain > most) most = gain, best = i;
    }
    if (best == moves.size()) break;  // every place has given what it has
    chosen[best] = 1;
    ++taken[places[best]];
    knowledge.learn(rows[best]);
  }
  std::vector<std::size_t> selected;
  for (std::size_t i = 0; i < moves.size(); ++i)
    if (chosen[i] != 0) selected.push_back(moves[i]);
  return selected;
}

}  // namespace mm
