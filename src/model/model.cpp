#include "model/model.h"

#include <cmath>
#include <limits>

#include "effects/registry.h"

namespace mm {
namespace {

/// Gathers the errors of one state by slot, and their derivatives when a list is given.
class Collector final : public ErrorSink {
 public:
  Collector(double* errors, std::vector<Model::Derivative>* derivatives)
      : errors_(errors), derivatives_(derivatives) {}

  /// Index of the first parameter of the effect that is evaluated next.
  void startAt(int offset) { offset_ = offset; }

  void add(int slot, int parameter, double parameterValue, double basis) override {
    errors_[slot] += parameterValue * basis;
    if (derivatives_ != nullptr) derivatives_->push_back({slot, offset_ + parameter, basis});
  }
  void value(int slot, double value) override { errors_[slot] += value; }
  void derivative(int slot, int parameter, double derivative) override {
    if (derivatives_ != nullptr) derivatives_->push_back({slot, offset_ + parameter, derivative});
  }
  bool wantsDerivatives() const override { return derivatives_ != nullptr; }

 private:
  double* errors_;
  std::vector<Model::Derivative>* derivatives_;
  int offset_ = 0;
};

/// A domain that was read from a file has the joints' names and ranges; their geometry is the machine's.
Domain withMachine(Domain domain, const Machine& machine) {
  domain.setMachine(machine);
  return domain;
}

std::vector<EffectPtr> create(const std::vector<EffectSpec>& specs, const Domain& domain,
                              const std::vector<LearnedNetwork>& networks) {
  std::vector<EffectPtr> effects;
  effects.reserve(specs.size());
  for (const EffectSpec& spec : specs) effects.push_back(createEffect(spec, domain, networks));
  return effects;
}

}  // namespace

Model::Model(Machine machine, Domain domain, std::vector<EffectPtr> effects)
    : machine_(std::move(machine)),
      domain_(withMachine(std::move(domain), machine_)),
      effects_(std::move(effects)) {
  for (std::size_t e = 0; e < effects_.size(); ++e) {
    offsets_.push_back(parameterCount_);
    parameterCount_ += effects_[e]->parameterCount();
    effectOf_.resize(static_cast<std::size_t>(parameterCount_), static_cast<int>(e));
  }
}

Model::Model(Machine machine, Domain domain, const std::vector<EffectSpec>& specs,
             const std::vector<LearnedNetwork>& networks)
    : Model(machine, domain, create(specs, withMachine(domain, machine), networks)) {}

std::vector<LearnedNetwork> Model::networks() const {
  std::vector<LearnedNetwork> learned;
  for (const EffectPtr& effect : effects_)
    if (effect->network() != nullptr) learned.push_back(*effect->network());
  return learned;
}

Eigen::VectorXd Model::start() const {
  Eigen::VectorXd start(parameterCount_);
  for (int i = 0; i < parameterCount_; ++i) start[i] = parameter(i).start;
  return start;
}

void Model::place(State& state) const {
  // The lever is that of the probe itself: the machine adds the reach of a laser's beam.
  const ProbePose nominal = machine_.nominal(state.position.data(), std::numeric_limits<double>::quiet_NaN());
  state.tip = nominal.position;
  state.orientation = nominal.orientation;
  if (domain_.laser && !std::isnan(state.laserReading)) state.approach = nominal.orientation.col(2);
}

ProbePose Model::pose(const State& state, const double* parameters, Workspace& work, bool derivatives) const {
  work.errors.assign(static_cast<std::size_t>(machine_.layout().size()), 0.0);
  work.derivatives.clear();
  Collector collector(work.errors.data(), derivatives ? &work.derivatives : nullptr);
  for (std::size_t e = 0; e < effects_.size(); ++e) {
    collector.startAt(offsets_[e]);
    effects_[e]->evaluate(state, parameters + offsets_[e], collector);
  }
  // NaN: a touch probe, which has no beam.
  const double reading = domain_.laser ? state.laserReading : std::numeric_limits<double>::quiet_NaN();
  return machine_.measure(state.position.data(), reading, work.errors.data(),
                          derivatives ? &work.bySlot : nullptr);
}

ProbePose Model::corrected(const State& state, const double* parameters, Workspace& work,
                           Eigen::Matrix<double, 6, Eigen::Dynamic>* byParameter) const {
  const ProbePose result = pose(state, parameters, work, byParameter != nullptr);
  if (byParameter != nullptr) {
    byParameter->setZero(6, parameterCount_);
    for (const Derivative& d : work.derivatives)
      byParameter->col(d.parameter) += work.bySlot.col(d.slot) * d.value;
  }
  return result;
}

ProbePose Model::correctedWithCovariance(const State& state, const double* parameters,
                                         const Eigen::MatrixXd& covariance, Workspace& work,
                                         Eigen::Matrix3d& ofPosition) const {
  const ProbePose result = pose(state, parameters, work, true);
  work.byParameter.setZero(parameterCount_, 3);
  for (const Derivative& d : work.derivatives)
    work.byParameter.row(d.parameter) += d.value * work.bySlot.col(d.slot).head<3>().transpose();
  work.halfWithPosition.setZero(parameterCount_, 3);
  for (int p = 0; p < parameterCount_; ++p) {
    const int others = parameterCount_ - 1 - p;
    for (int k = 0; k < 3; ++k) {
      const double by = work.byParameter(p, k);
      if (by == 0.0) continue;  // most parameters move the tip along one axis
      work.halfWithPosition(p, k) += 0.5 * by * covariance(p, p);
      work.halfWithPosition.col(k).tail(others) += by * covariance.col(p).tail(others);
    }
  }
  const Eigen::Matrix3d half = work.byParameter.transpose().lazyProduct(work.halfWithPosition);
  ofPosition = half + half.transpose();
  return result;
}

}  // namespace mm
