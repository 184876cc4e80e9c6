// What the probe and the artifact do.
#include "effects/law.h"
#include "effects/quantity.h"
#include "effects/tilt.h"

namespace mm {
namespace {

Law probeRadius(SpecReader& read) {
  return oneTerm(Stage::kProbe, read.layout().distance(), errorParameter("radius", JointKind::kLinear),
                 [](const State&) { return 1.0; });
}

bool touchesBalls(const EffectSpec&, const Domain& domain) {
  return !domain.laser && !ballNames(domain).empty();
}
bool hasLaser(const EffectSpec&, const Domain& domain) { return domain.laser; }
bool hasFeatures(const EffectSpec&, const Domain& domain) { return !domain.features.empty(); }

void needLaser(const SpecReader& read) {
  if (!read.domain().laser) read.fail("the session has no readings of a laser probe (reading_mm)");
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
      {"laser_scale", {}, {}, hasLaser, laserScale},
      {"laser_incidence", {}, {}, hasLaser, laserIncidence},
      {"ball_radius", {"ball"}, {named("ball", ballNames)}, {}, ballRadius},
      {"artifact_position",
       {"feature"},
       {named("feature", [](const Domain& domain) { return domain.features; })},
       {},
       artifactPosition},
      {"artifact_expansion", {"sensor"}, {sensors()}, hasFeatures, artifactExpansion},
  };
}

}  // namespace mm
