#include "verification/fresh_points.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "effects/inputs.h"
#include "machine/linear_inverse.h"
#include "workflow/recalibration.h"

namespace mm {
namespace {

constexpr double kNoChange = 1e-6;  // of the largest change: rounding

/// Sums up the small errors of one effect at one state.
class SlotSink final : public ErrorSink {
 public:
  explicit SlotSink(Eigen::VectorXd& slots) : slots_(slots) {}
  void add(int slot, int, double value, double basis) override { slots_[slot] += value * basis; }
  void value(int slot, double value) override { slots_[slot] += value; }
  void derivative(int, int, double) override {}
  bool wantsDerivatives() const override { return false; }

 private:
  Eigen::VectorXd& slots_;
};

Eigen::VectorXd slotsOf(const Effect& effect, const std::vector<double>& p, const State& state, int size) {
  Eigen::VectorXd slots = Eigen::VectorXd::Zero(size);
  SlotSink sink(slots);
  effect.evaluate(state, p.data(), sink);
  return slots;
}

int observationsOf(const Problem& problem) { return problem.session().observations.size(); }

/// What effects do to each data row: rows x effects.
Eigen::MatrixXd columnsOf(const Problem& problem, const Eigen::MatrixXd& bySlot,
                          const std::vector<EffectPtr>& effects,
                          const std::vector<std::vector<double>>& values) {
  Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(problem.rowCount(), effects.size());
  for (std::size_t e = 0; e < effects.size(); ++e)
    for (int o = 0; o < observationsOf(problem); ++o) {
      const Eigen::VectorXd slots = slotsOf(*effects[e], values[e], problem.state(o), bySlot.cols());
      for (int row = problem.firstRow(o); row < problem.firstRow(o + 1); ++row)
        columns(row, e) = bySlot.row(row).dot(slots);
    }
  return columns;
}

std::vector<double> calibratedValues(const Calibration& calibration, int effect) {
  std::vector<double> values;
  for (const Calibration::Value& v : calibration.values)
    if (v.effect == effect) values.push_back(v.value);
  return values;
}

/// What small errors do to each joint: rotary ones by their own slot, the linear ones by what is left of the
/// tip's displacement.
Eigen::VectorXd perJoint(const Model& model, const State& state, Eigen::VectorXd slots) {
  const Machine& machine = model.machine();
  const double beam = model.domain().laser ? state.laserReading : kNotMeasured;
  const ErrorLayout layout = machine.layout();
  Eigen::VectorXd change = Eigen::VectorXd::Zero(machine.jointCount());
  for (int j = 0; j < machine.jointCount(); ++j) {
    if (machine.joints()[j].kind == JointKind::kLinear) continue;
    change[j] = slots[layout.axis(j)];
    slots[layout.axis(j)] = 0.0;
  }
  const std::vector<double> none(layout.size(), 0.0);
  Eigen::Matrix<double, 6, Eigen::Dynamic> gradient;
  machine.measure(state.position.data(), beam, none.data(), &gradient);
  const Eigen::Vector3d displacement = gradient.topRows<3>() * slots;
  if (!displacement.allFinite()) return Eigen::VectorXd::Constant(machine.jointCount(), kNotMeasured);
  return change + linearMotion(machine, state.position.data(), beam, displacement).change;
}

/// Whether an effect is the machine's: what a controller can correct. Those of the probe and the artifact,
/// and what depends on how a contact is made (approach, speed, beam, ball), are not.
bool isOfTheMachine(const Effect& effect, const Domain& domain) {
  if (effect.nature().stage == Stage::kProbe || effect.nature().stage == Stage::kArtifact) return false;
  const Inputs inputs = inputsOf(effect, domain);
  return !inputs.approach && !inputs.reading && !inputs.feature && inputs.velocities.empty();
}

}  // namespace

FreshPoints::FreshPoints(const Session& session, const Calibration& calibration,
                         const CalibrateOptions& options, int factor, const Eigen::VectorXd& weights,
                         const LoadedExport* exported)
    : exported_(exported) {
  checkMachine(calibration, session);
  sort(calibration, modelOf(calibration));
  fit(session, calibration, options, factor, weights);
  fillColumns(calibration);
  raw_ = space_->target() + factor * whole();
  fillShapes();
}

void FreshPoints::sort(const Calibration& calibration, const Model& whole) {
  for (std::size_t e = 0; e < whole.effects().size(); ++e) {
    const EffectPtr& effect = whole.effects()[e];
    const bool machine = isOfTheMachine(*effect, whole.domain());
    (machine ? machineEffects_ : measuringEffects_).push_back(effect);
    (machine ? indices_ : measuringIndices_).push_back(e);
  }
  for (std::size_t v = 0; v < calibration.values.size(); ++v)
    if (std::find(indices_.begin(), indices_.end(), calibration.values[v].effect) != indices_.end())
      parameters_.push_back(v);
  if (machineEffects_.empty())
    throw InputError("calibration '" + calibration.id +
                     "' corrects no error of the machine (it has no effect of axes, guideways or heat), so "
                     "there is nothing to verify; add an effect with mm add");
}

void FreshPoints::fit(const Session& session, const Calibration& calibration, CalibrateOptions options,
                      int factor, const Eigen::VectorXd& weights) {
  options.method = Method::kLeastSquares;
  options.holdEffects = true;
  options.rejectOutliers = false;
  options.whiteNoise = true;
  const bool declared = session.artifact.repeatability > 0.0;
  if (options.repeatability <= 0.0 && !declared && calibration.repeatability > 0.0)
    options.repeatability = calibration.repeatability;
  std::vector<EffectPtr> effects = measuringEffects_;
  std::vector<int> indices = measuringIndices_;
  const std::size_t measuring = effects.size();
  if (factor != 0) {
    effects.insert(effects.end(), machineEffects_.begin(), machineEffects_.end());
    indices.insert(indices.end(), indices_.begin(), indices_.end());
  }
  std::vector<double> start;
  for (std::size_t e = 0; e < effects.size(); ++e)
    for (const double value : calibratedValues(calibration, indices[e]))
      start.push_back(e < measuring ? value : factor * value);
  const Machine machine(calibration.urdf, calibration.machineName);
  Model model(machine, calibration.domain, effects);
  // Rows that lack an input of the correction say nothing about it.
  const Problem inputs(session, Model(machine, calibration.domain, machineEffects_));
  const Problem rows(session, model);
  options.weights = weights.size() == rows.rowCount() ? weights : Eigen::VectorXd::Ones(rows.rowCount());
  for (int i = 0; i < rows.rowCount(); ++i) {
    const int observation = rows.rows()[i].observation;
    if (!rows.uses(observation) || !inputs.uses(observation)) options.weights[i] = 0.0;
  }
  fitted_ = std::make_unique<CalibrationResult>(calibrate(
      session, std::move(model), options, Eigen::Map<const Eigen::VectorXd>(start.data(), start.size())));
  space_ = std::make_unique<ResidualSpace>(*fitted_);
}

Eigen::MatrixXd FreshPoints::entered(const Eigen::MatrixXd& columns) const {
  Eigen::MatrixXd whitened = space_->whiten(columns);
  space_->project(whitened);
  return whitened;
}

void FreshPoints::fillColumns(const Calibration& calibration) {
  const Linearisation& at = space_->linearisation();
  const Problem& problem = at.problem();
  std::vector<std::vector<double>> values, measuringValues;
  for (const int e : indices_) values.push_back(calibratedValues(calibration, e));
  for (const int e : measuringIndices_) measuringValues.push_back(calibratedValues(calibration, e));

  byEffect_ = entered(columnsOf(problem, at.slotGradients(), machineEffects_, values));
  Eigen::MatrixXd change =
      Eigen::MatrixXd::Zero(observationsOf(problem), problem.model().machine().jointCount());
  for (int o = 0; o < change.rows(); ++o) change.row(o) = takenAway(problem.state(o), values);
  fillAxes(change);
  fillMisplaced(values);

  Eigen::MatrixXd byParameter(problem.rowCount(), parameters_.size());
  Eigen::Index column = 0;
  for (std::size_t e = 0; e < machineEffects_.size(); ++e) {
    const Eigen::MatrixXd columns = at.effectColumns(*machineEffects_[e], values[e]);
    byParameter.middleCols(column, columns.cols()) = columns;
    column += columns.cols();
  }
  byParameter_ = entered(byParameter);

  Eigen::MatrixXd measuring = Eigen::MatrixXd::Zero(problem.rowCount(), 1);
  if (!problem.model().domain().laser)  // where a beam points is no correction that could be left out
    measuring = columnsOf(problem, at.slotGradients(), measuringEffects_, measuringValues).rowwise().sum();
  measuring_ = entered(measuring).col(0);
}

Eigen::VectorXd FreshPoints::takenAway(const State& state,
                                       const std::vector<std::vector<double>>& values) const {
  if (tabled()) return -exported_->adds(state);
  const Model& model = space_->linearisation().problem().model();
  const int size = model.machine().layout().size();
  Eigen::VectorXd slots = Eigen::VectorXd::Zero(size);
  for (std::size_t e = 0; e < machineEffects_.size(); ++e)
    slots += slotsOf(*machineEffects_[e], values[e], state, size);
  return perJoint(model, state, std::move(slots));
}

void FreshPoints::fillAxes(const Eigen::MatrixXd& change) {
  const Linearisation& at = space_->linearisation();
  const Problem& problem = at.problem();
  const Machine& machine = problem.model().machine();
  const ErrorLayout layout = machine.layout();
  const double size = change.array().isFinite().select(change, 0.0).cwiseAbs().maxCoeff();
  for (int j = 0; j < machine.jointCount(); ++j)
    if (change.col(j).array().isFinite().select(change.col(j), 0.0).cwiseAbs().maxCoeff() >
        kNoChange * size) {
      axisJoints_.push_back(j);
      axes_.push_back(machine.joints()[j].name);
    }
  if (!fillOffsets() && axes_.empty() && tabled())
    throw InputError(
        problem.session().source +
        ": the tables add nothing at these points, so there is nothing to verify; mm plan verify selects "
        "points that show the correction");
  const int count = axisCount();
  Eigen::MatrixXd crossed(problem.rowCount(), count * count);
  for (int i = 0; i < problem.rowCount(); ++i)
    for (int a = 0; a < count; ++a)
      for (int b = 0; b < count; ++b)
        crossed(i, a * count + b) = at.slotGradients()(i, layout.axis(axisJoints_[a])) *
                                    change(problem.rows()[i].observation, axisJoints_[b]);
  crossed_ = entered(crossed);
}

bool FreshPoints::fillOffsets() {
  const Linearisation& at = space_->linearisation();
  const Problem& problem = at.problem();
  const ErrorLayout layout = problem.model().machine().layout();
  Eigen::MatrixXd column = Eigen::MatrixXd::Zero(problem.rowCount(), 1);
  if (hasOffsets())
    for (int o = 0; o < observationsOf(problem); ++o) {
      const Eigen::VectorXd added = exported_->offsetsAdd(problem.state(o));
      for (int row = problem.firstRow(o); row < problem.firstRow(o + 1); ++row)
        for (Eigen::Index j = 0; j < added.size(); ++j)
          column(row, 0) -= at.slotGradients()(row, layout.axis(j)) * added[j];
    }
  offsets_ = entered(column).col(0);
  return offsets_.norm() > 0.0;
}

void FreshPoints::fillMisplaced(const std::vector<std::vector<double>>& values) {
  const Linearisation& at = space_->linearisation();
  const Problem& problem = at.problem();
  const Model& model = problem.model();
  const Machine& machine = model.machine();
  const ErrorLayout layout = machine.layout();
  const Domain& domain = model.domain();
  const auto linear = [&](int joint) { return machine.joints()[joint].kind == JointKind::kLinear; };
  for (int a = 0; a < axisCount(); ++a)
    for (int b = a + 1; b < axisCount(); ++b) {
      const int first = axisJoints_[a], second = axisJoints_[b];
      if (!linear(first) || !linear(second)) continue;
      Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(problem.rowCount(), 2);
      for (int o = 0; o < observationsOf(problem); ++o) {
        State state = problem.state(o);
        // A table ends where its axis was calibrated.
        const double one = std::clamp(state.position[second], domain.lower[first], domain.upper[first]);
        state.position[second] =
            std::clamp(state.position[first], domain.lower[second], domain.upper[second]);
        state.position[first] = one;
        std::swap(state.travel[first], state.travel[second]);
        std::swap(state.velocity[first], state.velocity[second]);
        model.place(state);
        const Eigen::VectorXd change = takenAway(state, values);
        for (int row = problem.firstRow(o); row < problem.firstRow(o + 1); ++row) {
          columns(row, 0) = at.slotGradients()(row, layout.axis(first)) * change[second];
          columns(row, 1) = at.slotGradients()(row, layout.axis(second)) * change[first];
        }
      }
      const Eigen::MatrixXd whitened = entered(columns);
      misplaced_.push_back({b, a, whitened.col(0)});
      misplaced_.push_back({a, b, whitened.col(1)});
    }
}

Eigen::VectorXd FreshPoints::rest() const {
  Eigen::VectorXd rest = whole() - offsets_;
  for (int a = 0; a < axisCount(); ++a) rest -= own(a);
  return rest;
}

bool FreshPoints::angular() const {
  for (int i = 0; i < rows(); ++i)
    if (!row(i).angular) return false;
  return true;
}

void FreshPoints::fillShapes() {
  const Linearisation& at = space_->linearisation();
  const Problem& problem = at.problem();
  const Machine& machine = problem.model().machine();
  const Domain& domain = problem.model().domain();
  const ErrorLayout layout = machine.layout();
  const int joints = machine.jointCount();
  constexpr double kShare = 0.3;  // of the whole correction
  Eigen::MatrixXd shapes = Eigen::MatrixXd::Zero(problem.rowCount(), joints * (joints + 1));
  for (int i = 0; i < problem.rowCount(); ++i) {
    const State& state = problem.state(problem.rows()[i].observation);
    int column = 0;
    for (int a = 0; a < joints; ++a) {
      const double gradient = at.slotGradients()(i, layout.axis(a));
      for (int j = 0; j < joints; ++j) {
        const double range = domain.upper[j] - domain.lower[j];
        shapes(i, column++) = range > kStoodStill
                                  ? gradient * (2.0 * (state.position[j] - domain.lower[j]) / range - 1.0)
                                  : 0.0;
      }
      const double travel = state.travel[a];
      shapes(i, column++) = std::isfinite(travel) ? gradient * travel : 0.0;
    }
  }
  shapes_ = entered(shapes);
  const double size = kShare * whole().norm();
  for (Eigen::Index k = 0; k < shapes_.cols(); ++k) {
    const double norm = shapes_.col(k).norm();
    if (norm > 0.0) shapes_.col(k) *= size / norm;
  }
}

}  // namespace mm
