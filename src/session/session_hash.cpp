#include "session/session_hash.h"

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>

namespace mm {
namespace {

/// Two independent 64-bit lanes, each fed whole words; every step is invertible, so no word is lost.
class Hash {
 public:
  void word(std::uint64_t w) {
    a_ = mix(a_ ^ w, 0xff51afd7ed558ccdULL);
    b_ = mix(b_ + w, 0xc4ceb9fe1a85ec53ULL);
  }
  void number(double value) {
    std::uint64_t bits = 0x7ff8000000000000ULL;  // one NaN stands for all: they mean "not measured"
    if (!std::isnan(value)) std::memcpy(&bits, &value, sizeof bits);
    word(bits);
  }
  void numbers(const std::vector<double>& values) {
    word(values.size());
    for (const double v : values) number(v);
  }
  void vector(const Eigen::Vector3d& v) {
    for (int i = 0; i < 3; ++i) number(v[i]);
  }
  void text(const std::string& t) {
    word(t.size());
    for (std::size_t i = 0; i < t.size(); i += sizeof(std::uint64_t)) {
      std::uint64_t w = 0;
      for (std::size_t k = i; k < t.size() && k < i + sizeof w; ++k)
        w = w << 8 | static_cast<unsigned char>(t[k]);
      word(w);
    }
  }
  std::string digits() const {
    char buffer[33];
    std::snprintf(buffer, sizeof buffer, "%016llx%016llx", static_cast<unsigned long long>(a_),
                  static_cast<unsigned long long>(b_));
    return buffer;
  }

 private:
  static std::uint64_t mix(std::uint64_t x, std::uint64_t odd) {
    x *= odd;
    x ^= x >> 32;
    x *= 0x9e3779b97f4a7c15ULL;
    return x ^ x >> 29;
  }
  std::uint64_t a_ = 0x243f6a8885a308d3ULL, b_ = 0x13198a2e03707344ULL;  // digits of pi
};

void addArtifact(Hash& hash, const Artifact& artifact) {
  hash.text(artifact.name);
  hash.word(artifact.poseKnown);
  hash.number(artifact.tipRadius);
  hash.number(artifact.repeatability);
  hash.number(artifact.expansion);
  hash.text(artifact.temperatureSensor);
  if (!artifact.serial.empty()) hash.text(artifact.serial);
  for (const Stylus& s : artifact.styli) {
    hash.text(s.name);
    hash.number(s.tipRadius);
    hash.vector(s.offset);
    hash.word(s.known);
  }
  hash.word(artifact.features.size());
  for (const Feature& f : artifact.features) {
    hash.word(static_cast<std::uint64_t>(f.kind));
    hash.text(f.name);
    hash.vector(f.position);
    hash.word(f.known);
    hash.number(f.positionStd);
    hash.number(f.radius);
    hash.number(f.radiusStd);
  }
}

void addObservation(Hash& hash, const Observation& o) {
  hash.word(static_cast<std::uint64_t>(o.kind));
  hash.number(o.time);
  hash.numbers(o.position);
  hash.numbers(o.velocity);
  hash.numbers(o.travel);
  hash.vector(o.approach);
  hash.number(o.laserReading);
  hash.word(static_cast<std::uint64_t>(o.feature));
  hash.vector(o.reference);
  hash.numbers(o.deviation);
  hash.numbers(o.deviationStd);
  hash.word(static_cast<std::uint64_t>(o.setup));
  if (o.kind == ObservationKind::kLength) hash.number(o.length);
  if (o.placement == 0 && o.stylus == 0 && o.recording == 0) return;  // as of older files, which have none
  for (const int index : {o.placement, o.stylus, o.recording}) hash.word(static_cast<std::uint64_t>(index));
}

void addSeries(Hash& hash, const std::vector<Series>& all) {
  hash.word(all.size());
  for (const Series& s : all) {
    hash.text(s.name);
    hash.text(s.unit);
    hash.numbers(s.time);
    hash.numbers(s.value);
  }
}

}  // namespace

std::string sessionHash(const Session& session) {
  Hash hash;
  hash.text(session.machine.urdf());
  addArtifact(hash, session.artifact);
  hash.word(session.observations.size());
  for (const Observation& o : session.observations) addObservation(hash, o);
  addSeries(hash, session.temperatures);
  addSeries(hash, session.covariates);
  hash.word(session.setups.size());
  for (const std::string& s : session.setups) hash.text(s);
  for (const std::string& s : session.placements) hash.text(s);
  for (const Recording& r : session.recordings) hash.text(r.hash);
  if (session.compensation.stated != ControllerCompensation::Stated::kNot)
    hash.text(session.compensation.inWords());
  return hash.digits();
}

}  // namespace mm
