#include "session/artifact_file.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <sstream>

#include "machine/error.h"
#include "machine/nearest_name.h"
#include "machine/units.h"

namespace mm {
namespace {

/// One mapping of the file; every key is asked for by name, so that what is left is unknown.
class Mapping {
 public:
  Mapping(const YAML::Node& node, std::string source, std::string what, std::vector<std::string> known)
      : source_(std::move(source)), what_(std::move(what)), line_(node.Mark().line + 1) {
    if (!node.IsMap()) fail(line_, what_ + " must be a mapping of keys to values");
    for (const auto& entry : node) {
      const int line = entry.first.Mark().line + 1;
      if (!entry.first.IsScalar()) fail(line, what_ + ": a key must be a word");
      const std::string key = entry.first.Scalar();
      if (std::find(known.begin(), known.end(), key) == known.end())
        fail(line, what_ + ": unknown key '" + key + "'" + didYouMean(key, known));
      if (!values_.emplace(key, entry.second).second)
        fail(line, what_ + ": key '" + key + "' is given twice");
    }
  }

  bool has(const std::string& key) const { return values_.count(key) > 0; }
  YAML::Node node(const std::string& key) const { return values_.at(key); }

  std::string text(const std::string& key) const {
    if (!has(key)) fail(line_, what_ + ": key '" + key + "' is missing");
    const YAML::Node value = node(key);
    if (!value.IsScalar() || value.Scalar().empty())
      fail(lineOf(key), what_ + ": '" + key + "' must be a word");
    return value.Scalar();
  }

  /// A number in SI: what is written times `factor`.
  double number(const std::string& key, double factor) const {
    if (!has(key)) fail(line_, what_ + ": key '" + key + "' is missing");
    return number(node(key), key, factor);
  }

  /// A number that must be at least 0 (above 0 with `strictly`).
  double size(const std::string& key, double factor, bool strictly) const {
    const double value = number(key, factor);
    if (value < 0.0 || (strictly && value == 0.0))
      fail(lineOf(key), what_ + ": '" + key + "' is " + node(key).Scalar() + ", but must be " +
                            (strictly ? "above 0" : "at least 0"));
    return value;
  }

  Eigen::Vector3d vector(const std::string& key, double factor) const {
    if (!has(key)) fail(line_, what_ + ": key '" + key + "' is missing");
    const YAML::Node value = node(key);
    if (!value.IsSequence() || value.size() != 3)
      fail(lineOf(key), what_ + ": '" + key + "' must be three numbers, [x, y, z]");
    return {number(value[0], key, factor), number(value[1], key, factor), number(value[2], key, factor)};
  }

  /// `known` (true, the default) or `free` (false).
  bool known(const std::string& key) const {
    if (!has(key)) return true;
    const std::string value = text(key);
    if (value != "known" && value != "free")
      fail(lineOf(key), what_ + ": '" + key + "' is '" + value + "', but must be known or free");
    return value == "known";
  }

  int line() const { return line_; }
  [[noreturn]] void fail(int line, const std::string& message) const {
    throw InputError(source_ + ":" + std::to_string(line) + ": " + message);
  }

 private:
  int lineOf(const std::string& key) const { return values_.at(key).Mark().line + 1; }

  double number(const YAML::Node& value, const std::string& key, double factor) const {
    double result = 0.0;
    if (!value.IsScalar() || !YAML::convert<double>::decode(value, result) || !std::isfinite(result))
      fail(value.Mark().line + 1, what_ + ": '" + key + "' must be a finite number" +
                                      (value.IsScalar() ? ", not '" + value.Scalar() + "'" : ""));
    return result * factor;
  }

  std::string source_, what_;
  int line_;
  std::map<std::string, YAML::Node> values_;
};

Feature readBall(const Mapping& m) {
  Feature ball;
  ball.kind = FeatureKind::kBall;
  ball.name = m.text("name");
  ball.known = m.known("centre");
  // A free centre without a start value gets one from its contacts (Session::prepare).
  if (ball.known || m.has("centre_mm"))
    ball.position = m.vector("centre_mm", kMillimetre);
  else
    ball.position.setConstant(kNotMeasured);
  ball.radius = m.size("radius_mm", kMillimetre, true);
  if (m.has("radius_std_um")) ball.radiusStd = m.size("radius_std_um", kMicrometre, false);
  if (m.has("centre_std_um")) ball.positionStd = m.size("centre_std_um", kMicrometre, false);
  return ball;
}

Feature readPoint(const Mapping& m) {
  Feature point;
  point.kind = FeatureKind::kPoint;
  point.name = m.text("name");
  point.known = m.known("position");
  if (point.known || m.has("position_mm"))
    point.position = m.vector("position_mm", kMillimetre);
  else
    point.position.setConstant(kNotMeasured);
  if (m.has("position_std_um")) point.positionStd = m.size("position_std_um", kMicrometre, false);
  return point;
}

void readFeatures(const Mapping& file, const std::string& source, FeatureKind kind, Artifact& artifact) {
  const bool ball = kind == FeatureKind::kBall;
  const std::string key = ball ? "balls" : "points";
  if (!file.has(key)) return;
  const YAML::Node list = file.node(key);
  if (!list.IsSequence()) file.fail(list.Mark().line + 1, "'" + key + "' must be a list");
  const std::vector<std::string> known =
      ball ? std::vector<std::string>{"name",      "centre_mm",     "centre",
                                      "radius_mm", "radius_std_um", "centre_std_um"}
           : std::vector<std::string>{"name", "position_mm", "position", "position_std_um"};
  for (const YAML::Node& node : list) {
    const Mapping m(node, source, ball ? "a ball" : "a point", known);
    Feature feature = ball ? readBall(m) : readPoint(m);
    if (artifact.findFeature(feature.name) >= 0)
      m.fail(m.line(), "two balls or points are called '" + feature.name + "'; each needs a name of its own");
    artifact.features.push_back(std::move(feature));
  }
}

}  // namespace

Artifact parseArtifact(const std::string& yaml, const std::string& source) {
  YAML::Node root;
  try {
    root = YAML::Load(yaml);
  } catch (const YAML::Exception& e) {
    throw InputError(source + ":" + std::to_string(e.mark.line + 1) + ": not YAML: " + e.msg);
  }
  if (!root.IsMap())
    throw InputError(
        source + ":1: an artifact file is a mapping with 'name', 'pose', 'probe' and 'balls' or 'points'");
  const Mapping file(root, source, "the artifact",
                     {"name", "pose", "probe", "expansion_per_K", "temperature_sensor", "balls", "points"});
  Artifact artifact;
  artifact.name = file.text("name");
  artifact.poseKnown = file.known("pose");
  if (file.has("probe")) {
    const Mapping probe(file.node("probe"), source, "probe", {"tip_radius_mm", "repeatability_um"});
    if (probe.has("tip_radius_mm")) artifact.tipRadius = probe.size("tip_radius_mm", kMillimetre, false);
    if (probe.has("repeatability_um"))
      artifact.repeatability = probe.size("repeatability_um", kMicrometre, true);
  }
  if (file.has("expansion_per_K")) artifact.expansion = file.number("expansion_per_K", 1.0);
  if (file.has("temperature_sensor")) artifact.temperatureSensor = file.text("temperature_sensor");
  readFeatures(file, source, FeatureKind::kBall, artifact);
  readFeatures(file, source, FeatureKind::kPoint, artifact);
  return artifact;
}

Artifact loadArtifact(const std::filesystem::path& file) {
  std::ifstream in(file);
  if (!in || std::filesystem::is_directory(file))
    throw InputError(file.string() + ": the artifact file cannot be read; check --artifact");
  std::ostringstream text;
  text << in.rdbuf();
  return parseArtifact(text.str(), file.string());
}

}  // namespace mm
