#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "effects/effect.h"
#include "machine/machine.h"

namespace mm {

/// Machine + effects: where the probe really is, as a function of a state and of the effects' parameters.
/// Immutable; `corrected` may be called from several threads with a workspace each.
class Model {
 public:
  /// One derivative of an error with respect to a parameter, in SI.
  struct Derivative {
    int slot = 0;       // of the ErrorLayout
    int parameter = 0;  // of the model
    double value = 0.0;
  };

  /// Buffers of one thread. After `corrected`: the errors by slot (m, rad), and, when derivatives were asked
  /// for, those of the pose by slot and of the slots by parameter. The slots `distance` and `feature` do not
  /// move the pose: who compares the pose with a feature reads them from here.
  struct Workspace {
    std::vector<double> errors;
    Eigen::Matrix<double, 6, Eigen::Dynamic> bySlot;
    std::vector<Derivative> derivatives;
    // Of correctedWithCovariance: the position by parameter, a row each, and the product with the lower half
    // of the parameters' covariance.
    Eigen::Matrix<double, Eigen::Dynamic, 3> byParameter, halfWithPosition;
  };

  Model(Machine machine, Domain domain, std::vector<EffectPtr> effects);
  /// The effects named by `specs`, made by the registry, those whose shape is learned with their networks.
  /// @throw InputError as createEffect.
  Model(Machine machine, Domain domain, const std::vector<EffectSpec>& specs,
        const std::vector<LearnedNetwork>& networks = {});

  const Machine& machine() const { return machine_; }                 ///< as given
  const Domain& domain() const { return domain_; }                    ///< as given
  const std::vector<EffectPtr>& effects() const { return effects_; }  ///< in the order of the spec
  std::vector<LearnedNetwork> networks() const;              ///< what its effects learned, in their order
  int parameterCount() const { return parameterCount_; }     ///< of all effects
  int offset(int effect) const { return offsets_[effect]; }  ///< its first parameter
  /// Of the whole vector of parameters. @param index 0 to parameterCount() - 1.
  const Parameter& parameter(int index) const {
    return effects_[effectOf_[index]]->parameters()[index - offsets_[effectOf_[index]]];
  }
  int effectOf(int parameter) const { return effectOf_[parameter]; }  ///< index of its effect
  Eigen::VectorXd start() const;                                      ///< start values, SI

  /// Sets what follows from the readings: the nominal tip (lever) and orientation, and for a laser the
  /// approach.
  void place(State& state) const;

  /// Pose of the probe with the effects applied; corrected = nominal + delta (MMT eq. 14).
  /// @param parameters parameterCount() values, SI. @param byParameter if not null, 6 x parameterCount():
  /// derivative of position (m) and orientation (rotation vector, rad). An input that an effect needs and the
  /// state does not have makes the pose NaN. No allocation once the workspace has been used.
  ProbePose corrected(const State& state, const double* parameters, Workspace& work,
                      Eigen::Matrix<double, 6, Eigen::Dynamic>* byParameter = nullptr) const;

  /// The same, with the derivatives of the errors and of the pose by slot in the workspace.
  ProbePose differentiated(const State& state, const double* parameters, Workspace& work) const {
    return pose(state, parameters, work, true);
  }
  /// The same, with the covariance of the position (m^2) that the parameters' leaves. @param covariance
  /// parameterCount() squared, SI.
  ProbePose correctedWithCovariance(const State& state, const double* parameters,
                                    const Eigen::MatrixXd& covariance, Workspace& work,
                                    Eigen::Matrix3d& ofPosition) const;

 private:
  ProbePose pose(const State& state, const double* parameters, Workspace& work, bool derivatives) const;

  Machine machine_;
  Domain domain_;
  std::vector<EffectPtr> effects_;
  std::vector<int> offsets_, effectOf_;
  int parameterCount_ = 0;
};

}  // namespace mm
