#pragma once
// What a package of your own needs to bring an effect into measuring_machine: this header, nothing to link.
// Only the standard library is in it, so that a plugin does not depend on how measuring_machine was built.
// A worked example is in examples/own_effect.
#include <limits>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace mm {
namespace plugin {

/// Changes whenever something below does: a plugin that was built with another header is refused, by name.
constexpr int kInterface = 2;

constexpr double kMicrometre = 1e-6;                           // in m
constexpr double kArcsecond = 3.14159265358979323846 / 648e3;  // in rad

/// What the session is about: the joints and what was logged. SI units, degC.
struct Session {
  struct Quantity {
    std::string name;
    double lower = 0.0, upper = 0.0;  // observed range
    bool rotary = false;              // of a joint: rad instead of m
  };
  std::vector<Quantity> joints, sensors, covariates;
  std::vector<std::string> features;  // balls and points of the artifact
  double duration = 0.0;              // s
  double maxSpeed = 0.0;              // m/s or rad/s
  bool laser = false;

  /// Index of a name among the joints, sensors or covariates. @throw std::invalid_argument: there is none.
  static int find(const std::vector<Quantity>& among, const std::string& name) {
    std::string known;
    for (std::size_t i = 0; i < among.size(); ++i) {
      if (among[i].name == name) return static_cast<int>(i);
      known += (i > 0 ? ", " : "") + among[i].name;
    }
    throw std::invalid_argument("'" + name + "' is not among " + (known.empty() ? "(none)" : known));
  }
  int joint(const std::string& name) const { return find(joints, name); }
};

/// The inputs at one moment: uncorrected readings and what else was logged. SI units, degC. NaN: not known.
struct State {
  double time = 0.0;                    // s from the session's start
  const double* position = nullptr;     // a joint
  const double* velocity = nullptr;     // a joint
  const double* travel = nullptr;       // a joint: direction of its last motion, -1 or +1; 0: not known
  const double* temperature = nullptr;  // a sensor
  const double* covariate = nullptr;    // a covariate
  double approach[3] = {};     // unit vector in workpiece towards the surface; zero where nothing is touched
  double normal[3] = {};       // outward unit normal of the touched surface, in workpiece; zero: not known
  double tip[3] = {};          // nominal tip in workpiece: the lever of a rotation, m
  double orientation[9] = {};  // of probe_tip in workpiece, row by row
  double laserReading = 0.0;   // m
  int feature = -1;            // the touched feature; -1: nothing is touched
  double featureRadius = 0.0;  // m, of a ball
};

/// Where an effect adds its error, all zero before: corrected = nominal + error. m and rad.
struct Error {
  double* reading = nullptr;  // a joint: added to its reading
  double* atJoint =
      nullptr;  // six a joint: translation and rotation of its axis, in the axes of its side towards the bed
  double volume[3] = {};       // displacement of the tip, in workpiece
  double orientation[3] = {};  // rotation of the probe about its tip, in workpiece
  double probe[3] = {};        // displacement in the axes of probe_tip
  double laserReading = 0.0;   // added to the laser's reading
  double distance = 0.0;       // added to the distance between tip centre and ball centre
  double feature[3] = {};      // displacement of the touched feature, artifact frame

  /// A small rotation about axis k of workpiece (0-2) through its origin: displacement angle * (k x lever),
  /// and the turn of the probe.
  void tilt(const State& state, int k, double angle) {
    const int next = (k + 1) % 3, last = (k + 2) % 3;
    volume[next] -= angle * state.tip[last];
    volume[last] += angle * state.tip[next];
    orientation[k] += angle;
  }
};

/// One unknown constant, in SI; `unit` and `toUnit` are for people.
struct Parameter {
  std::string name;
  std::string unit;     // "um", "arcsec", "um/m", "1" ...
  double toUnit = 1.0;  // value in `unit` = SI value * toUnit
  double scale = 1.0;   // a typical size
  double bound = 1.0;   // largest plausible magnitude
  double start = 0.0;
  double minimum = -std::numeric_limits<double>::infinity();  // limits of meaning: a period is positive
  double maximum = std::numeric_limits<double>::infinity();
  double priorStd = 0.0;  // about zero, before any data; 0: nothing is known
  /// Empty: the error is linear in this parameter, and zero where all such parameters are. Else: start values
  /// that cover its plausible range closely enough for a descent from the nearest to reach the optimum.
  std::vector<double> search;
};

/// The keys of one effect beside `type`, as text: {type: my_effect, axis: x} has {{"axis", "x"}}.
using Keys = std::map<std::string, std::string>;

/// A shape that a cause has beside its main one: an effect of the same type, linear in its parameters.
struct ShapeFreedom {
  Keys keys;
  double share = 0.15;  // its usual size, of the main shape's, each in its parameters' `scale`
};

/// One physical effect: a small error as a function of the state and of a few unknown constants. It does not
/// change after construction and is called from several threads.
class Effect {
 public:
  virtual ~Effect() = default;
  virtual std::vector<Parameter> parameters() const = 0;
  /// @param p one value a parameter, SI. An input that it needs and that is not known: add NaN, not zero.
  virtual void evaluate(const State& state, const double* p, Error& error) const = 0;
  virtual std::string cause() const = 0;    // physical cause, in plain words
  virtual std::string remedy() const = 0;   // in the workshop
  virtual std::string shownBy() const = 0;  // what a session must contain to show it

  // What a diagnosis may know of it to treat it as one cause. On what it depends is found by trial. Joints
  // are indices of the session's.

  /// Other shapes that the cause has at the same time: the second harmonic of a wave.
  virtual std::vector<ShapeFreedom> freedom() const { return {}; }
  /// Joints along whose travel its size usually changes: the play of a worn screw.
  virtual std::vector<int> variesAlong() const { return {}; }
  /// Joints of whose position it is a law: where one of them never moved, the session cannot show it.
  virtual std::vector<int> mustMove() const { return {}; }
  /// Distinct positions of each of these that it takes at the least; 0: any that moved.
  virtual int positionsNeeded() const { return 0; }
};

/// A key that the effect takes.
struct Key {
  std::string name;
  std::string standard;  // what is meant where it is not given; empty: it must be given
  bool shape = false;    // it only says which shape the cause has (degree, harmonic): effects that differ in
                         // nothing else have one cause
};

/// Base class of the plugins: one type of effect. Its package exports
/// `<measuring_machine plugin="${prefix}/effects.xml"/>` and says PLUGINLIB_EXPORT_CLASS(MyType,
/// mm::plugin::EffectType).
class EffectType {
 public:
  virtual ~EffectType() = default;
  /// Not to be overridden: the header that the plugin was built with.
  virtual int builtWith() const { return kInterface; }
  /// What `type:` says; no effect of the catalogue may have it.
  virtual std::string name() const = 0;
  virtual std::vector<Key> keys() const = 0;
  /// @param keys all of keys(), and nothing else. @throw std::exception with one line for an unfit value.
  virtual std::unique_ptr<Effect> create(const Keys& keys, const Session& session) const = 0;
  /// Every member of the family that a diagnosis should try on this machine; physics restricts the list.
  virtual std::vector<Keys> candidates(const Session& /*session*/) const { return {}; }
};

}  // namespace plugin
}  // namespace mm
