#pragma once
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "session/session.h"
#include "simulation/instrument_settings.h"
#include "simulation/physics.h"

namespace mm {

/// One source of error as it was asked for or drawn: type, where it acts, how large it is.
struct HiddenSource {
  struct Number {
    std::string name;
    double value = 0.0;     // SI
    std::string dimension;  // SI unit
  };
  std::string type;                                       // as in the catalogue of effects
  std::vector<std::pair<std::string, std::string>> keys;  // axis: x …
  std::vector<Number> numbers;                            // the first is the size
  std::string key(const std::string& name) const;         // empty when absent
  double number(const std::string& name) const;           ///< SI; @throw InputError
  /// In one line, e.g. `{type: backlash, axis: x, gap: 3 um}`.
  std::string text() const;
};

struct SourceKind;

/// What a source is built into.
struct Workshop {
  const Machine& machine;
  const Chain& chain;
  const Artifact& artifact;
  const ThermalModel& thermal;
  const InstrumentSettings& settings;
  const std::vector<SourceKind>& kinds;  // that can be hidden
  bool touches = false;                  // the plan touches balls
  std::vector<double> lower, upper;      // travel of each joint in the session, m or rad
  Physics& physics;                      // gets the source
  /// What the instrument goes through at each measurement of the plan, nothing being hidden.
  std::function<const std::vector<Condition>&()> visits;
};

/// What a source adds to the errors at one instant (setting.h). Safe to call from several threads.
struct Instant;
using SourceLaw = std::function<void(const Instant& instant, Distortion& distortion)>;

/// A source that is about to be built.
struct Making {
  const HiddenSource& source;
  Workshop& workshop;
  Random& random;

  double number(const std::string& name) const { return source.number(name); }  ///< a stated size, SI
  /// The joint that the key `axis` names; -1: none of that name.
  int joint() const { return workshop.machine.findJoint(source.key("axis")); }
  void add(SourceLaw law) const;
};

/// One kind of source that can be hidden.
struct SourceKind {
  enum class Key {
    kLinear,
    kRotary,
    kOtherLinear,
    kLevel,  // linear, nearly square to the vertical
    kDirection,
    kOtherDirection,
    kAbout,
    kAcross,
    kBody,
    kColdBody,
    kCovariate,
    kBall,
    kWord
  };
  struct KeyRule {
    std::string name;
    Key kind;
    std::string standard = {};  // value unless given; empty: drawn
  };
  struct NumberRule {
    std::string name, dimension;      // dimension `travel`: m or rad by the joint of the first key
    double lower = 0.0, upper = 0.0;  // SI range from which it is drawn; equal: fixed
    bool eitherSign = false;
  };
  std::string type;
  std::vector<KeyRule> keys;
  std::vector<NumberRule> numbers;
  std::function<void(const Making&)> build;
  enum class Probe { kAny, kTouch, kLaser } probe = Probe::kAny;
  bool onlyByName = false;  // never drawn by `random`
};

/// All kinds that can be hidden, in the order of the catalogue.
const std::vector<SourceKind>& sourceKinds();

/// Reads one source as written for `--hide`, draws what is left open, and builds it into `workshop.physics`.
/// Forms: `backlash`, `backlash:x=3um`, `straightness:x/y=2um`, `lead_screw_periodic:x=1um,period=2mm`,
/// `{type: backlash, axis: x, gap: 3um}`, `random`. @param stream what makes its random numbers its own.
/// @throw InputError naming `where`, what is wrong and what is possible.
HiddenSource hideSource(const std::string& text, const std::string& where, std::uint64_t seed,
                        const std::string& stream, Workshop& workshop);

}  // namespace mm
