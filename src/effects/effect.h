#pragma once
#include <Eigen/Core>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "effects/domain.h"
#include "effects/effect_spec.h"
#include "effects/learned_network.h"
#include "effects/state.h"

namespace mm {

/// One unknown constant of an effect. All values in SI (rad, m, 1/K …); `unit` and `toUnit` are for people.
struct Parameter {
  std::string name;
  std::string unit;     // "um", "arcsec", "um/m", "1" …
  double toUnit = 1.0;  // value in `unit` = SI value * toUnit
  double scale = 1.0;   // a typical size
  double bound = 1.0;   // largest plausible magnitude; a direction with a larger standard deviation is lost
  double start = 0.0;
  double minimum = -std::numeric_limits<double>::infinity();  // limits of meaning: a period is positive
  double maximum = std::numeric_limits<double>::infinity();
  double priorStd = 0.0;  // about zero, before any data; 0: nothing is known
  /// Largest magnitude that engineers meet, as of a constant of the material: what is larger is possible, and
  /// the less likely the larger it is.
  double usual = std::numeric_limits<double>::infinity();
  /// A negative value is possible, and seldom met: a trigger that comes before the contact.
  bool seldomNegative = false;
};

/// Where the contribution of an effect is added. Used in two ways: values only, or values and derivatives.
class ErrorSink {
 public:
  virtual ~ErrorSink() = default;
  /// Adds to slot `slot` of the ErrorLayout the product parameter * basis.
  virtual void add(int slot, int parameter, double parameterValue, double basis) = 0;
  /// Adds a value that is not linear; its derivatives are given by `derivative`.
  virtual void value(int slot, double value) = 0;
  virtual void derivative(int slot, int parameter, double derivative) = 0;
  /// False when only values are wanted: derivatives may then be left out.
  virtual bool wantsDerivatives() const = 0;
};

/// A shape that a cause has beside its main one.
struct ShapeFreedom {
  EffectSpec spec;
  double share = 0.15;  // its usual size, of the main shape's, each in its parameters' `scale`
};

enum class Stage { kAxis, kJoint, kProbe, kVolume, kArtifact };

/// One physical effect: a small error as a function of the state and of a few unknown constants.
/// Immutable after construction and safe to call from several threads.
class Effect {
 public:
  virtual ~Effect() = default;

  const EffectSpec& spec() const { return spec_; }                             ///< canonical form
  const std::vector<Parameter>& parameters() const { return parameters_; }     ///< in the order of `p`
  int parameterCount() const { return static_cast<int>(parameters_.size()); }  ///< size of `p`

  virtual Stage stage() const = 0;  ///< where in the chain it acts
  /// True when the error is linear in all parameters.
  virtual bool linear() const { return true; }
  /// Composites are never candidates of a diagnosis.
  virtual bool composite() const { return false; }
  /// Adds the error at `state` with parameters `p` (SI) to the sink. An input that is not known contributes
  /// NaN.
  virtual void evaluate(const State& state, const double* p, ErrorSink& sink) const = 0;
  /// Parameters that enter nonlinearly (a period, a time constant): indices; empty for linear effects.
  virtual std::vector<int> nonlinearParameters() const { return {}; }
  /// Start values (SI) of the nonlinear parameters that cover their plausible range closely enough for a
  /// descent from the nearest to reach the optimum: one vector a start, in the order of
  /// nonlinearParameters().
  virtual std::vector<std::vector<double>> searchStarts() const { return {}; }

  /// Of a wave over the position of a joint, whose linear parameters are its sine and its cosine, counted
  /// from the joint's zero, and whose one nonlinear parameter is its length: shorter lengths than those of
  /// searchStarts(), so many that a quick look at the residuals chooses which are asked.
  struct FineWaves {
    int joint = -1;
    std::vector<double> lengths;  // m or rad, descending
  };
  /// @return joint -1 where the effect has none.
  virtual FineWaves fineWaves() const { return {}; }

  /// True when the error is the sum over the parameters of coefficient(i, p_i) times a function of the state
  /// alone; linear effects are. As coefficient(i, 0) = 0 with slope 1, the derivatives at zero are those
  /// functions.
  virtual bool separable() const { return linear(); }
  virtual double coefficient(int /*parameter*/, double value) const { return value; }
  /// First of three consecutive parameters (l, m, n) that form a unit vector, for each such vector.
  virtual std::vector<int> unitVectors() const { return {}; }
  /// Weight M of h^2, h = l^2 + m^2 + n^2 - 1, beside residuals in mm, LASER (11); 0: the norm is a
  /// constraint, and the error must not depend on the vector's length.
  virtual double unitVectorPenalty() const { return 0.0; }
  /// True when the derivatives at the start values already tell what a session can determine.
  virtual bool startTells() const { return separable(); }
  /// True for a parameter that partly only chooses the frame in which the machine's errors are told: to hold
  /// it is a convention.
  virtual bool choosesFrame(int /*parameter*/) const { return false; }

  // What a diagnosis must know of an effect to treat it as one physical cause.

  /// How often the cause is met in machines, the usual ones being 1: seldom, 0.3.
  virtual double met() const { return 1.0; }
  /// Keys of the spec that only say which shape the cause has (degree, harmonic, period, power, lag …):
  /// effects of one type that differ in nothing else have one cause.
  virtual std::vector<std::string> shapeKeys() const { return {}; }
  /// Other shapes that the cause has at the same time, beside this one: further degrees of a guideway's
  /// profile, harmonics of a screw. Each is linear in its parameters.
  virtual std::vector<ShapeFreedom> freedom(const Domain& /*domain*/) const { return {}; }
  /// The spec with the nonlinear parameters stated, where a key can state them: {period_mm: unknown} at 2 mm
  /// is {period_mm: 2}. Values in the order of nonlinearParameters(), SI.
  virtual EffectSpec shapedAs(const std::vector<double>& /*nonlinear*/) const { return spec_; }
  /// Like freedom(), by other values of the nonlinear parameters: half the period of a screw.
  struct NonlinearFreedom {
    std::vector<double> nonlinear;
    double share = 0.15;
  };
  /// See NonlinearFreedom. Values in the order of nonlinearParameters(), SI.
  virtual std::vector<NonlinearFreedom> freedomBeside(const std::vector<double>& /*nonlinear*/) const {
    return {};
  }
  /// Joints along whose travel its size usually changes (the play of a worn screw): indices of the Domain.
  virtual std::vector<int> variesAlong(const Domain& /*domain*/) const { return {}; }
  /// Joints (indices of the Domain) of whose position it is a law: where one of them never moved, the session
  /// cannot show it.
  virtual std::vector<int> mustMove() const { return {}; }
  /// Distinct positions of each of these that it takes at the least; 0: any that moved.
  virtual int positionsNeeded() const { return 0; }
  /// Whether what the session covered can tell it, with these nonlinear parameters, from a smooth profile: a
  /// wave of which less than two lengths were seen is none. Values in the order of
  /// nonlinearParameters().
  virtual bool mayBeClaimed(const std::vector<double>& /*nonlinear*/) const { return true; }
  /// What else looks the same at the places of the session, and what would tell: a sentence; empty: nothing.
  /// Values in the order of nonlinearParameters(), SI.
  virtual std::string looksTheSame(const std::vector<double>& /*nonlinear*/) const { return {}; }

  // What the rest of the library must know of a few effects, without their names.

  /// What acts where its owner does (effects/owned.h); the effect itself where that is everywhere.
  virtual const Effect& law() const { return *this; }

  /// Its shape is learned from the residuals of the model without it (estimation/network_learning); until
  /// then it has no parameters.
  virtual bool learned() const { return false; }
  /// What it learned; null before it did.
  virtual const LearnedNetwork* network() const { return nullptr; }
  /// The same effect with what it learned; null unless learned(). @throw InputError: the network does not fit
  /// its sensors and positions, or a sensor is not in the domain.
  virtual std::shared_ptr<const Effect> taught(const LearnedNetwork& /*network*/,
                                               const Domain& /*domain*/) const {
    return nullptr;
  }
  /// A law stated by the user: it may say where deviations without an instrument's zero count from.
  virtual bool statesDatum() const { return false; }
  /// Nobody knows how large its parameters are: a search goes by their start values, not by their bounds.
  virtual bool ofUnknownSize() const { return false; }
  /// True for a parameter that a published convention sets to zero where the data do not determine it.
  virtual bool zeroByConvention(int /*parameter*/) const { return false; }

  /// An input at which it says nothing, because it was not calibrated there: which, its value and the range,
  /// in words; empty: none. What all effects have in common (readings of the joints, temperatures,
  /// covariates, time) is judged elsewhere. The margin is beyond the observed range, as a fraction of it.
  virtual std::string outside(const State& /*state*/, double /*margin*/) const { return {}; }

  virtual std::string cause() const = 0;    // physical cause, in plain words
  virtual std::string remedy() const = 0;   // in the workshop
  virtual std::string shownBy() const = 0;  // what a session must contain to show it

 protected:
  EffectSpec spec_;
  std::vector<Parameter> parameters_;
};

using EffectPtr = std::shared_ptr<const Effect>;

}  // namespace mm
