#include "uncertainty/virtual_machine.h"

#include <algorithm>
#include <cmath>

#include "base/distributions.h"
#include "estimation/drift.h"

namespace mm {
namespace {

constexpr double kAtTheEnd = 1e-15;  // of a probability: its quantile is still a number

/// Student's t beside the normal: by what a deviation grows whose variance is known by so many freedoms.
double studentFactor(double freedoms, Random& random) {
  const double u = std::clamp(random.uniform(), kAtTheEnd, 1.0 - kAtTheEnd);
  return std::sqrt(freedoms / chiSquaredQuantile(u, freedoms));
}

}  // namespace

void VirtualMachine::add(std::string name, Source source) {
  names_.push_back(std::move(name));
  sources_.push_back(std::move(source));
}

Eigen::Vector3d VirtualMachine::seen(const Point& point, const double* parameters,
                                     Model::Workspace& work) const {
  const Model& model = compensator_.model();
  const Eigen::Vector3d at = model.corrected(point.state, parameters, work).position;
  const double distance = work.errors[model.machine().layout().distance()];
  return at - distance * point.normal;
}

void VirtualMachine::drawParameters(Random& random, int only, Workspace& work,
                                    std::vector<Eigen::Vector3d>& errors) const {
  work.normal.resize(values_.size());
  for (Eigen::Index k = 0; k < values_.size(); ++k) {
    const int source = sourceOf_[k];
    const bool acts = source >= 0 && (only < 0 || only == source);
    work.normal[k] = acts ? random.normal() : 0.0;
  }
  work.shift.noalias() = root_ * work.normal;
  if (freedoms_ > 0.0) work.shift *= studentFactor(freedoms_, random);
  if (linear_) {
    for (std::size_t i = 0; i < points_.size(); ++i) errors[i] -= points_[i].byParameter * work.shift;
    return;
  }
  work.parameters = values_ + work.shift;
  const Model& model = compensator_.model();
  for (int k = 0; k < model.parameterCount(); ++k)
    work.parameters[k] =
        std::clamp(work.parameters[k], model.parameter(k).minimum, model.parameter(k).maximum);
  for (std::size_t i = 0; i < points_.size(); ++i)
    errors[i] += points_[i].calibrated - seen(points_[i], work.parameters.data(), work.model);
}

void VirtualMachine::drawRemainder(Random& random, Workspace& work,
                                   std::vector<Eigen::Vector3d>& errors) const {
  const Eigen::Index n = points_.size();
  work.field.resize(n, 3);
  for (Eigen::Index i = 0; i < n; ++i)
    for (int k = 0; k < 3; ++k) work.field(i, k) = random.normal();
  const Eigen::MatrixXd field = smooth_.triangularView<Eigen::Lower>() * work.field;
  const double wider = remainder_.places > 0.0 ? studentFactor(remainder_.places, random) : 1.0;
  for (Eigen::Index i = 0; i < n; ++i)
    for (int k = 0; k < 3; ++k)
      errors[i][k] += wider * remainder_.smooth[k] * field(i, k) + remainder_.rough[k] * random.normal();
}

void VirtualMachine::draw(Random& random, int only, Workspace& work,
                          std::vector<Eigen::Vector3d>& errors) const {
  errors.assign(points_.size(), Eigen::Vector3d::Zero());
  const bool parameters = only < 0 || sources_[only].cause == Cause::kParameters;
  if (parameters && values_.size() > 0) drawParameters(random, only, work, errors);
  for (std::size_t s = 0; s < sources_.size(); ++s) {
    if (only >= 0 && only != static_cast<int>(s)) continue;
    const Source& source = sources_[s];
    switch (source.cause) {
      case Cause::kParameters:
        break;
      case Cause::kDrift: {  // the process that the calibration found
        const DriftStep step(source.smooth, source.tau, interval_);
        Eigen::Vector2d now(random.normal(), random.normal());  // value, and slope in its own unit
        for (std::size_t i = 0; i < points_.size(); ++i) {
          errors[i] += source.std * now[0] * source.along.col(i);
          const double first = random.normal(), second = source.smooth ? random.normal() : 0.0;
          now = step.stays * now + step.fresh * Eigen::Vector2d(first, second);
        }
        break;
      }
      case Cause::kRemainder:
        drawRemainder(random, work, errors);
        break;
      case Cause::kProbe:
        for (Eigen::Vector3d& e : errors)
          for (int k = 0; k < 3; ++k) e[k] += source.std * random.normal();
        break;
      case Cause::kCommon: {
        const double size = source.std * random.normal();
        for (std::size_t i = 0; i < points_.size(); ++i) errors[i] += size * source.along.col(i);
        break;
      }
    }
  }
}

}  // namespace mm
