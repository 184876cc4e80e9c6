#pragma once
#include <Eigen/Core>
#include <algorithm>
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
  /// Magnitude that engineers meet, as of a constant of the material: what is larger is possible, and the
  /// less likely the larger it is.
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

/// What is so of an effect whatever its parameters and the state. Parameters are indices of parameters(),
/// joints of the Domain.
struct Nature {
  Stage stage = Stage::kAxis;  // where in the chain it acts
  bool linear = true;          // the error is linear in all parameters
  /// The error is the sum over the parameters of coefficient(i, p_i) times a function of the state alone;
  /// linear effects are. As coefficient(i, 0) = 0 with slope 1, the derivatives at zero are those functions.
  bool separable = false;
  bool startTells = false;  // nothing at its start values; the derivatives there tell what is determined
  bool composite = false;   // never a candidate of a diagnosis
  /// Its shape is learned from the residuals of the model without it (estimation/network_learning); until
  /// then it has no parameters.
  bool learned = false;
  bool statesDatum = false;  // a user's law: it may say where deviations without a zero count from
  /// Its first linear parameter is positive, and its second between zero and the first.
  bool secondPartOfFirst = false;
  bool ofUnknownSize = false;  // nobody knows its size: a search goes by starts, not by bounds

  std::vector<int> nonlinear;  // parameters that enter nonlinearly (a period, a time constant)
  /// Start values (SI) of these that cover their plausible range closely enough for a descent from the
  /// nearest to reach the optimum: one vector a start.
  std::vector<std::vector<double>> searchStarts;
  /// Of a wave over the position of a joint, whose linear parameters are its sine and its cosine, counted
  /// from the joint's zero, and whose one nonlinear parameter is its length: shorter lengths than those of
  /// searchStarts, so many that a quick look at the residuals chooses which are asked.
  struct FineWaves {
    int joint = -1;               // -1: the effect has none
    std::vector<double> lengths;  // m or rad, descending
  };
  FineWaves fineWaves;
  std::vector<int> unitVectors;  // first of three parameters (l, m, n) that form a unit vector
  /// Weight M of h^2, h = l^2 + m^2 + n^2 - 1, beside residuals in mm, LASER (11); 0: the norm is a
  /// constraint, and the error must not depend on the vector's length.
  double unitVectorPenalty = 0.0;
  /// Parameters that partly only choose the frame in which the machine's errors are told: to hold them is a
  /// convention.
  std::vector<int> choosesFrame;
  std::vector<int> zeroByConvention;  // set to zero by a published convention where nothing determines them

  // What a diagnosis must know of it to treat it as one physical cause.
  double met = 1.0;  // how often the cause is met in machines, the usual ones being 1: seldom, 0.3
  /// Keys of the spec that only say which shape the cause has (degree, harmonic, period, power, lag …):
  /// effects of one type that differ in nothing else have one cause.
  std::vector<std::string> shapeKeys;
  std::vector<int>
      variesAlong;            // joints along whose travel its size usually changes: the play of a worn screw
  bool variesInTime = false;  // its size usually changes during a session, too
  std::vector<int> mustMove;  // joints of whose position it is a law: where one never moved, it cannot show
  int positionsNeeded = 0;    // distinct positions of each of these, at the least; 0: any that moved
};

/// One physical effect: a small error as a function of the state and of a few unknown constants.
/// Immutable after construction and safe to call from several threads.
class Effect {
 public:
  virtual ~Effect() = default;

  const EffectSpec& spec() const { return spec_; }                             ///< canonical form
  const std::vector<Parameter>& parameters() const { return parameters_; }     ///< in the order of `p`
  int parameterCount() const { return static_cast<int>(parameters_.size()); }  ///< size of `p`
  const Nature& nature() const { return nature_; }                        ///< what is so of it as a whole
  bool linear() const { return nature_.linear; }                          ///< see Nature
  bool separable() const { return nature_.linear || nature_.separable; }  ///< see Nature
  bool startTells() const { return separable() || nature_.startTells; }   ///< see Nature

  /// See Nature, each of one parameter.
  bool choosesFrame(int parameter) const { return isIn(nature_.choosesFrame, parameter); }
  /// As choosesFrame.
  bool zeroByConvention(int parameter) const { return isIn(nature_.zeroByConvention, parameter); }

  /// Adds the error at `state` with parameters `p` (SI) to the sink. An input that is not known contributes
  /// NaN.
  virtual void evaluate(const State& state, const double* p, ErrorSink& sink) const = 0;
  virtual double coefficient(int /*parameter*/, double value) const {
    return value;
  }  ///< see Nature::separable

  // Values of `nonlinear` are in the order of Nature::nonlinear, SI.

  /// Other shapes that the cause has at the same time, beside this one: further degrees of a guideway's
  /// profile, harmonics of a screw. Each is linear in its parameters.
  virtual std::vector<ShapeFreedom> freedom(const Domain& /*domain*/) const { return {}; }
  /// The spec with the nonlinear parameters stated, where a key can state them: {period_mm: unknown} at 2 mm
  /// is {period_mm: 2}.
  virtual EffectSpec shapedAs(const std::vector<double>& /*nonlinear*/) const { return spec_; }
  /// Like freedom(), by other values of the nonlinear parameters: half the period of a screw.
  struct NonlinearFreedom {
    std::vector<double> nonlinear;
    double share = 0.15;
  };
  /// See NonlinearFreedom.
  virtual std::vector<NonlinearFreedom> freedomBeside(const std::vector<double>& /*nonlinear*/) const {
    return {};
  }
  /// Whether what the session covered can tell it, with these nonlinear parameters, from a smooth profile: a
  /// wave of which less than two lengths were seen is none.
  virtual bool mayBeClaimed(const std::vector<double>& /*nonlinear*/) const { return true; }
  /// What else looks the same at the places of the session, and what would tell: a sentence; empty: nothing.
  virtual std::string looksTheSame(const std::vector<double>& /*nonlinear*/) const { return {}; }

  /// What acts where its owner does (effects/owned.h); the effect itself where that is everywhere.
  virtual const Effect& law() const { return *this; }
  /// What it learned; null before it did.
  virtual const LearnedNetwork* network() const { return nullptr; }
  /// The same effect with what it learned; null unless it is learned. @throw InputError: the network does not
  /// fit its sensors and positions, or a sensor is not in the domain.
  virtual std::shared_ptr<const Effect> taught(const LearnedNetwork& /*network*/,
                                               const Domain& /*domain*/) const {
    return nullptr;
  }

  /// An input at which it says nothing, because it was not calibrated there: which, its value and the range,
  /// in words; empty: none. What all effects have in common (readings of the joints, temperatures,
  /// covariates, time) is judged elsewhere. The margin is beyond the observed range, as a fraction of it.
  virtual std::string outside(const State& /*state*/, double /*margin*/) const { return {}; }

  virtual std::string cause() const = 0;    // physical cause, in plain words
  virtual std::string remedy() const = 0;   // in the workshop
  virtual std::string shownBy() const = 0;  // what a session must contain to show it

 private:
  static bool isIn(const std::vector<int>& list, int value) {
    return std::find(list.begin(), list.end(), value) != list.end();
  }

 protected:
  EffectSpec spec_;
  std::vector<Parameter> parameters_;
  Nature nature_;
};

using EffectPtr = std::shared_ptr<const Effect>;

}  // namespace mm
