#include "design/separation.h"

#include <algorithm>
#include <set>
#include <tuple>

#include "effects/effect_words.h"
#include "estimation/fitter.h"
#include "machine/linear_inverse.h"
#include "model/observed_domain.h"
#include "session/geometric_start.h"

namespace mm {
namespace {

constexpr double kNoise = 1e-6;  // m: what is told and what is not are orders of magnitude apart

/// Scales and squareness of the linear axes: what an artifact is measured for.
std::vector<EffectSpec> geometryOf(const Machine& machine) {
  std::vector<std::string> axes;
  for (const Joint& joint : machine.joints())
    if (joint.kind == JointKind::kLinear) axes.push_back(joint.name);
  std::vector<EffectSpec> effects;
  for (const std::string& axis : axes) effects.push_back(EffectSpec("scale").set("axis", axis));
  for (std::size_t i = 0; i < axes.size(); ++i)
    for (std::size_t j = i + 1; j < axes.size(); ++j)
      effects.push_back(EffectSpec("squareness").set("axis", axes[i]).set("of", axes[j]));
  return effects;
}

/// One point for what a stylus touched of a feature in a placement, at its centre: the shape of a ball tells
/// something too, but as little as is known of its form.
std::vector<Observation> centresOf(const Session& session) {
  const GeometricStart start = geometricStart(session);
  std::set<std::tuple<int, int, int, int>> seen;
  std::vector<Observation> centres;
  for (const Observation& o : session.observations) {
    if (o.kind != ObservationKind::kContact ||
        !seen.emplace(o.feature, o.placement, o.stylus, o.recording).second)
      continue;
    Observation centre = o;
    centre.laserReading = kNotMeasured;
    const Eigen::Matrix3d orientation = session.machine.nominal(o.position.data(), kNotMeasured).orientation;
    const Eigen::Vector3d offset = orientation * start.offsets[static_cast<std::size_t>(o.stylus)];
    if (placeTip(session.machine, start.inWorkpiece(o.feature, o.placement) - offset, kNotMeasured,
                 centre.position))
      centres.push_back(std::move(centre));
  }
  return centres;
}

/// Of each effect, whether it is told from errors of the artifact. Of a lost direction each effect that is
/// part of it is lost with it.
std::vector<char> toldFromArtifact(Session session, const std::vector<EffectSpec>& effects) {
  for (Feature& f : session.artifact.features) {
    f.kind = FeatureKind::kPoint;
    f.known = false;
    f.positionStd = f.radius = f.radiusStd = 0.0;
  }
  session.observations = centresOf(session);
  const Problem problem(session, Model(session.machine, observedDomain(session), effects));
  const Identifiability found = identify(
      problem, problem.start(), inverseOf(problem.sigmas(kNoise, kNoise), usableWeight(problem)), true);
  std::vector<char> told(effects.size(), 1);
  constexpr double kPart = 0.05;  // of a unit vector
  for (const LostDirection& lost : found.lost)
    for (const auto& [unknown, part] : lost.direction) {
      const Unknown& u = problem.unknowns()[static_cast<std::size_t>(unknown)];
      if (u.kind == UnknownKind::kEffect && std::abs(part) > kPart)
        told[static_cast<std::size_t>(u.owner)] = 0;
    }
  return told;
}

}  // namespace

std::vector<Separation> separationsOf(const Session& session) {
  std::vector<Separation> all;
  std::set<int> features, styli;
  for (const Observation& o : session.observations) {
    if (o.kind != ObservationKind::kContact) continue;
    features.insert(o.feature);
    styli.insert(o.stylus);
  }
  constexpr std::size_t kLayout = 3;
  if (features.size() < kLayout || linearJoints(session.machine.joints()).size() < kLayout) return all;
  const std::vector<EffectSpec> effects = geometryOf(session.machine);
  const std::vector<char> told = toldFromArtifact(session, effects);
  for (std::size_t e = 0; e < effects.size(); ++e)
    all.push_back(
        {"the " + inWords(effects[e]) + " from errors of the artifact", told[e] != 0,
         effects[e].type == "scale"
             ? "one known length, measured again with the artifact turned so that it lies along another axis"
             : "the artifact turned about an axis perpendicular to both (a separate placement)"});
  all.push_back({"what a stylus does (lobing) from what the machine does", styli.size() > 1,
                 "the same balls touched with another stylus"});
  all.push_back({"what changed between two sessions from what is always so", session.recordings.size() > 1,
                 "a session of another day beside this one"});
  return all;
}

}  // namespace mm
