#pragma once
#include <memory>
#include <string>
#include <vector>

#include "design/posture_proposals.h"
#include "design/separation.h"
#include "effects/effect_spec.h"
#include "estimation/identifiability.h"
#include "model/model_spec.h"
#include "session/sense_checks.h"
#include "session/session.h"

namespace mm {

/// How one ball or point was touched.
struct FeatureCoverage {
  std::string name;
  bool ball = true;
  int contacts = 0, lengths = 0;  // with it, from it
  double coneHalfAngle = 0.0;  // rad: largest angle between the mean approach and an approach; NaN: unknown
  double centrePerNoise =
      kNotMeasured;  // largest std of a centre of its own over the noise; NaN: undetermined
};

/// Where a joint was, and which way it travelled there.
struct JointCoverage {
  std::string name;
  bool rotary = false;
  double lower = 0.0, upper = 0.0;                        // m or rad
  int positions = 0;                                      // distinct ones; 0: more than 64
  int up = 0, down = 0, unknown = 0;                      // observations by direction of travel
  double slowest = kNotMeasured, fastest = kNotMeasured;  // speeds while moving, m/s or rad/s
  double withTime = 0.0;                                  // correlation of position and time
};

/// A temperature or another logged quantity, at the observations.
struct InputCoverage {
  std::string name, unit;
  bool temperature = false;
  double lower = kNotMeasured, upper = kNotMeasured;
  double withTime = 0.0;
  int missing = 0;  // observations without it
};

/// A parameter of the model that the session determines only weakly.
struct WeakParameter {
  std::string name, unit;  // unit for people
  double std = 0.0;        // in `unit`, at the noise taken
};

/// An effect of the catalogue that this session could not show if it were there.
struct CannotBeShown {
  EffectSpec effect;
  std::string why, moves;
};

/// The point set before any fit: what was covered and what can be found from it.
struct PointSet {
  std::int64_t contacts = 0, references = 0;
  double duration = 0.0;  // s
  std::vector<FeatureCoverage> features;
  std::vector<JointCoverage> joints;
  std::vector<InputCoverage> inputs;
  double noise = 0.0;  // m, taken for what follows
  bool noiseDeclared = false;
  // with a model only
  bool hasModel = false;
  std::shared_ptr<const Problem> problem;
  Identifiability identifiability;
  std::vector<WeakParameter> weak;  // uncertainty above the typical size of the parameter
  std::vector<std::string> doubts;  // of the postures, one line each
  std::vector<Doubt> questions;     // about units, signs and names: before everything else
  PostureAdvice advice;             // for machines with rotary joints
  std::vector<CannotBeShown> cannotShow;
  std::vector<Separation> separations;  // machine, artifact, stylus and day told apart
};

/// @param model null: without one, what cannot be shown is judged against the artifact's unknowns alone.
/// @throw InputError as `calibrate`.
PointSet checkPointSet(const Session& session, const ModelSpec* model);

/// The answer of `mm check` as text.
std::string pointSetText(const PointSet& set);
/// The same as JSON.
std::string pointSetJson(const PointSet& set);

}  // namespace mm
