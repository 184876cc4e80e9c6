#include "calibration_file/calibration_yaml.h"

#include <yaml-cpp/yaml.h>

#include <cctype>
#include <cmath>

#include "base/checksum.h"
#include "base/error.h"
#include "base/format.h"
#include "base/utc_now.h"
#include "base/version.h"
#include "base/yaml_mapping.h"
#include "calibration_file/atomic_file.h"
#include "calibration_file/yaml_archive.h"

namespace mm {
namespace {

using YAML::BeginMap, YAML::EndMap, YAML::Key, YAML::Value;

// The layout of the file is told once, by the functions `…Layout` below, to a YamlWriter or a YamlReader.

/// Value and standard deviation in the unit of people, for a comment.
std::string forPeople(const Calibration::Value& v) {
  std::string comment = v.fixed ? format("%.6g (fixed) ", v.value * v.toUnit)
                                : format("%.6g +- %.2g ", v.value * v.toUnit, v.std * v.toUnit);
  comment += v.unit;
  for (char& c : comment)
    if (std::iscntrl(static_cast<unsigned char>(c))) c = ' ';
  return comment;
}

template <typename Io>
void modelLayout(Io& io, Calibration& c) {
  io("effects", c.effects);
  const auto parameter = [&](Io& in, Calibration::Value& v) {
    fields(in, "effect", v.effect, "name", v.name, "value_si", v.value, "std_si", v.std, "unit", v.unit,
           "to_unit", v.toUnit, "fixed", v.fixed);
    in.comment(forPeople(v));
    if constexpr (Io::kReads)
      if (v.effect < 0 || v.effect >= static_cast<int>(c.effects.size()))
        in.keys().fail("effect", "of parameter '" + v.name + "' is " + std::to_string(v.effect) + " of " +
                                     std::to_string(c.effects.size()));
  };
  items(io, "parameters", c.values, parameter, Style::kOneLine);
  const auto n = static_cast<Eigen::Index>(c.values.size());
  if (Io::kReads) c.covariance.resize(n, n);
  io("covariance_si", c.covariance);
}

template <typename Io>
void rangesLayout(Io& io, const char* key, const std::string& unit, std::vector<std::string>& names,
                  std::vector<double>& lower, std::vector<double>& upper) {
  io.list(key, names.size(), Style::kOneLine, [&](Io& in, std::size_t i) {
    fields(in, "name", at(names, i), "lower" + unit, at(lower, i), "upper" + unit, at(upper, i));
  });
}

template <typename Io>
void networkLayout(Io& io, LearnedNetwork& n) {
  fields(io, "effect", n.effect, "active", n.active, "summary", n.summary, "sensors", n.sensors,
         "positions_si", n.positions, "held_out_si", n.heldOut, "held_out_ridge_si", n.heldOutRidge,
         "held_out_none_si", n.heldOutNone, "network", n.numbers);
}

template <typename Io>
void domainLayout(Io& io, Domain& d, std::vector<LearnedNetwork>& networks) {
  io.list("joints", d.joints.size(), Style::kBlock, [&](Io& in, std::size_t j) {
    fields(in, "name", at(d.joints, j).name, "observed_lower_si", at(d.lower, j), "observed_upper_si",
           at(d.upper, j));
    if (in.told("velocity_lower_si", j < d.velocityLower.size()))
      fields(in, "velocity_lower_si", at(d.velocityLower, j), "velocity_upper_si", at(d.velocityUpper, j));
    in("positions_si", at(d.positions, j));
  });
  rangesLayout(io, "sensors", "_degC", d.sensors, d.sensorLower, d.sensorUpper);
  rangesLayout(io, "covariates", "", d.covariates, d.covariateLower, d.covariateUpper);
  fields(io, "features", d.features, "feature_radii_m", d.featureRadius);
  field(io, "styli", d.styli, !d.styli.empty());
  field(io, "sessions", d.recordings, d.recordings > 1);
  fields(io, "duration_s", d.duration, "max_speed_si", d.maxSpeed, "tip_lower_m", d.tipLower, "tip_upper_m",
         d.tipUpper, "laser", d.laser);
  if (io.told("reading_lower_m", std::isfinite(d.readingLower)))
    fields(io, "reading_lower_m", d.readingLower, "reading_upper_m", d.readingUpper);
  io("artifact_expansion_per_K", d.artifactExpansion);
  if (io.told("networks", !networks.empty())) items(io, "networks", networks, networkLayout<Io>);
}

template <typename Io>
void sessionLayout(Io& io, Calibration& c) {
  fields(io, "source", c.sessionSource, "hash", c.sessionHash);
  if (io.told("parts", !c.sessionParts.empty()))
    items(io, "parts", c.sessionParts,
          [](Io& in, SessionPart& part) { fields(in, "source", part.source, "hash", part.hash); });
  io("epoch_s", c.sessionEpoch);
  c.toldSpace = io.told("namespace", c.toldSpace);
  field(io, "namespace", c.sessionSpace, c.toldSpace);
  field(io, "origin", c.sessionOrigin, !c.sessionOrigin.empty());
  fields(io, "method", c.method, "seed", c.seed, "observations", c.observations);
}

template <typename Io>
void residualsLayout(Io& io, Calibration& c) {
  fields(io, "rms_m", c.rms, "held_out_rms_m", c.heldOutRms, "rms_rad", c.rmsAngular, "held_out_rms_rad",
         c.heldOutRmsAngular, "chi2_per_dof", c.chi2PerDof);
  field(io, "degrees_of_freedom", c.degreesOfFreedom, c.degreesOfFreedom > 0.0);
  fields(io, "repeatability_si", c.repeatability, "repeatability_from", c.repeatabilityFrom);
}

template <typename Io>
void driftLayout(Io& io, Wandering& w) {
  fields(io, "direction", w.direction, "std_si", w.std, "time_constant_s", w.timeConstant);
  field(io, "smooth", w.smooth, w.smooth);
}

template <typename Io>
void foundLayout(Io& io, FoundInArtifact& f) {
  fields(io, "name", f.name, "ball", f.ball, "free", f.free, "position_m", f.position, "std_m", f.std,
         "radius_m", f.radius, "radius_std_m", f.radiusStd);
}

template <typename Io>
void artifactLayout(Io& io, CalibratedBy& a) {
  fields(io, "name", a.name, "features", a.features, "pose_known", a.poseKnown, "tip_radius_m", a.tipRadius,
         "span_m", a.span, "centre_std_m", a.centreStd, "radius_std_m", a.radiusStd);
  field(io, "serial", a.serial, !a.serial.empty());
  if (io.told("found", !a.found.empty())) items(io, "found", a.found, foundLayout<Io>);
}

/// Nothing where nothing was stated.
template <typename Io>
void compensationLayout(Io& io, ControllerCompensation& active) {
  using Stated = ControllerCompensation::Stated;
  constexpr const char* kName = "controller_compensation";
  if (!io.told(kName, active.stated != Stated::kNot)) return;
  if (io.isWord(kName, active.stated == Stated::kNone)) {
    std::string word = "none";
    io(kName, word);
    if constexpr (Io::kReads)
      if (word != "none") io.keys().fail(kName, "is neither none nor files");
    active.stated = Stated::kNone;
    return;
  }
  active.stated = Stated::kFiles;
  io.map(kName, [&](Io& in) {
    std::string checksum = active.checksum();
    fields(in, "target", active.target, "checksum", checksum);
    items(in, "files", active.files, [](Io& one, ControllerCompensation::File& file) {
      one("path", file.path);
      one.quoted("text", file.text);
    });
    if constexpr (Io::kReads)
      if (checksum != active.checksum()) in.keys().fail("checksum", "is not that of the files");
  });
}

template <typename Io>
void ledgerLayout(Io& io, LedgerEntry& entry) {
  io("action", entry.action);
  field(io, "effect", entry.effect, !entry.effect.type.empty());
  fields(io, "time", entry.time, "rms_before_si", entry.rmsBefore, "rms_after_si", entry.rmsAfter,
         "held_out_before_si", entry.heldOutBefore, "held_out_after_si", entry.heldOutAfter, "calibration",
         entry.calibration);
  if (io.told("sessions", !entry.sessions.empty())) io.quoted("sessions", entry.sessions);
}

/// Everything below the line of the checksum and the version.
template <typename Io>
void layout(Io& io, Calibration& c) {
  fields(io, "id", c.id, "created", c.created, "software", c.software, "machine", c.machineName);
  modelLayout(io, c);
  io.map("domain", [&](Io& in) { domainLayout(in, c.domain, c.networks); });
  io.map("session", [&](Io& in) { sessionLayout(in, c); });
  io.map("residuals", [&](Io& in) { residualsLayout(in, c); });
  if (io.told("drift", !c.drift.empty())) items(io, "drift", c.drift, driftLayout<Io>);
  if (io.told("artifact", c.artifact.has_value())) {  // a file that was written before it was told has none
    if (!c.artifact) c.artifact.emplace();
    io.map("artifact", [&](Io& in) { artifactLayout(in, *c.artifact); });
  }
  compensationLayout(io, c.compensation);
  items(io, "ledger", c.ledger, ledgerLayout<Io>);
  io.document("urdf", c.urdf);
}

Calibration readAll(const YAML::Node& node, const std::string& source) {
  YamlReader root(
      YamlMapping::written(node, source, "calibration", "; calibrate again or take an undamaged copy"));
  root.keys().node("checksum");
  int schema = 0;
  root("schema", schema);
  if (schema != kCalibrationSchema)
    throw InputError(source + ":2: schema " + std::to_string(schema) + ", but this version reads " +
                     std::to_string(kCalibrationSchema) + "; use the version that wrote it");
  Calibration c;
  layout(root, c);
  root.keys().finish();
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
  const std::string remedy =
      "; use an undamaged copy or calibrate again (mm history lists stored calibrations)";
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
                     "; it was truncated or changed after it was written" + remedy);
}

void check(const Calibration& c) {
  const auto n = static_cast<Eigen::Index>(c.values.size());
  const std::size_t joints = c.domain.joints.size();
  bool consistent = c.covariance.rows() == n && c.covariance.cols() == n && c.domain.lower.size() == joints &&
                    c.domain.upper.size() == joints && c.domain.positions.size() == joints &&
                    c.domain.sensorLower.size() == c.domain.sensors.size() &&
                    c.domain.sensorUpper.size() == c.domain.sensors.size() &&
                    c.domain.covariateLower.size() == c.domain.covariates.size() &&
                    c.domain.covariateUpper.size() == c.domain.covariates.size();
  for (const Calibration::Value& v : c.values)
    consistent = consistent && v.effect >= 0 && v.effect < static_cast<int>(c.effects.size());
  if (!consistent)
    throw InputError("calibration '" + c.id +
                     "' contradicts itself: its covariance, ranges and parameters must be of "
                     "the same size; calibrate again");
}

/// Everything below the line of the checksum. @param c a copy, as the layout is that of the reader too.
std::string content(Calibration c) {
  YAML::Emitter out;
  out << BeginMap << Key << "schema" << Value << kCalibrationSchema;
  YamlWriter writer(out);
  layout(writer, c);
  out << EndMap;
  if (!out.good())
    throw InputError("calibration '" + c.id + "' cannot be written as YAML: " + out.GetLastError());
  return std::string(out.c_str()) + "\n";
}

}  // namespace

std::string calibrationYaml(const Calibration& calibration) {
  check(calibration);
  const std::string body = content(calibration);
  return "checksum: crc64-" + checksumOf(body) + "\n" + body;
}

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

void completeCalibration(Calibration& calibration) {
  if (calibration.software.empty()) calibration.software = kVersion;
  if (calibration.created.empty()) calibration.created = utcNow();
  if (!calibration.id.empty()) return;
  check(calibration);
  calibration.id = utcNow("%Y%m%dT%H%M%SZ-") + checksumOf(content(calibration)).substr(0, 8);
}

void saveCalibration(Calibration& calibration, const std::filesystem::path& file) {
  completeCalibration(calibration);
  writeFileAtomically(file, calibrationYaml(calibration));
}

Calibration loadCalibration(const std::filesystem::path& file) {
  return parseCalibration(readFile(file), file.string());
}

}  // namespace mm
