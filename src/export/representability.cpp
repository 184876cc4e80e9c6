#include "export/representability.h"

#include <algorithm>
#include <cmath>

#include "base/dense.h"
#include "base/quantity_words.h"
#include "base/rotation.h"
#include "effects/iso230_symbol.h"
#include "export/export_folder.h"
#include "machine/linear_inverse.h"

namespace mm {
namespace {

constexpr double kRank = 1e-6;  // of a motion of the whole workpiece, or of a direction: less is rounding

constexpr int kJudgeStates = 512;
constexpr unsigned kJudgeSeed = 41;  // never that of a table: fresh places
constexpr double kNothing = 1e-10;   // m: rounding of the chain
constexpr double kBelowAll = 5e-9;   // m: less than any of these machines repeats
constexpr double kExactShare = 0.02, kNoneShare = 0.95;

/// Displacements (three rows a place) without the one displacement, and where asked the one small rotation
/// about the mean place, that an alignment takes out. A column is one error of the machine.
Eigen::MatrixXd aligned(const Eigen::MatrixXd& errors, const std::vector<Eigen::Vector3d>& places,
                        bool rotated) {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : places) centre += p / places.size();
  Eigen::MatrixXd rigid = Eigen::MatrixXd::Zero(errors.rows(), rotated ? 6 : 3);
  double size = 1e-9;
  for (const Eigen::Vector3d& p : places) size = std::max(size, (p - centre).norm());
  for (std::size_t n = 0; n < places.size(); ++n) {
    const Eigen::Index row = 3 * n;
    rigid.block<3, 3>(row, 0).setIdentity();
    if (!rotated) continue;
    rigid.block<3, 3>(row, 3) = skew((centre - places[n]) / size);
  }
  return errors - rigid * shortestLeastSquares(rigid, errors, kRank);
}

/// The machine at the states by which an export is judged: errors three rows a place, m.
struct Driven {
  std::vector<State> states;
  std::vector<Eigen::Vector3d> places;
  Eigen::VectorXd before, after, beside;  // beside: with the external offsets; empty: there are none
  std::vector<int> directions;            // of workpiece, along which the session moved or the model errs
  std::vector<std::string> notMoved;      // other directions, along which a linear axis could have moved
};

double meanSquare(const Eigen::VectorXd& errors, int direction) {
  return errors(Eigen::seqN(direction, errors.size() / 3, 3)).squaredNorm() / (errors.size() / 3);
}

/// Of a coordinate.
double rms(const Eigen::VectorXd& errors, const std::vector<int>& directions) {
  double sum = 0.0;
  for (const int d : directions) sum += meanSquare(errors, d);
  return directions.empty() ? 0.0 : std::sqrt(sum / directions.size());
}

std::string nameOf(int direction) { return std::string(1, static_cast<char>('x' + direction)); }

void findDirections(const NeededCorrection& needed, Driven& driven) {
  const State& state = driven.states.front();
  const Eigen::Matrix3Xd byJoint =
      needed.model().machine().jacobian(state.position.data(), state.laserReading).topRows<3>();
  const Eigen::VectorXd errors = aligned(driven.before, driven.places, true);
  std::vector<int> moved;
  for (const int joint : needed.linear())
    if (needed.moved(joint)) moved.push_back(joint);
  for (int d = 0; d < 3; ++d) {
    const auto reach = [&](const std::vector<int>& joints) {
      return linearMotion(joints, byJoint, Eigen::Vector3d::Unit(d)).missed < 1.0 - kRank;
    };
    if (reach(moved) || std::sqrt(meanSquare(errors, d)) > kBelowAll)
      driven.directions.push_back(d);
    else if (reach(needed.linear()))
      driven.notMoved.push_back(nameOf(d));
  }
}

/// Interprets files that nobody has been given yet.
Driven drivenBy(const std::string& target, const NeededCorrection& needed, const Exported& exported) {
  const std::unique_ptr<const LoadedCompensation> loaded = triedExport(target, exported);
  Driven driven;
  driven.states = needed.states(kJudgeStates, kJudgeSeed);
  driven.before.resize(3 * kJudgeStates);
  driven.after.resize(3 * kJudgeStates);
  if (exported.offsets) driven.beside.resize(3 * kJudgeStates);
  for (int n = 0; n < kJudgeStates; ++n) {
    const State& state = driven.states[n];
    std::vector<double> motors = state.position;
    const auto drive = [&](const std::map<std::string, double>& added) {
      for (const ExportAxis& axis : needed.axes())
        if (const auto found = added.find(axis.letter); found != added.end())
          motors[axis.joint] += found->second;
    };
    const CommandedState command = needed.commandOf(state);
    drive(loaded->tablesAdd(command));
    if (!exported.offsets) drive(loaded->offsetsAdd(command));  // those that were active and stay
    driven.before.segment<3>(3 * n) = needed.displacement(state);
    driven.after.segment<3>(3 * n) = needed.missed(state, motors);
    if (exported.offsets) {
      drive(loaded->offsetsAdd(command));
      driven.beside.segment<3>(3 * n) = needed.missed(state, motors);
    }
    driven.places.push_back(
        needed.model().machine().nominal(state.position.data(), state.laserReading).position);
  }
  findDirections(needed, driven);
  return driven;
}

ExportFigures figuresOf(const Driven& driven) {
  const auto left = [&](const Eigen::VectorXd& errors, bool rotated) {
    return rms(aligned(errors, driven.places, rotated), driven.directions);
  };
  ExportFigures figures{left(driven.before, true), left(driven.after, true), left(driven.before, false),
                        left(driven.after, false)};
  if (driven.beside.size() > 0) figures.withOffsets = left(driven.beside, true);
  return figures;
}

/// What is left along some directions. @param byRoot a column: the model's change, alignment taken out, by
/// one standard deviation of an independent combination of its parameters, so that byRoot byRoot' is its
/// covariance.
LeftOfModel leftOf(const Eigen::VectorXd& errors, const Eigen::MatrixXd& byRoot,
                   const std::vector<int>& directions) {
  const auto places = byRoot.rows() / 3;
  const double count = places * directions.size();
  Eigen::MatrixXd products = Eigen::MatrixXd::Zero(byRoot.cols(), byRoot.cols());
  Eigen::VectorXd across = Eigen::VectorXd::Zero(byRoot.cols());
  for (const int d : directions) {
    const Eigen::MatrixXd g = byRoot(Eigen::seqN(d, places, 3), Eigen::all);
    const Eigen::VectorXd left = errors(Eigen::seqN(d, places, 3));
    products += g.transpose() * g / count;
    across += g.transpose() * left / count;
  }
  // of the mean of (left + g z)^2 with z normal: its variance
  return {rms(errors, directions), std::sqrt(products.trace()),
          std::sqrt(2.0 * products.squaredNorm() + 4.0 * across.squaredNorm())};
}

std::vector<LeftAlong> leftAlong(const Driven& driven, const NeededCorrection& needed) {
  const Eigen::MatrixXd byRoot = aligned(needed.uncertain(driven.states), driven.places, true);
  const Eigen::VectorXd nothing = Eigen::VectorXd::Zero(driven.before.size());
  const Eigen::VectorXd before = aligned(driven.before, driven.places, true),
                        after = aligned(driven.after, driven.places, true);
  std::vector<LeftAlong> along;
  const auto add = [&](const std::string& name, const std::vector<int>& directions) {
    LeftAlong one{name,
                  leftOf(before, byRoot, directions),
                  leftOf(after, byRoot, directions),
                  {},
                  leftOf(nothing, byRoot, directions)};
    if (driven.beside.size() > 0)
      one.withOffsets = leftOf(aligned(driven.beside, driven.places, true), byRoot, directions);
    along.push_back(std::move(one));
  };
  if (driven.directions.size() != 1) add("", driven.directions);
  for (const int d : driven.directions) add(nameOf(d), {d});
  return along;
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
  result.figures = figuresOf(drivenBy(target.name, needed, exported));
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
  result.why = target.title + " holds " + exported.holds + ": " + errorInWords(f.exported, false) + " of " +
               errorInWords(f.uncorrected, false) + " remain";
  for (const std::string& told : exported.notFollowed) result.why += "; " + told;
  return result;
}

}  // namespace

double Representability::unexplained() const {
  return std::isfinite(heldOut) ? std::sqrt(std::max(0.0, heldOut * heldOut - repeatability * repeatability))
                                : heldOut;
}

ExpectedError Representability::expected(const LeftOfModel& left) const {
  const double byParameters = left.byParameters * left.byParameters;
  const double byResiduals = unexplained() * unexplained();
  if (!std::isfinite(byResiduals)) return {byResiduals, 0.0};
  ExpectedError error;
  error.rms = std::sqrt(left.rms * left.rms + std::max(byParameters, byResiduals));
  const double ofResiduals = byResiduals > byParameters && degreesOfFreedom > 0.0
                                 ? heldOut * heldOut * std::sqrt(2.0 / degreesOfFreedom)
                                 : 0.0;
  error.std = error.rms > 0.0 ? std::hypot(left.squareStd, ofResiduals) / (2.0 * error.rms) : 0.0;
  return error;
}

ExpectedError Representability::measured(const LeftOfModel& left) const {
  const ExpectedError at = expected(left);
  const double rms = std::hypot(at.rms, repeatability);
  return {rms, rms > 0.0 ? at.std * at.rms / rms : 0.0};
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
  const int count = calibration.effects.size();
  const auto tell = [&](const std::string& what, int done) {
    if (progress) progress(what, (done + 1.0) / (count + 1.0));
  };
  const Driven driven = drivenBy(target.name, needed, exported);
  result.figures = figuresOf(driven);
  result.along = leftAlong(driven, needed);
  result.notMoved = driven.notMoved;
  tell("all effects", 0);
  result.heldOut = std::isfinite(calibration.heldOutRms) ? calibration.heldOutRms : calibration.rms;
  result.repeatability = calibration.repeatability;
  result.degreesOfFreedom = calibration.degreesOfFreedom;
  result.notFollowed = exported.notFollowed;
  for (int e = 0; e < count; ++e) {
    result.effects.push_back(carriedEffect(calibration, e, target, options));
    tell(result.effects.back().effect.type, e + 1);
  }
  return result;
}

}  // namespace mm
