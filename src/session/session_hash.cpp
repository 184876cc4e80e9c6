#include "session/session_hash.h"

#include <cmath>
#include <cstdint>
#include <cstring>

#include "base/format.h"

namespace mm {
namespace {

/// Two independent 64-bit lanes, each fed whole words; every step is invertible, so no word is lost.
class Hash {
 public:
  void word(std::uint64_t w) {
    a_ = mix(a_ ^ w, 0xff51afd7ed558ccdULL);
    b_ = mix(b_ + w, 0xc4ceb9fe1a85ec53ULL);
  }
  /// Whole numbers, kinds and flags.
  template <typename T>
  void add(const T& value) {
    word(static_cast<std::uint64_t>(value));
  }
  void add(double value) {
    std::uint64_t bits = 0x7ff8000000000000ULL;  // one NaN stands for all: they mean "not measured"
    if (!std::isnan(value)) std::memcpy(&bits, &value, sizeof bits);
    word(bits);
  }
  void add(const std::vector<double>& values) {
    word(values.size());
    for (const double v : values) add(v);
  }
  void add(const Eigen::Vector3d& v) {
    for (int i = 0; i < 3; ++i) add(v[i]);
  }
  void add(const std::string& t) {
    word(t.size());
    for (std::size_t i = 0; i < t.size(); i += sizeof(std::uint64_t)) {
      std::uint64_t w = 0;
      for (std::size_t k = i; k < t.size() && k < i + sizeof w; ++k)
        w = w << 8 | static_cast<unsigned char>(t[k]);
      word(w);
    }
  }
  /// One after the other.
  template <typename... Values>
  void all(const Values&... values) {
    (add(values), ...);
  }
  std::string digits() const {
    return format("%016llx%016llx", static_cast<unsigned long long>(a_), static_cast<unsigned long long>(b_));
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

void addArtifact(Hash& hash, const Artifact& a) {
  hash.all(a.name, a.poseKnown, a.tipRadius, a.repeatability, a.expansion, a.temperatureSensor);
  if (!a.serial.empty()) hash.add(a.serial);
  for (const Stylus& s : a.styli) hash.all(s.name, s.tipRadius, s.offset, s.known);
  hash.add(a.features.size());
  for (const Feature& f : a.features)
    hash.all(f.kind, f.name, f.position, f.known, f.positionStd, f.radius, f.radiusStd);
}

void addObservation(Hash& hash, const Observation& o) {
  hash.all(o.kind, o.time, o.position, o.velocity, o.travel, o.approach, o.laserReading, o.feature,
           o.reference, o.deviation, o.deviationStd, o.setup);
  if (o.kind == ObservationKind::kLength) hash.all(o.length);
  if (o.placement == 0 && o.stylus == 0 && o.recording == 0) return;  // as of older files, which have none
  hash.all(o.placement, o.stylus, o.recording);
}

void addSeries(Hash& hash, const std::vector<Series>& all) {
  hash.add(all.size());
  for (const Series& s : all) hash.all(s.name, s.unit, s.time, s.value);
}

}  // namespace

std::string sessionHash(const Session& session) {
  Hash hash;
  hash.add(session.machine.urdf());
  addArtifact(hash, session.artifact);
  hash.add(session.observations.size());
  for (const Observation& o : session.observations) addObservation(hash, o);
  addSeries(hash, session.temperatures);
  addSeries(hash, session.covariates);
  hash.add(session.setups.size());
  for (const std::string& s : session.setups) hash.add(s);
  for (const std::string& s : session.placements) hash.add(s);
  for (const Recording& r : session.recordings) hash.add(r.hash);
  if (session.compensation.stated != ControllerCompensation::Stated::kNot)
    hash.add(session.compensation.inWords());
  if (!session.timesAssumed.empty()) hash.add(session.timesAssumed);
  return hash.digits();
}

}  // namespace mm
