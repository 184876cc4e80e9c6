#include <yaml-cpp/yaml.h>

#include <cctype>
#include <cmath>
#include <cstdio>

#include "base/checksum.h"
#include "base/error.h"
#include "base/number_text.h"
#include "base/utc_now.h"
#include "base/version.h"
#include "calibration_file/atomic_file.h"
#include "calibration_file/calibration_yaml.h"

namespace mm {
namespace {

using YAML::BeginMap, YAML::BeginSeq, YAML::EndMap, YAML::EndSeq, YAML::Flow, YAML::Key, YAML::Value;

void number(YAML::Emitter& out, const char* key, double value) {
  out << Key << key << Value << numberText(value);
}

void text(YAML::Emitter& out, const char* key, const std::string& value) {
  out << Key << key << Value << value;
}

void numbers(YAML::Emitter& out, const std::vector<double>& values) {
  out << Flow << BeginSeq;
  for (const double v : values) out << numberText(v);
  out << EndSeq;
}

std::vector<double> toVector(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

void effect(YAML::Emitter& out, const EffectSpec& spec) {
  out << Flow << BeginMap << Key << "type" << Value << spec.type;
  for (const auto& [key, value] : spec.keys) {
    out << Key << key << Value;
    if (!value.list) {
      out << (value.items.empty() ? std::string() : value.items.front());
      continue;
    }
    out << Flow << BeginSeq;
    for (const std::string& item : value.items) out << item;
    out << EndSeq;
  }
  out << EndMap;
}

/// Value and standard deviation in the unit of people, for a comment.
std::string forPeople(const Calibration::Value& v) {
  char buffer[96];
  if (v.fixed)
    std::snprintf(buffer, sizeof buffer, "%.6g (fixed) ", v.value * v.toUnit);
  else
    std::snprintf(buffer, sizeof buffer, "%.6g +- %.2g ", v.value * v.toUnit, v.std * v.toUnit);
  std::string comment = buffer + v.unit;
  for (char& c : comment)
    if (std::iscntrl(static_cast<unsigned char>(c))) c = ' ';
  return comment;
}

void model(YAML::Emitter& out, const Calibration& c) {
  out << Key << "effects" << Value << BeginSeq;
  for (const EffectSpec& spec : c.effects) effect(out, spec);
  out << EndSeq << Key << "parameters" << Value << BeginSeq;
  for (const Calibration::Value& v : c.values) {
    out << Flow << BeginMap << Key << "effect" << Value << v.effect;
    text(out, "name", v.name);
    number(out, "value_si", v.value);
    number(out, "std_si", v.std);
    text(out, "unit", v.unit);
    number(out, "to_unit", v.toUnit);
    out << Key << "fixed" << Value << v.fixed << EndMap << YAML::Comment(forPeople(v));
  }
  out << EndSeq;
  // A symmetric matrix is written as its lower triangle.
  const bool symmetric = c.covariance == c.covariance.transpose();
  out << Key << "covariance_si" << Value << BeginSeq;
  for (Eigen::Index i = 0; i < c.covariance.rows(); ++i) {
    std::vector<double> row;
    for (Eigen::Index j = 0; j < (symmetric ? i + 1 : c.covariance.cols()); ++j)
      row.push_back(c.covariance(i, j));
    numbers(out, row);
  }
  out << EndSeq;
}

void ranges(YAML::Emitter& out, const char* key, const char* unit, const std::vector<std::string>& names,
            const std::vector<double>& lower, const std::vector<double>& upper) {
  out << Key << key << Value << BeginSeq;
  for (std::size_t i = 0; i < names.size(); ++i) {
    out << Flow << BeginMap;
    text(out, "name", names[i]);
    number(out, (std::string("lower") + unit).c_str(), lower[i]);
    number(out, (std::string("upper") + unit).c_str(), upper[i]);
    out << EndMap;
  }
  out << EndSeq;
}

void networks(YAML::Emitter& out, const std::vector<LearnedNetwork>& learned) {
  out << Key << "networks" << Value << BeginSeq;
  for (const LearnedNetwork& n : learned) {
    out << BeginMap;
    text(out, "effect", n.effect);
    out << Key << "active" << Value << n.active;
    text(out, "summary", n.summary);
    out << Key << "sensors" << Value << Flow << BeginSeq;
    for (const std::string& name : n.sensors) out << name;
    out << EndSeq << Key << "positions_si" << Value;
    numbers(out, n.positions);
    number(out, "held_out_si", n.heldOut);
    number(out, "held_out_ridge_si", n.heldOutRidge);
    number(out, "held_out_none_si", n.heldOutNone);
    out << Key << "network" << Value;
    numbers(out, n.numbers);
    out << EndMap;
  }
  out << EndSeq;
}

void domain(YAML::Emitter& out, const Domain& d, const std::vector<LearnedNetwork>& learned) {
  out << Key << "domain" << Value << BeginMap << Key << "joints" << Value << BeginSeq;
  for (std::size_t j = 0; j < d.joints.size(); ++j) {
    out << BeginMap;
    text(out, "name", d.joints[j].name);
    number(out, "observed_lower_si", d.lower[j]);
    number(out, "observed_upper_si", d.upper[j]);
    if (j < d.velocityLower.size()) {
      number(out, "velocity_lower_si", d.velocityLower[j]);
      number(out, "velocity_upper_si", d.velocityUpper[j]);
    }
    out << Key << "positions_si" << Value;
    numbers(out, d.positions[j]);
    out << EndMap;
  }
  out << EndSeq;
  ranges(out, "sensors", "_degC", d.sensors, d.sensorLower, d.sensorUpper);
  ranges(out, "covariates", "", d.covariates, d.covariateLower, d.covariateUpper);
  out << Key << "features" << Value << Flow << BeginSeq;
  for (const std::string& name : d.features) out << name;
  out << EndSeq << Key << "feature_radii_m" << Value;
  numbers(out, d.featureRadius);
  if (!d.styli.empty()) {
    out << Key << "styli" << Value << Flow << BeginSeq;
    for (const std::string& name : d.styli) out << name;
    out << EndSeq;
  }
  if (d.recordings > 1) out << Key << "sessions" << Value << d.recordings;
  number(out, "duration_s", d.duration);
  number(out, "max_speed_si", d.maxSpeed);
  out << Key << "tip_lower_m" << Value;
  numbers(out, toVector(d.tipLower));
  out << Key << "tip_upper_m" << Value;
  numbers(out, toVector(d.tipUpper));
  out << Key << "laser" << Value << d.laser;
  if (std::isfinite(d.readingLower)) {
    number(out, "reading_lower_m", d.readingLower);
    number(out, "reading_upper_m", d.readingUpper);
  }
  number(out, "artifact_expansion_per_K", d.artifactExpansion);
  if (!learned.empty()) networks(out, learned);
  out << EndMap;
}

void artifact(YAML::Emitter& out, const CalibratedBy& a) {
  out << Key << "artifact" << Value << BeginMap;
  text(out, "name", a.name);
  out << Key << "features" << Value << std::to_string(a.features);
  out << Key << "pose_known" << Value << a.poseKnown;
  number(out, "tip_radius_m", a.tipRadius);
  number(out, "span_m", a.span);
  number(out, "centre_std_m", a.centreStd);
  number(out, "radius_std_m", a.radiusStd);
  if (!a.serial.empty()) text(out, "serial", a.serial);
  if (!a.found.empty()) {
    out << Key << "found" << Value << BeginSeq;
    for (const FoundInArtifact& f : a.found) {
      out << BeginMap;
      text(out, "name", f.name);
      out << Key << "ball" << Value << f.ball << Key << "free" << Value << f.free;
      out << Key << "position_m" << Value;
      numbers(out, toVector(f.position));
      out << Key << "std_m" << Value;
      numbers(out, toVector(f.std));
      number(out, "radius_m", f.radius);
      number(out, "radius_std_m", f.radiusStd);
      out << EndMap;
    }
    out << EndSeq;
  }
  out << EndMap;
}

/// Nothing where nothing was stated.
void compensation(YAML::Emitter& out, const ControllerCompensation& active) {
  if (active.stated == ControllerCompensation::Stated::kNot) return;
  out << Key << "controller_compensation" << Value;
  if (active.stated == ControllerCompensation::Stated::kNone) {
    out << "none";
    return;
  }
  out << BeginMap;
  text(out, "target", active.target);
  text(out, "checksum", active.checksum());
  out << Key << "files" << Value << BeginSeq;
  for (const ControllerCompensation::File& file : active.files) {
    out << BeginMap << Key << "path" << Value << file.path << Key << "text" << Value << YAML::DoubleQuoted
        << file.text << EndMap;
  }
  out << EndSeq << EndMap;
}

void ledger(YAML::Emitter& out, const std::vector<LedgerEntry>& entries) {
  out << Key << "ledger" << Value << BeginSeq;
  for (const LedgerEntry& entry : entries) {
    out << BeginMap;
    text(out, "action", entry.action);
    if (!entry.effect.type.empty()) {
      out << Key << "effect" << Value;
      effect(out, entry.effect);
    }
    text(out, "time", entry.time);
    number(out, "rms_before_si", entry.rmsBefore);
    number(out, "rms_after_si", entry.rmsAfter);
    number(out, "held_out_before_si", entry.heldOutBefore);
    number(out, "held_out_after_si", entry.heldOutAfter);
    text(out, "calibration", entry.calibration);
    if (!entry.sessions.empty()) {
      out << Key << "sessions" << Value << BeginSeq;
      for (const std::string& session : entry.sessions) out << YAML::DoubleQuoted << session;
      out << EndSeq;
    }
    out << EndMap;
  }
  out << EndSeq;
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

/// Everything below the line of the checksum.
std::string content(const Calibration& c) {
  YAML::Emitter out;
  out << BeginMap << Key << "schema" << Value << kCalibrationSchema;
  text(out, "id", c.id);
  text(out, "created", c.created);
  text(out, "software", c.software);
  text(out, "machine", c.machineName);
  model(out, c);
  domain(out, c.domain, c.networks);
  out << Key << "session" << Value << BeginMap;
  text(out, "source", c.sessionSource);
  text(out, "hash", c.sessionHash);
  if (!c.sessionParts.empty()) {
    out << Key << "parts" << Value << BeginSeq;
    for (const SessionPart& part : c.sessionParts) {
      out << BeginMap;
      text(out, "source", part.source);
      text(out, "hash", part.hash);
      out << EndMap;
    }
    out << EndSeq;
  }
  number(out, "epoch_s", c.sessionEpoch);
  if (c.toldSpace) text(out, "namespace", c.sessionSpace);
  text(out, "method", c.method);
  out << Key << "seed" << Value << std::to_string(c.seed);
  out << Key << "observations" << Value << std::to_string(c.observations) << EndMap;
  out << Key << "residuals" << Value << BeginMap;
  number(out, "rms_m", c.rms);
  number(out, "held_out_rms_m", c.heldOutRms);
  number(out, "rms_rad", c.rmsAngular);
  number(out, "held_out_rms_rad", c.heldOutRmsAngular);
  number(out, "chi2_per_dof", c.chi2PerDof);
  if (c.degreesOfFreedom > 0.0) number(out, "degrees_of_freedom", c.degreesOfFreedom);
  number(out, "repeatability_si", c.repeatability);
  text(out, "repeatability_from", c.repeatabilityFrom);
  out << EndMap;
  if (!c.drift.empty()) {
    out << Key << "drift" << Value << BeginSeq;
    for (const Wandering& w : c.drift) {
      out << BeginMap;
      text(out, "direction", w.direction);
      number(out, "std_si", w.std);
      number(out, "time_constant_s", w.timeConstant);
      if (w.smooth) out << Key << "smooth" << Value << true;
      out << EndMap;
    }
    out << EndSeq;
  }
  if (c.artifact) artifact(out, *c.artifact);
  compensation(out, c.compensation);
  ledger(out, c.ledger);
  const bool literal = c.urdf.size() > 1 && c.urdf.front() == '<' && c.urdf.back() == '\n' &&
                       c.urdf[c.urdf.size() - 2] != '\n' && c.urdf.find_first_of("\r\t") == std::string::npos;
  out << Key << "urdf" << Value;
  if (literal)
    out << YAML::Literal << c.urdf.substr(0, c.urdf.size() - 1);
  else
    out << YAML::DoubleQuoted << c.urdf;
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

}  // namespace mm
