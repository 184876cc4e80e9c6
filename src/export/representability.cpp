#include "export/representability.h"

#include <algorithm>
#include <cmath>

#include "base/dense.h"
#include "base/format.h"
#include "base/rotation.h"
#include "base/units.h"
#include "effects/inputs.h"
#include "effects/iso230_symbol.h"
#include "export/export_folder.h"

namespace mm {
namespace {

constexpr double kRank = 1e-6;   // of a motion of the whole workpiece: less is rounding
constexpr double kMoves = 1e-9;  // m or rad: a correction that is one constant moves nothing

constexpr int kJudgeStates = 512;
constexpr unsigned kJudgeSeed = 41;  // never that of a table: fresh places
constexpr double kNothing = 1e-10;   // m: rounding of the chain
constexpr double kBelowAll = 5e-9;   // m: less than any of these machines repeats
constexpr double kExactShare = 0.02, kNoneShare = 0.95;

double rms(const Eigen::VectorXd& errors) { return std::sqrt(errors.squaredNorm() / errors.size()); }

/// What is left of displacements (three a place) when one displacement, and where asked one small rotation
/// about the mean place, is taken out of all.
double leftOver(const Eigen::VectorXd& errors, const std::vector<Eigen::Vector3d>& places, bool rotated) {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : places) centre += p / places.size();
  Eigen::MatrixXd rigid = Eigen::MatrixXd::Zero(errors.size(), rotated ? 6 : 3);
  double size = 1e-9;
  for (const Eigen::Vector3d& p : places) size = std::max(size, (p - centre).norm());
  for (std::size_t n = 0; n < places.size(); ++n) {
    const auto row = 3 * static_cast<Eigen::Index>(n);
    rigid.block<3, 3>(row, 0).setIdentity();
    if (!rotated) continue;
    rigid.block<3, 3>(row, 3) = skew((centre - places[n]) / size);
  }
  return rms(errors - rigid * shortestLeastSquares(rigid, errors, kRank));
}

/// Interprets files that nobody has been given yet.
ExportFigures judged(const std::string& target, const NeededCorrection& needed, const Exported& exported) {
  const TriedExport tried(target, exported);
  const LoadedCompensation& loaded = tried.loaded();
  const std::vector<State> states = needed.states(kJudgeStates, kJudgeSeed);
  Eigen::VectorXd before(3 * kJudgeStates), after(3 * kJudgeStates), beside(3 * kJudgeStates);
  std::vector<Eigen::Vector3d> places;
  for (int n = 0; n < kJudgeStates; ++n) {
    const State& state = states[n];
    std::vector<double> motors = state.position;
    const auto drive = [&](const std::map<std::string, double>& added) {
      for (const ExportAxis& axis : needed.axes())
        if (const auto found = added.find(axis.letter); found != added.end())
          motors[axis.joint] += found->second;
    };
    const CommandedState command = needed.commandOf(state);
    drive(loaded.tablesAdd(command));
    if (!exported.alsoAdds) drive(loaded.offsetsAdd(command));  // those that were active and stay
    before.segment<3>(3 * n) = needed.displacement(state);
    after.segment<3>(3 * n) = needed.missed(state, motors);
    if (exported.alsoAdds) {
      drive(exported.alsoAdds(state));
      beside.segment<3>(3 * n) = needed.missed(state, motors);
    }
    places.push_back(needed.model().machine().nominal(state.position.data(), state.laserReading).position);
  }
  ExportFigures figures{leftOver(before, places, true), leftOver(after, places, true),
                        leftOver(before, places, false), leftOver(after, places, false)};
  if (exported.alsoAdds) figures.withOffsets = leftOver(beside, places, true);
  return figures;
}

Calibration oneEffect(const Calibration& whole, int effect) {
  Calibration one = whole;
  one.effects = {whole.effects[effect]};
  one.values.clear();
  std::vector<Eigen::Index> kept;
  for (std::size_t p = 0; p < whole.values.size(); ++p)
    if (whole.values[p].effect == effect) {
      kept.push_back(p);
      one.values.push_back(whole.values[p]);
      one.values.back().effect = 0;
    }
  one.covariance = whole.covariance(kept, kept);
  one.networks.clear();
  for (const LearnedNetwork& network : whole.networks)
    if (network.effect == one.effects[0].yaml()) one.networks.push_back(network);
  return one;
}

std::string listed(const std::vector<std::string>& words) {
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i)
    text += (i == 0 ? "" : i + 1 == words.size() ? " and " : ", ") + words[i];
  return text;
}

/// "moves x and y by the position of x, the travel of x and the temperature bed".
std::string whatItDoes(const NeededCorrection& needed) {
  const Domain& d = needed.model().domain();
  const Inputs in = inputsOf(*needed.model().effects()[0], d);
  std::vector<std::string> by, moves;
  const auto name = [&](int joint) { return needed.axis(joint).letter; };
  for (const int j : in.positions) by.push_back("the position of " + name(j));
  for (const int j : in.travels) by.push_back("the travel of " + name(j));
  for (const int j : in.reversals)
    by.push_back("the way of " + name(j) + " since its last reversal (taken as far from it)");
  for (const int k : in.temperatures) by.push_back("the temperature " + d.sensors[k]);
  for (const int k : in.covariates) by.push_back(d.covariates[k]);
  if (in.time) by.emplace_back("time");
  const Eigen::VectorXd varies = needed.varies(64, kJudgeSeed);
  for (const int joint : needed.linear())
    if (varies[joint] > kMoves) moves.push_back(name(joint));
  return "corrects " + (moves.empty() ? "no axis" : listed(moves)) + (by.empty() ? "" : " by " + listed(by));
}

bool hasValue(const Calibration& c) {
  for (const Calibration::Value& v : c.values)
    if (v.value != 0.0) return true;
  return !c.networks.empty();
}

CarriedEffect carriedEffect(const Calibration& calibration, int index, const ExportTarget& target,
                            const ExportOptions& options) {
  const Calibration one = oneEffect(calibration, index);
  const NeededCorrection needed(one, options.letters);
  CarriedEffect result;
  result.effect = one.effects[0];
  result.iso230 = ErrorSymbols(needed.model().machine()).of(result.effect);
  const Exported exported = exportedFor(target, needed, options);
  result.figures = judged(target.name, needed, exported);
  const ExportFigures& f = result.figures;
  if (f.uncorrected < kNothing && f.unalignedUncorrected < kNothing) {
    const bool any = hasValue(one);
    result.carried = any ? "none" : "exact";
    result.why =
        any ? "it does not change the position of a resting axis: it acts at a contact, on a reading or "
              "during motion, and can only be corrected in the readings (mm apply)"
            : "its parameters are zero";
    return result;
  }
  if (f.uncorrected < kExactShare * f.unalignedUncorrected) {
    result.carried = "exact";
    result.why = "it rotates or shifts the whole workpiece, which the workpiece alignment compensates";
    return result;
  }
  const double share = f.exported / f.uncorrected;
  const bool exact = share <= kExactShare || (share < 0.5 && f.exported < kBelowAll);
  result.carried = exact ? "exact" : share < kNoneShare ? "approximate" : "none";
  result.why = whatItDoes(needed) + "; " + target.title + " holds " + exported.holds +
               format(": %.3g of %.3g um remain", f.exported / kMicrometre, f.uncorrected / kMicrometre);
  for (const std::string& told : exported.notFollowed) result.why += "; " + told;
  return result;
}

}  // namespace

double Representability::unexplained() const {
  return std::isfinite(heldOut) ? std::sqrt(std::max(0.0, heldOut * heldOut - repeatability * repeatability))
                                : heldOut;
}

double Representability::expected(double left) const {
  return std::isfinite(heldOut) ? std::hypot(left, unexplained()) : left;
}

bool Representability::carriesNothing() const {
  return !(figures.exported < kNoneShare * figures.uncorrected);
}

Representability representability(const Calibration& calibration, const ExportTarget& target,
                                  const ExportOptions& options, const NeededCorrection& needed,
                                  const Exported& exported, const ExportProgress& progress) {
  Representability result;
  result.target = target.name;
  result.calibration = calibration.id;
  for (const ExportAxis& axis : needed.axes()) result.letters[axis.name] = axis.letter;
  result.sensors = exported.sensors;
  result.files = exported.files;
  const auto count = static_cast<int>(calibration.effects.size());
  const auto tell = [&](const std::string& what, int done) {
    if (progress) progress(what, (done + 1.0) / (count + 1.0));
  };
  result.figures = judged(target.name, needed, exported);
  tell("all effects", 0);
  result.heldOut = std::isfinite(calibration.heldOutRms) ? calibration.heldOutRms : calibration.rms;
  result.repeatability = calibration.repeatability;
  result.notFollowed = exported.notFollowed;
  for (int e = 0; e < count; ++e) {
    result.effects.push_back(carriedEffect(calibration, e, target, options));
    tell(result.effects.back().effect.type, e + 1);
  }
  return result;
}

}  // namespace mm
