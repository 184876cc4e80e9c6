#include "calibration_file/calibration_yaml.h"

#include <yaml-cpp/yaml.h>

#include <cctype>
#include <charconv>
#include <cmath>
#include <type_traits>

#include "base/checksum.h"
#include "base/error.h"
#include "base/format.h"
#include "base/number_text.h"
#include "base/utc_now.h"
#include "base/version.h"
#include "base/yaml_mapping.h"
#include "calibration_file/atomic_file.h"
#include "effects/effect_yaml.h"

namespace mm {
namespace {

using YAML::BeginMap, YAML::BeginSeq, YAML::EndMap, YAML::EndSeq, YAML::Flow, YAML::Key, YAML::Value;

enum class Style { kBlock, kOneLine };  // of each mapping of a list

// The layout of the file is told once, by the functions `…Layout` below, to one of two: the Writer writes
// what it is shown, the Reader fills it with what the file has. Both have the same members; how a value is
// written follows from its type.

class Writer {
 public:
  static constexpr bool kReads = false;
  explicit Writer(YAML::Emitter& out) : out_(out) {}

  template <typename T>
  void operator()(const std::string& key, const T& value) {
    out_ << Key << key << Value;
    add(value);
  }
  /// A text, or a list of texts a line each, in quotes.
  void quoted(const char* key, const std::string& text) {
    out_ << Key << key << Value << YAML::DoubleQuoted << text;
  }
  void quoted(const char* key, const std::vector<std::string>& texts) {
    out_ << Key << key << Value << BeginSeq;
    for (const std::string& text : texts) out_ << YAML::DoubleQuoted << text;
    out_ << EndSeq;
  }
  /// A text of many lines, as it is where YAML can hold it so.
  void document(const char* key, const std::string& text) {
    const bool literal = text.size() > 1 && text.front() == '<' && text.back() == '\n' &&
                         text[text.size() - 2] != '\n' && text.find_first_of("\r\t") == std::string::npos;
    if (literal)
      out_ << Key << key << Value << YAML::Literal << text.substr(0, text.size() - 1);
    else
      quoted(key, text);
  }
  /// Behind the mapping of a list that is shown now.
  void comment(const std::string& text) { comment_ = text; }

  /// Whether a key that may be missing is there. @param here whether it is to be written.
  bool told(const char* /*key*/, bool here) const { return here; }
  /// Whether a key has a word and no mapping. @param here whether it is to be written so.
  bool isWord(const char* /*key*/, bool here) const { return here; }
  template <typename Show>
  void map(const char* key, Show show) {
    out_ << Key << key << Value << BeginMap;
    show(*this);
    out_ << EndMap;
  }
  /// Shows each of so many mappings: show(io, index).
  template <typename Show>
  void list(const char* key, std::size_t size, Style style, Show show) {
    out_ << Key << key << Value << BeginSeq;
    for (std::size_t i = 0; i < size; ++i) {
      if (style == Style::kOneLine) out_ << Flow;
      out_ << BeginMap;
      show(*this, i);
      out_ << EndMap;
      if (!comment_.empty()) out_ << YAML::Comment(comment_);
      comment_.clear();
    }
    out_ << EndSeq;
  }

 private:
  void add(double value) { out_ << numberText(value); }
  void add(bool value) { out_ << value; }
  template <typename Integer, std::enable_if_t<std::is_integral_v<Integer>, int> = 0>
  void add(Integer value) {
    out_ << std::to_string(value);
  }
  void add(const std::string& text) { out_ << text; }
  template <typename T>
  void add(const std::vector<T>& row) {
    out_ << Flow << BeginSeq;
    for (const T& item : row) add(item);
    out_ << EndSeq;
  }
  void add(const Eigen::Vector3d& v) { add(std::vector<double>(v.data(), v.data() + v.size())); }
  void add(const EffectSpec& spec) {
    out_ << Flow << BeginMap << Key << "type" << Value << spec.type;
    for (const auto& [key, value] : spec.keys) {
      out_ << Key << key << Value;
      if (value.list)
        add(value.items);
      else
        add(value.items.empty() ? std::string() : value.items.front());
    }
    out_ << EndMap;
  }
  void add(const std::vector<EffectSpec>& specs) {
    out_ << BeginSeq;
    for (const EffectSpec& spec : specs) add(spec);
    out_ << EndSeq;
  }
  /// A covariance; a symmetric one is written as its lower triangle.
  void add(const Eigen::MatrixXd& matrix) {
    const bool symmetric = matrix == matrix.transpose();
    out_ << BeginSeq;
    for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
      const Eigen::VectorXd row = matrix.row(i).head(symmetric ? i + 1 : matrix.cols());
      add(std::vector<double>(row.data(), row.data() + row.size()));
    }
    out_ << EndSeq;
  }

  YAML::Emitter& out_;
  std::string comment_;
};

class Reader {
 public:
  static constexpr bool kReads = true;
  /// @param path of this mapping, with a dot behind it; empty: the file's own.
  explicit Reader(YamlMapping keys, std::string path = {}) : keys_(std::move(keys)), path_(std::move(path)) {}

  void operator()(const std::string& key, double& value) { value = keys_.stored(key); }
  void operator()(const std::string& key, bool& value) { value = keys_.flag(key); }
  void operator()(const std::string& key, std::string& value) { value = keys_.storedText(key); }
  template <typename Integer, std::enable_if_t<std::is_integral_v<Integer>, int> = 0>
  void operator()(const std::string& key, Integer& value) {
    const std::string text = keys_.storedText(key);
    const auto read = std::from_chars(text.data(), text.data() + text.size(), value);
    if (read.ec != std::errc() || read.ptr != text.data() + text.size())
      throw InputError("'" + key + "' is '" + text + "', which is not a whole number in its range");
  }
  void operator()(const std::string& key, std::vector<double>& values) { values = keys_.storedList(key); }
  void operator()(const std::string& key, Eigen::Vector3d& value) {
    const std::vector<double> v = keys_.storedList(key);
    if (v.size() != 3) keys_.refuse(keys_.node(key), "'" + key + "' needs three numbers");
    value = {v[0], v[1], v[2]};
  }
  void operator()(const std::string& key, std::vector<std::string>& names) {
    for (const YAML::Node& name : keys_.list(key)) names.push_back(name.Scalar());
  }
  void operator()(const std::string& key, EffectSpec& spec) {
    spec = effectSpecOf(keys_.node(key), keys_.source());
  }
  void operator()(const std::string& key, std::vector<EffectSpec>& specs) {
    for (const YAML::Node& node : keys_.list(key)) specs.push_back(effectSpecOf(node, keys_.source()));
  }
  /// @param matrix has its size already.
  void operator()(const std::string& key, Eigen::MatrixXd& matrix) {
    const std::vector<YAML::Node> rows = keys_.list(key);
    const Eigen::Index n = matrix.rows();
    if (static_cast<Eigen::Index>(rows.size()) != n)
      keys_.refuse(keys_.node(key), "'" + key + "' needs one row a parameter");
    bool triangle = false;  // as the first row
    for (Eigen::Index i = 0; i < n; ++i) {
      const YAML::Node& node = rows[static_cast<std::size_t>(i)];
      const std::vector<double> row = keys_.storedList(node, key);
      const auto length = static_cast<Eigen::Index>(row.size());
      if (i == 0) triangle = length == 1;
      if (length != (triangle ? i + 1 : n)) keys_.refuse(node, "a row of '" + key + "' has the wrong length");
      for (Eigen::Index j = 0; j < length; ++j) {
        matrix(i, j) = row[static_cast<std::size_t>(j)];
        if (triangle) matrix(j, i) = matrix(i, j);
      }
    }
  }
  template <typename T>
  void quoted(const char* key, T& value) {
    (*this)(key, value);
  }
  void document(const char* key, std::string& text) { (*this)(key, text); }
  void comment(const std::string&) {}

  bool told(const char* key, bool) const { return keys_.has(key); }
  bool isWord(const char* key, bool) const { return keys_.node(key).IsScalar(); }
  template <typename Show>
  void map(const char* key, Show show) {
    Reader in(keys_.map(key), path_ + key + ".");
    show(in);
    in.keys_.finish();
  }
  template <typename Show>
  void list(const char* key, std::size_t, Style, Show show) {
    const std::vector<YAML::Node> items = keys_.list(key);
    for (std::size_t i = 0; i < items.size(); ++i) {
      Reader in(keys_.item(items[i], path_ + key, i));
      show(in, i);
      in.keys_.finish();
    }
  }
  const YamlMapping& keys() const { return keys_; }

 private:
  YamlMapping keys_;
  std::string path_;
};

/// Keys and their values, one after the other.
template <typename Io, typename T, typename... More>
void fields(Io& io, const std::string& key, T& value, More&&... more) {
  io(key, value);
  if constexpr (sizeof...(more) > 0) fields(io, more...);
}

/// A key that may be missing. @param here whether it is to be written.
template <typename Io, typename T>
void field(Io& io, const char* key, T& value, bool here) {
  if (io.told(key, here)) io(key, value);
}

/// Item `i` of a list that grows while it is read.
template <typename T>
T& at(std::vector<T>& list, std::size_t i) {
  if (i >= list.size()) list.resize(i + 1);
  return list[i];
}

/// A list of mappings: show(io, item).
template <typename Io, typename T, typename Show>
void items(Io& io, const char* key, std::vector<T>& all, Show show, Style style = Style::kBlock) {
  io.list(key, all.size(), style, [&](Io& in, std::size_t i) { show(in, at(all, i)); });
}

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
  Reader root(
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
  Writer writer(out);
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
