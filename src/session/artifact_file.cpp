#include "session/artifact_file.h"

#include "base/read_file.h"
#include "base/units.h"
#include "base/yaml_mapping.h"

namespace mm {
namespace {

/// A number that must be at least 0 (above 0 with `strictly`), in SI.
double size(const YamlMapping& m, const std::string& key, double factor, bool strictly) {
  const double value = m.number(key, factor);
  if (value < 0.0 || (strictly && value == 0.0))
    m.fail(key, "is " + m.node(key).Scalar() + ", but must be " + (strictly ? "above 0" : "at least 0"));
  return value;
}

/// `known` (true, the default) or `free` (false).
bool known(const YamlMapping& m, const std::string& key) {
  if (!m.has(key)) return true;
  const std::string value = m.text(key);
  if (value != "known" && value != "free") m.fail(key, "is '" + value + "', but must be known or free");
  return value == "known";
}

/// A ball or a point, whose place is called `centre` or `position`. Free without a start value it gets one
/// from its contacts (Session::prepare).
Feature readFeature(const YamlMapping& m, FeatureKind kind, const std::string& place) {
  Feature feature;
  feature.kind = kind;
  feature.name = m.text("name");
  feature.known = known(m, place);
  if (feature.known || m.has(place + "_mm"))
    feature.position = m.vector(place + "_mm", kMillimetre);
  else
    feature.position.setConstant(kNotMeasured);
  if (kind == FeatureKind::kBall) feature.radius = size(m, "radius_mm", kMillimetre, true);
  if (m.has("radius_std_um")) feature.radiusStd = size(m, "radius_std_um", kMicrometre, false);
  if (m.has(place + "_std_um")) feature.positionStd = size(m, place + "_std_um", kMicrometre, false);
  return feature;
}

void readFeatures(const YamlMapping& file, const std::string& source, FeatureKind kind, Artifact& artifact) {
  const bool ball = kind == FeatureKind::kBall;
  const std::string key = ball ? "balls" : "points";
  if (!file.has(key)) return;
  const YAML::Node list = file.node(key);
  if (!list.IsSequence()) file.fail(key, "must be a list");
  const std::string place = ball ? "centre" : "position";
  std::vector<std::string> known = {"name", place + "_mm", place, place + "_std_um"};
  if (ball) known = {"name", "centre_mm", "centre", "radius_mm", "radius_std_um", "centre_std_um"};
  for (const YAML::Node& node : list) {
    const YamlMapping m(node, source, ball ? "a ball" : "a point", known);
    Feature feature = readFeature(m, kind, place);
    if (artifact.findFeature(feature.name) >= 0)
      m.fail("name", "'" + feature.name + "' is used by another ball or point; each needs its own name");
    artifact.features.push_back(std::move(feature));
  }
}

/// Offsets are told from the machine's probe_tip: without one, the first stylus is there.
void readStyli(const YamlMapping& probe, const std::string& source, Artifact& artifact) {
  if (!probe.has("styli")) return;
  if (probe.has("tip_radius_mm"))
    probe.fail("tip_radius_mm", "and 'styli' exclude each other: state the radius of each stylus");
  const YAML::Node list = probe.node("styli");
  if (!list.IsSequence() || list.size() == 0) probe.fail("styli", "must be a list of one or more styli");
  for (const YAML::Node& node : list) {
    const YamlMapping m(node, source, "a stylus", {"name", "tip_radius_mm", "offset_mm", "offset"});
    Stylus stylus;
    stylus.name = m.text("name");
    stylus.tipRadius = size(m, "tip_radius_mm", kMillimetre, false);
    stylus.known = m.has("offset") ? known(m, "offset") : m.has("offset_mm") || artifact.styli.empty();
    if (m.has("offset_mm"))
      stylus.offset = m.vector("offset_mm", kMillimetre);
    else if (!stylus.known)
      stylus.offset.setConstant(kNotMeasured);
    else if (!artifact.styli.empty())
      m.fail("offset", "is known, but 'offset_mm' is not stated");
    if (artifact.findStylus(stylus.name) >= 0)
      m.fail("name", "'" + stylus.name + "' is used by another stylus; each needs its own name");
    artifact.styli.push_back(std::move(stylus));
  }
  artifact.tipRadius = artifact.styli.front().tipRadius;
}

}  // namespace

Artifact parseArtifact(const std::string& yaml, const std::string& source) {
  const YAML::Node root = YamlMapping::load(yaml, source);
  const YamlMapping file(
      root, source, "the artifact",
      {"name", "serial", "pose", "probe", "expansion_per_K", "temperature_sensor", "balls", "points"});
  Artifact artifact;
  artifact.name = file.text("name");
  if (file.has("serial")) artifact.serial = file.text("serial");
  artifact.poseKnown = known(file, "pose");
  if (file.has("probe")) {
    const YamlMapping probe(file.node("probe"), source, "probe",
                            {"tip_radius_mm", "styli", "repeatability_um"});
    if (probe.has("tip_radius_mm")) artifact.tipRadius = size(probe, "tip_radius_mm", kMillimetre, false);
    readStyli(probe, source, artifact);
    if (probe.has("repeatability_um"))
      artifact.repeatability = size(probe, "repeatability_um", kMicrometre, true);
  }
  if (file.has("expansion_per_K")) artifact.expansion = file.number("expansion_per_K", 1.0);
  if (file.has("temperature_sensor")) artifact.temperatureSensor = file.text("temperature_sensor");
  readFeatures(file, source, FeatureKind::kBall, artifact);
  readFeatures(file, source, FeatureKind::kPoint, artifact);
  return artifact;
}

Artifact loadArtifact(const std::filesystem::path& file) {
  return parseArtifact(readWholeFile(file, "check the path of the artifact file"), file.string());
}

}  // namespace mm
