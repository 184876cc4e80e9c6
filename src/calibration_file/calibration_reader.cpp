#include <charconv>

#include "base/checksum.h"
#include "base/error.h"
#include "base/yaml_mapping.h"
#include "calibration_file/atomic_file.h"
#include "calibration_file/calibration_yaml.h"
#include "effects/effect_yaml.h"

namespace mm {
namespace {

template <typename Integer>
Integer integer(const YamlMapping& keys, const std::string& key) {
  const std::string text = keys.storedText(key);
  Integer value = 0;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), value);
  if (read.ec != std::errc() || read.ptr != text.data() + text.size())
    throw InputError("'" + key + "' is '" + text + "', which is not a whole number in its range");
  return value;
}

/// Calls `read` with each mapping of a list, and refuses what it did not ask for. @param name of the list in
/// messages. @param optional it may be left out.
template <typename Read>
void eachOf(const YamlMapping& in, const std::string& key, const std::string& name, bool optional,
            Read read) {
  if (optional && !in.has(key)) return;
  const std::vector<YAML::Node> items = in.list(key);
  for (std::size_t i = 0; i < items.size(); ++i) {
    const YamlMapping keys = in.item(items[i], name, i);
    read(keys);
    keys.finish();
  }
}

/// A list of names.
std::vector<std::string> namesIn(const YamlMapping& in, const std::string& key, bool optional) {
  std::vector<std::string> names;
  if (!optional || in.has(key))
    for (const YAML::Node& name : in.list(key)) names.push_back(name.Scalar());
  return names;
}

void readModel(const YamlMapping& root, Calibration& c) {
  const std::vector<YAML::Node> effects = root.list("effects");
  for (std::size_t e = 0; e < effects.size(); ++e)
    c.effects.push_back(effectSpecOf(effects[e], root.source()));
  const std::vector<YAML::Node> parameters = root.list("parameters");
  for (std::size_t p = 0; p < parameters.size(); ++p) {
    const YamlMapping keys = root.item(parameters[p], "parameters", p);
    Calibration::Value v;
    v.effect = integer<int>(keys, "effect");
    v.name = keys.storedText("name");
    v.value = keys.stored("value_si");
    v.std = keys.stored("std_si");
    v.unit = keys.storedText("unit");
    v.toUnit = keys.stored("to_unit");
    v.fixed = keys.flag("fixed");
    keys.finish();
    if (v.effect < 0 || v.effect >= static_cast<int>(c.effects.size()))
      root.refuse(parameters[p], "parameter '" + v.name + "' belongs to effect " + std::to_string(v.effect) +
                                     " of " + std::to_string(c.effects.size()));
    c.values.push_back(std::move(v));
  }
  const std::vector<YAML::Node> rows = root.list("covariance_si");
  const std::size_t n = c.values.size();
  if (rows.size() != n) root.refuse(root.node("covariance_si"), "'covariance_si' needs one row a parameter");
  c.covariance.resize(static_cast<Eigen::Index>(n), static_cast<Eigen::Index>(n));
  bool triangle = false;  // as the first row
  for (std::size_t i = 0; i < n; ++i) {
    const std::vector<double> row = root.storedList(rows[i], "covariance_si");
    if (i == 0) triangle = row.size() == 1;
    if (row.size() != (triangle ? i + 1 : n))
      root.refuse(rows[i], "a row of 'covariance_si' has the wrong length");
    for (std::size_t j = 0; j < row.size(); ++j) {
      c.covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) = row[j];
      if (triangle) c.covariance(static_cast<Eigen::Index>(j), static_cast<Eigen::Index>(i)) = row[j];
    }
  }
}

void readRanges(const YamlMapping& in, const char* key, const std::string& unit,
                std::vector<std::string>& names, std::vector<double>& lower, std::vector<double>& upper) {
  eachOf(in, key, key, false, [&](const YamlMapping& keys) {
    names.push_back(keys.storedText("name"));
    lower.push_back(keys.stored("lower" + unit));
    upper.push_back(keys.stored("upper" + unit));
  });
}

Eigen::Vector3d vectorOf(const YamlMapping& in, const char* key) {
  const std::vector<double> v = in.storedList(key);
  if (v.size() != 3) in.refuse(in.node(key), std::string("'") + key + "' needs three numbers");
  return {v[0], v[1], v[2]};
}

void readNetworks(const YamlMapping& in, std::vector<LearnedNetwork>& networks) {
  eachOf(in, "networks", "domain.networks", true, [&](const YamlMapping& keys) {
    LearnedNetwork n;
    n.effect = keys.storedText("effect");
    n.active = keys.flag("active");
    n.summary = keys.storedText("summary");
    n.sensors = namesIn(keys, "sensors", false);
    n.positions = keys.storedList("positions_si");
    n.heldOut = keys.stored("held_out_si");
    n.heldOutRidge = keys.stored("held_out_ridge_si");
    n.heldOutNone = keys.stored("held_out_none_si");
    n.numbers = keys.storedList("network");
    networks.push_back(std::move(n));
  });
}

void readDomain(const YamlMapping& in, Domain& d, std::vector<LearnedNetwork>& networks) {
  eachOf(in, "joints", "domain.joints", false, [&](const YamlMapping& keys) {
    Joint joint;
    joint.name = keys.storedText("name");
    d.joints.push_back(joint);
    d.lower.push_back(keys.stored("observed_lower_si"));
    d.upper.push_back(keys.stored("observed_upper_si"));
    if (keys.has("velocity_lower_si")) {
      d.velocityLower.push_back(keys.stored("velocity_lower_si"));
      d.velocityUpper.push_back(keys.stored("velocity_upper_si"));
    }
    d.positions.push_back(keys.storedList("positions_si"));
  });
  readRanges(in, "sensors", "_degC", d.sensors, d.sensorLower, d.sensorUpper);
  readRanges(in, "covariates", "", d.covariates, d.covariateLower, d.covariateUpper);
  d.features = namesIn(in, "features", false);
  d.featureRadius = in.storedList("feature_radii_m");
  d.styli = namesIn(in, "styli", true);
  if (in.has("sessions")) d.recordings = integer<int>(in, "sessions");
  d.duration = in.stored("duration_s");
  d.maxSpeed = in.stored("max_speed_si");
  d.tipLower = vectorOf(in, "tip_lower_m");
  d.tipUpper = vectorOf(in, "tip_upper_m");
  d.laser = in.flag("laser");
  if (in.has("reading_lower_m")) {
    d.readingLower = in.stored("reading_lower_m");
    d.readingUpper = in.stored("reading_upper_m");
  }
  d.artifactExpansion = in.stored("artifact_expansion_per_K");
  readNetworks(in, networks);
  in.finish();
}

void readDrift(const YamlMapping& root, std::vector<Wandering>& drift) {
  eachOf(root, "drift", "drift", true, [&](const YamlMapping& keys) {
    Wandering w;
    w.direction = keys.storedText("direction");
    w.std = keys.stored("std_si");
    w.timeConstant = keys.stored("time_constant_s");
    if (keys.has("smooth")) w.smooth = keys.flag("smooth");
    drift.push_back(std::move(w));
  });
}

void readCompensation(const YamlMapping& root, ControllerCompensation& active) {
  const std::string name = "controller_compensation";
  if (!root.has(name)) return;  // not stated
  if (root.node(name).IsScalar()) {
    if (root.storedText(name) != "none") root.fail(name, "is neither none nor files");
    active.stated = ControllerCompensation::Stated::kNone;
    return;
  }
  active.stated = ControllerCompensation::Stated::kFiles;
  const YamlMapping keys = root.map(name);
  active.target = keys.storedText("target");
  eachOf(keys, "files", name + ".files", false, [&](const YamlMapping& file) {
    active.files.push_back({file.storedText("path"), file.storedText("text")});
  });
  if (keys.storedText("checksum") != active.checksum()) keys.fail("checksum", "is not that of the files");
  keys.finish();
}

void readArtifact(const YamlMapping& root, Calibration& c) {
  if (!root.has("artifact")) return;  // written before it was told
  const YamlMapping keys = root.map("artifact");
  CalibratedBy a;
  a.name = keys.storedText("name");
  a.features = integer<std::int64_t>(keys, "features");
  a.poseKnown = keys.flag("pose_known");
  a.tipRadius = keys.stored("tip_radius_m");
  a.span = keys.stored("span_m");
  a.centreStd = keys.stored("centre_std_m");
  a.radiusStd = keys.stored("radius_std_m");
  if (keys.has("serial")) a.serial = keys.storedText("serial");
  eachOf(keys, "found", "artifact.found", true, [&](const YamlMapping& one) {
    FoundInArtifact f;
    f.name = one.storedText("name");
    f.ball = one.flag("ball");
    f.free = one.flag("free");
    f.position = vectorOf(one, "position_m");
    f.std = vectorOf(one, "std_m");
    f.radius = one.stored("radius_m");
    f.radiusStd = one.stored("radius_std_m");
    a.found.push_back(std::move(f));
  });
  keys.finish();
  c.artifact = a;
}

void readLedger(const YamlMapping& root, std::vector<LedgerEntry>& ledger) {
  eachOf(root, "ledger", "ledger", false, [&](const YamlMapping& keys) {
    LedgerEntry entry;
    entry.action = keys.storedText("action");
    if (keys.has("effect")) entry.effect = effectSpecOf(keys.node("effect"), root.source());
    entry.time = keys.storedText("time");
    entry.rmsBefore = keys.stored("rms_before_si");
    entry.rmsAfter = keys.stored("rms_after_si");
    entry.heldOutBefore = keys.stored("held_out_before_si");
    entry.heldOutAfter = keys.stored("held_out_after_si");
    entry.calibration = keys.storedText("calibration");
    entry.sessions = namesIn(keys, "sessions", true);
    ledger.push_back(std::move(entry));
  });
}

Calibration readAll(const YAML::Node& node, const std::string& source) {
  const YamlMapping root =
      YamlMapping::written(node, source, "calibration", "; calibrate again or take an undamaged copy");
  root.node("checksum");
  const int schema = integer<int>(root, "schema");
  if (schema != kCalibrationSchema)
    throw InputError(source + ":2: schema " + std::to_string(schema) + ", but this version reads " +
                     std::to_string(kCalibrationSchema) + "; use the version that wrote it");
  Calibration c;
  c.id = root.storedText("id");
  c.created = root.storedText("created");
  c.software = root.storedText("software");
  c.machineName = root.storedText("machine");
  readModel(root, c);
  readDomain(root.map("domain"), c.domain, c.networks);
  const YamlMapping session = root.map("session");
  c.sessionSource = session.storedText("source");
  c.sessionHash = session.storedText("hash");
  eachOf(session, "parts", "session.parts", true, [&](const YamlMapping& part) {
    c.sessionParts.push_back({part.storedText("source"), part.storedText("hash")});
  });
  c.sessionEpoch = session.stored("epoch_s");
  c.toldSpace = session.has("namespace");
  if (c.toldSpace) c.sessionSpace = session.storedText("namespace");
  c.method = session.storedText("method");
  c.seed = integer<std::uint64_t>(session, "seed");
  c.observations = integer<std::int64_t>(session, "observations");
  session.finish();
  const YamlMapping residuals = root.map("residuals");
  c.rms = residuals.stored("rms_m");
  c.heldOutRms = residuals.stored("held_out_rms_m");
  c.rmsAngular = residuals.stored("rms_rad");
  c.heldOutRmsAngular = residuals.stored("held_out_rms_rad");
  c.chi2PerDof = residuals.stored("chi2_per_dof");
  if (residuals.has("degrees_of_freedom")) c.degreesOfFreedom = residuals.stored("degrees_of_freedom");
  c.repeatability = residuals.stored("repeatability_si");
  c.repeatabilityFrom = residuals.storedText("repeatability_from");
  residuals.finish();
  readDrift(root, c.drift);
  readArtifact(root, c);
  readCompensation(root, c.compensation);
  readLedger(root, c.ledger);
  c.urdf = root.storedText("urdf");
  root.finish();
  return c;
}

/// Kinds, axes and limits of the joints are those of the URDF, which is in the file.
void addMachine(Calibration& c, const std::string& source) {
  const Machine machine(c.urdf, c.machineName);
  bool same = machine.joints().size() == c.domain.joints.size();
  for (std::size_t j = 0; same && j < machine.joints().size(); ++j)
    same = machine.joints()[j].name == c.domain.joints[j].name;
  if (!same) throw InputError(source + ": 'domain.joints' are not the joints of 'urdf'; calibrate again");
  c.domain.setMachine(machine);
}

/// The first line must be the checksum of all that follows it.
void checkIntegrity(const std::string& text, const std::string& source) {
  const std::string remedy = "; take an undamaged copy or calibrate again (mm history lists what is kept)";
  constexpr const char kFirst[] = "checksum: crc64-";
  constexpr std::size_t kDigitsAt = sizeof kFirst - 1, kDigits = 16;
  if (text.empty()) throw InputError(source + ": damaged calibration file: it is empty" + remedy);
  if (text.compare(0, kDigitsAt, kFirst) != 0 || text.size() <= kDigitsAt + kDigits ||
      text[kDigitsAt + kDigits] != '\n')
    throw InputError(source + ":1: not a calibration file, or damaged: the first line is not its checksum" +
                     remedy);
  const std::string actual = checksumOf(std::string_view(text).substr(kDigitsAt + kDigits + 1));
  if (text.compare(kDigitsAt, kDigits, actual) != 0)
    throw InputError(source + ":1: damaged calibration file: the checksum says " +
                     text.substr(kDigitsAt, kDigits) + ", the content has " + actual +
                     "; it was cut short or changed after it was written" + remedy);
}

}  // namespace

Calibration parseCalibration(const std::string& text, const std::string& source) {
  checkIntegrity(text, source);
  try {
    Calibration calibration = readAll(YAML::Load(text), source);
    addMachine(calibration, source);
    return calibration;
  } catch (const YAML::Exception& e) {
    throw InputError(source + ":" + std::to_string(e.mark.line + 1) + ": not valid YAML: " + e.msg);
  } catch (const InputError& e) {
    const std::string what = e.what();
    throw InputError(what.compare(0, source.size(), source) == 0 ? what : source + ": " + what);
  }
}

Calibration loadCalibration(const std::filesystem::path& file) {
  return parseCalibration(readFile(file), file.string());
}

}  // namespace mm
