// What must not change a calibration or a diagnosis does not change it, whatever the case (RapidCheck): the
// order of the rows, the units of the table, where the artifact's own frame lies, how the axes are called, a
// session that is there twice. RC_PARAMS="max_success=1000 seed=7" as RapidCheck's own documentation says;
// MM_LONG_TESTS=1: a hundred cases of each.
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <tuple>

#include "diagnosis/diagnose.h"
#include "import_support.h"
#include "long_tests.h"
#include "plate_rows.h"
#include "workflow/recalibration.h"

namespace mm {
namespace {

using test::PlateRow;

const bool kSet = [] {
  return ::setenv("RC_PARAMS",
                  mm_test::longTests()       ? "max_success=100"
                  : mm_test::thoroughTests() ? "max_success=4 seed=1"
                                             : "max_success=2 seed=1",
                  0) == 0;
}();

/// How one and the same measurement is written down.
struct Writing {
  std::vector<std::string> names{"x", "y", "z"};
  std::string unit = "mm", speed = "mm_s", temperature = "degC", time = "s";
  double perMillimetre = 1.0, perMillimetreASecond = 1.0, perSecond = 1.0;
  double perKelvin = 1.0, atZeroCelsius = 0.0;              // of a temperature
  std::vector<std::size_t> order;                           // of the rows; empty: as measured
  Eigen::Isometry3d frame = Eigen::Isometry3d::Identity();  // of the artifact's own coordinates, mm
  int copies = 1;
  bool later = true;  // each copy a minute after the one before, with times of its own
};

std::string number(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.14g", value);
  return text;
}

std::string csvOf(const std::vector<PlateRow>& rows, const Writing& w) {
  std::string csv = "time_" + w.time + ",feature,bed_" + w.temperature;
  for (const std::string& name : w.names)
    csv += "," + name + "_" + w.unit + "," + name + "_velocity_" + w.speed;
  csv += "\n";
  for (int copy = 0; copy < w.copies; ++copy)
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const PlateRow& r = rows[w.order.empty() ? i : w.order[i]];
      const double time = r.time + (w.later ? copy * (rows.back().time + 60.0) : 0.0);
      csv +=
          number(time * w.perSecond) + "," + r.feature + "," + number(r.bed * w.perKelvin + w.atZeroCelsius);
      for (int j = 0; j < 3; ++j)
        csv += "," + number(r.position[j] * w.perMillimetre) + "," +
               number(r.velocity[j] * w.perMillimetreASecond);
      csv += "\n";
    }
  return csv;
}

Artifact artifactOf(const Writing& w) {
  std::string yaml = "name: plate\npose: free\nprobe: {tip_radius_mm: 1.0, repeatability_um: 0.3}\nballs:\n";
  const auto centres = test::plateCentres();
  for (std::size_t b = 0; b < centres.size(); ++b) {
    const Eigen::Vector3d c = w.frame * centres[b];
    yaml += "  - {name: b" + std::to_string(b) + ", centre_mm: [" + number(c.x()) + ", " + number(c.y()) +
            ", " + number(c.z()) + "], radius_mm: 3.9685}\n";
  }
  return parseArtifact(yaml, "plate.yaml");
}

Machine machineOf(const Writing& w) {
  std::string urdf = test::readAll("urdf/three_axis.urdf");
  const char* const was[] = {"x", "y", "z"};
  for (int j = 0; j < 3; ++j) {
    const std::string before = std::string("<joint name=\"") + was[j] + "\"";
    const std::size_t at = urdf.find(before);
    if (at == std::string::npos) throw std::runtime_error("the URDF has another form");
    urdf.replace(at, before.size(), "<joint name=\"" + w.names[static_cast<std::size_t>(j)] + "\"");
  }
  return Machine(urdf, "machine.urdf");
}

Session sessionOf(const std::vector<PlateRow>& rows, const Writing& w) {
  const Artifact artifact = artifactOf(w);
  return *test::Importer(machineOf(w)).text(csvOf(rows, w), "", &artifact).session;
}

struct Found {
  std::vector<double> values, stds;  // SI
  double rms = 0.0;                  // m
};

Found calibrated(const Session& session, const std::vector<EffectSpec>& effects) {
  CalibrateOptions options;
  options.method = Method::kLeastSquares;
  const CalibrationResult r = calibrate(session, modelFor(session, effects), options);
  Found found;
  for (int p = 0; p < modelFor(session, effects).parameterCount(); ++p) {
    found.values.push_back(r.x[p]);
    found.stds.push_back(r.std(p));
  }
  found.rms = r.figures.rms;
  return found;
}

std::vector<EffectSpec> effectsFor(const Writing& w) {
  return {EffectSpec("scale").set("axis", w.names[0]), EffectSpec("scale").set("axis", w.names[2]),
          EffectSpec("backlash").set("axis", w.names[0])};
}

/// Values within a thousandth of what they are known to.
void expectSame(const Found& a, const Found& b) {
  RC_ASSERT(a.values.size() == b.values.size());
  for (std::size_t p = 0; p < a.values.size(); ++p) {
    RC_ASSERT(std::abs(a.values[p] - b.values[p]) < 1e-3 * a.stds[p]);
    RC_ASSERT(std::abs(a.stds[p] - b.stds[p]) < 1e-3 * a.stds[p]);
  }
  RC_ASSERT(std::abs(a.rms - b.rms) < 1e-4 * a.rms);
}

/// Verdict, causes with the axes under their first names, sizes.
std::string diagnosisOf(const Session& session, const Writing& w) {
  const Diagnosis d = diagnose(session, modelFor(session, {EffectSpec("scale").set("axis", w.names[0])}), {});
  std::string said = std::to_string(static_cast<int>(d.verdict));
  for (const CandidateResult& m : d.missing) {
    std::string axis = m.effect.text("axis");
    for (std::size_t j = 0; j < 3; ++j)
      if (axis == w.names[j]) axis = std::string(1, "xyz"[j]);
    said += " " + m.effect.type + " " + axis;
    for (const NamedValue& v : m.parameters) {
      char text[60];
      std::snprintf(text, sizeof text, " %s %.2f %s", v.name.c_str(), v.value, v.unit.c_str());
      said += text;
    }
  }
  return said;
}

const std::vector<PlateRow>& measured() {
  static const std::vector<PlateRow> rows = test::plateRows(3e-3, 24);
  return rows;
}

const Found& reference() {
  static const Found found = calibrated(sessionOf(measured(), {}), effectsFor({}));
  return found;
}

const std::string& verdict() {
  static const std::string said = diagnosisOf(sessionOf(measured(), {}), {});
  return said;
}

TEST(Invariance, ThereIsSomethingToBeChanged) {
  ASSERT_EQ(reference().values.size(), 3u);
  EXPECT_NEAR(reference().values[0], 50e-6, 10e-6);
  EXPECT_NEAR(reference().values[2], 3e-6, 0.3e-6);
  EXPECT_NE(verdict().find("backlash x gap"), std::string::npos) << verdict();
}

std::vector<std::size_t> anyOrder() {
  std::vector<std::size_t> order(measured().size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::mt19937_64 random(*rc::gen::arbitrary<std::uint64_t>());
  std::shuffle(order.begin(), order.end(), random);
  return order;
}

RC_GTEST_PROP(Invariance, TheOrderOfTheRows, ()) {
  Writing w;
  w.order = anyOrder();
  const Session session = sessionOf(measured(), w);
  expectSame(reference(), calibrated(session, effectsFor(w)));
  RC_ASSERT(diagnosisOf(session, w) == verdict());
}

RC_GTEST_PROP(Invariance, TheUnitsOfTheTable, ()) {
  Writing w;
  const auto of = [](std::vector<std::pair<const char*, double>> units) {
    return *rc::gen::elementOf(std::move(units));
  };
  std::tie(w.unit, w.perMillimetre) = of({{"m", 1e-3}, {"cm", 0.1}, {"um", 1e3}, {"inch", 1.0 / 25.4}});
  std::tie(w.speed, w.perMillimetreASecond) =
      of({{"m_s", 1e-3}, {"mm_min", 60.0}, {"um_s", 1e3}, {"inch_min", 60.0 / 25.4}});
  std::tie(w.time, w.perSecond) = of({{"ms", 1e3}, {"us", 1e6}, {"min", 1.0 / 60.0}, {"h", 1.0 / 3600.0}});
  std::tie(w.temperature, w.perKelvin) = of({{"K", 1.0}, {"degF", 1.8}});
  w.atZeroCelsius = w.temperature == "K" ? 273.15 : 32.0;
  const Session session = sessionOf(measured(), w);
  expectSame(reference(), calibrated(session, effectsFor(w)));
  RC_ASSERT(diagnosisOf(session, w) == verdict());
}

RC_GTEST_PROP(Invariance, WhereTheArtifactsOwnFrameLies, ()) {
  Writing w;
  const auto part = [] { return 1e-3 * *rc::gen::inRange(-1000, 1001); };
  Eigen::Vector3d about(part(), part(), part());
  RC_PRE(about.norm() > 0.1);
  w.frame = Eigen::Translation3d(400.0 * part(), 400.0 * part(), 400.0 * part()) *
            Eigen::AngleAxisd(M_PI * part(), about.normalized());
  const Session session = sessionOf(measured(), w);
  expectSame(reference(), calibrated(session, effectsFor(w)));
  RC_ASSERT(diagnosisOf(session, w) == verdict());
}

RC_GTEST_PROP(Invariance, HowTheAxesAreCalled, ()) {
  Writing w;
  const auto letter = rc::gen::inRange('d', static_cast<char>('s' + 1));
  const auto name = rc::gen::container<std::string>(3, letter);
  w.names = {*name, *name, *name};
  for (int j = 0; j < 3; ++j)
    w.names[static_cast<std::size_t>(j)] += "abc"[(j + *rc::gen::inRange(0, 1)) % 3];
  const Session session = sessionOf(measured(), w);
  expectSame(reference(), calibrated(session, effectsFor(w)));
  RC_ASSERT(diagnosisOf(session, w) == verdict());
}

// A file or a topic that holds every row twice to the same time, or a run that was pasted at later times.
RC_GTEST_PROP(Invariance, ASessionThatIsThereTwice, ()) {
  Writing w;
  w.copies = *rc::gen::inRange(2, 4);
  w.later = *rc::gen::arbitrary<bool>();
  if (!w.later && *rc::gen::arbitrary<bool>()) w.order = anyOrder();
  const Session session = sessionOf(measured(), w);
  RC_ASSERT(session.setAside.size() == (static_cast<std::size_t>(w.copies) - 1) * measured().size());
  expectSame(reference(), calibrated(session, effectsFor(w)));
  RC_ASSERT(diagnosisOf(session, w) == verdict());
}

}  // namespace
}  // namespace mm
