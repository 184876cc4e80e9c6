// What the probe and the artifact do.
#include <algorithm>
#include <cmath>

#include "effects/law.h"
#include "effects/quantity.h"
#include "effects/tilt.h"
#include "effects/touch.h"

namespace mm {
namespace {

/// The tip stands elsewhere at the last axis, LASER eq. (7): Q43 of a probe without a beam, as displacement
/// in the axes of probe_tip.
Law tipOffset(SpecReader& read) {
  Law law;
  law.nature.stage = Stage::kProbe;
  for (int k = 0; k < 3; ++k) law.parameters.push_back(parameter(axisName(k), kUnitMicrometre, 1e-5, 1e-2));
  law.add = [layout = read.layout()](const State&, const double* p, ErrorSink& sink) {
    for (int k = 0; k < 3; ++k) sink.add(layout.probe(k), k, p[k], 1.0);
  };
  law.nature.choosesFrame = {0, 1, 2};
  return law;
}

Law probeRadius(SpecReader& read) {
  return oneTerm(Stage::kProbe, read.layout().distance(), errorParameter("radius", JointKind::kLinear),
                 [](const State&) { return 1.0; });
}

bool touchesBalls(const EffectSpec&, const Domain& domain) {
  return !domain.laser && !ballNames(domain).empty();
}
/// An axis of rotation carries the touch probe: else an artifact that is displaced looks the same. The mount
/// of a laser is a law of its own.
bool headCarriesTip(const EffectSpec&, const Domain& domain) {
  return !domain.laser && std::any_of(domain.joints.begin() + domain.tableJoints, domain.joints.end(),
                                      [](const Joint& joint) { return joint.kind == JointKind::kRotary; });
}
bool hasLaser(const EffectSpec&, const Domain& domain) { return domain.laser; }
bool hasFeatures(const EffectSpec&, const Domain& domain) { return !domain.features.empty(); }

void needLaser(const SpecReader& read) {
  if (!read.domain().laser) read.fail("the session has no readings of a laser probe (reading_mm)");
}

/// Along the approach, cos(eps) (S sin(n phi) + K cos(n phi)): phi is the azimuth of the approach about the
/// stylus (z of probe_tip), eps its elevation from the plane across the stylus.
Law probeLobing(SpecReader& read) {
  constexpr int kHighestOrder = 9;
  constexpr double kOtherLobes = 0.1;  // of the lobes that its seat's contacts make
  constexpr double kHarmonic = 0.3;    // of the same: a seat on three points has 3, 6, 9 … lobes
  const int order = read.integer("order", 0, kHighestOrder);
  if (order == 1) read.fail("order 1 would move the tip, and the artifact's pose takes that up: 0 or 2 to 9");
  Law law;
  law.nature.stage = Stage::kProbe;
  if (order > 0) law.parameters = {errorParameter("S", JointKind::kLinear)};
  law.parameters.push_back(errorParameter("K", JointKind::kLinear));
  law.add = [layout = read.layout(), order](const State& s, const double* p, ErrorSink& sink) {
    const Touch touch = touchOf(s);
    if (touch == Touch::kNone) return;
    const Eigen::Vector3d& a = s.approach;
    const double across = a.dot(s.orientation.col(0)), along = a.dot(s.orientation.col(1));
    const double phi = std::atan2(along, across), elevation = std::hypot(across, along);  // cos(eps)
    const double sine = elevation * std::sin(order * phi), cosine = elevation * std::cos(order * phi);
    const int last = order > 0 ? 1 : 0;
    for (int k = 0; k < 3; ++k) {
      const double component = touch == Touch::kKnown ? a[k] : kUnknown;
      if (order > 0) sink.add(layout.volume(k), 0, p[0], component * sine);
      sink.add(layout.volume(k), last, p[last], component * cosine);
    }
  };
  law.variant = order == 0 ? "sideways" : order == 3 ? "on three points" : "";
  if (order == 0) return law;  // a cause of its own: a stylus that bends, not a seat on some points
  law.nature.shapeKeys = {"order"};
  for (int other = 2; other <= kHighestOrder; ++other)
    if (other != order && (other % order == 0 || other <= 4))
      law.freedom.push_back(
          {read.canonical().set("order", other), other % order == 0 ? kHarmonic : kOtherLobes});
  return law;
}

Law laserScale(SpecReader& read) {
  needLaser(read);
  return oneTerm(Stage::kProbe, read.layout().reading(),
                 parameter("scale", kUnitMicrometre / kUnitMetre, 1e-3, 0.2),
                 [](const State& s) { return s.laserReading; });
}

Law laserIncidence(SpecReader& read) {
  needLaser(read);
  Law law;
  law.nature.stage = Stage::kProbe;
  law.parameters = {parameter("offset", kUnitMicrometre, 1e-5, 1e-2)};
  law.add = [slot = read.layout().reading()](const State& s, const double* p, ErrorSink& sink) {
    if (s.feature < 0) return;
    if (s.featureRadius == 0.0 && s.surfaceNormal.squaredNorm() == 0.0) return;  // a point has no surface
    const bool known = s.surfaceNormal.squaredNorm() > 0.25;                     // false for NaN
    const double cosine = -s.orientation.col(2).dot(s.surfaceNormal);
    sink.add(slot, 0, p[0], known ? 1.0 - cosine : kUnknown);
  };
  return law;
}

Law ballRadius(SpecReader& read) {
  Law law;
  law.nature.stage = Stage::kArtifact;
  law.parameters = {errorParameter("radius", JointKind::kLinear)};
  law.add = [ball = read.ball("ball"), slot = read.layout().distance()](const State& s, const double* p,
                                                                        ErrorSink& sink) {
    if (s.feature == ball) sink.add(slot, 0, p[0], 1.0);
  };
  return law;
}

Law artifactPosition(SpecReader& read) {
  Law law;
  law.nature.stage = Stage::kArtifact;
  for (int k = 0; k < 3; ++k) law.parameters.push_back(parameter(axisName(k), kUnitMicrometre, 1e-6, 1e-2));
  law.add = [feature = read.feature("feature"), layout = read.layout()](const State& s, const double* p,
                                                                        ErrorSink& sink) {
    if (s.feature != feature) return;
    for (int k = 0; k < 3; ++k) sink.add(layout.feature(k), k, p[k], 1.0);
  };
  law.nature.choosesFrame = {0, 1, 2};
  return law;
}

Law artifactExpansion(SpecReader& read) {
  Law law;
  law.nature.stage = Stage::kArtifact;
  law.parameters = {expansionParameter(kUnitMicrometre / kUnitMetre / kUnitKelvin)};
  law.add = [sensor = read.sensor("sensor"), layout = read.layout()](const State& s, const double* p,
                                                                     ErrorSink& sink) {
    if (s.feature < 0) return;
    const double warmer = s.temperature[sensor] - kReferenceTemperature;
    for (int k = 0; k < 3; ++k) sink.add(layout.feature(k), 0, p[0], warmer * s.featurePosition[k]);
    sink.add(layout.distance(), 0, p[0], warmer * s.featureRadius);
  };
  return law;
}

}  // namespace

std::vector<LawRow> lawsOfContact() {
  return {
      {"probe_radius", {}, {}, touchesBalls, probeRadius},
      {"probe_lobing", {"order"}, {fixed("order", {"0", "2", "3", "4", "6"})}, touchesBalls, probeLobing},
      {"laser_scale", {}, {}, hasLaser, laserScale},
      {"laser_incidence", {}, {}, hasLaser, laserIncidence},
      {"ball_radius", {"ball"}, {named("ball", ballNames)}, {}, ballRadius},
      {"artifact_position",
       {"feature"},
       {named("feature", [](const Domain& domain) { return domain.features; })},
       {},
       artifactPosition},
      {"artifact_expansion", {"sensor"}, {sensors()}, hasFeatures, artifactExpansion},
      {"tip_offset", {}, {}, headCarriesTip, tipOffset},
  };
}

}  // namespace mm
