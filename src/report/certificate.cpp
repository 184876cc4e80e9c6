#include "report/certificate.h"

#include <algorithm>
#include <set>

#include "base/format.h"
#include "compensation/compensator.h"
#include "effects/effect_words.h"
#include "machine/joint_units.h"

namespace mm {
namespace {

constexpr std::size_t kCurvePoints = 2001;  // more than a plot shows; short waves are followed

std::string verifiedInWords(const CalibrationStore::Verified& v) {
  const double unit = v.angular ? kArcsecond : kMicrometre;
  return "compared with fresh points: " + spaced(v.verdict) +
         format(", %.3g ± %.1g → %.3g ± %.1g %s (k = 2) at %d points", v.before / unit,
                2.0 * v.beforeStd / unit, v.after / unit, 2.0 * v.afterStd / unit,
                v.angular ? "arcsec" : "µm", v.points) +
         (v.session.empty() ? "" : " (" + v.session + ")");
}

/// Correction and its covariance along one axis, at even points over the calibrated range. @param j index of
/// its joint. @return no points where an input is not known.
CorrectionCurve curveOver(const Compensator& compensator, const State& middle, std::size_t j) {
  const Domain& d = compensator.model().domain();
  const JointUnit unit = readingUnit(d.joints[j]);
  CorrectionCurve curve;
  curve.axis = d.joints[j].name;
  curve.unit = unit.symbol;
  for (std::size_t i = 0; i < kCurvePoints; ++i) {
    State state = middle;
    state.position[j] = d.lower[j] + (d.upper[j] - d.lower[j]) * static_cast<double>(i) /
                                         static_cast<double>(kCurvePoints - 1);
    compensator.model().place(state);
    const Correction c = compensator.apply(state);
    if (!c.displacement.allFinite() || !c.covariance.allFinite()) return {};
    curve.at.push_back(state.position[j] / unit.factor);
    curve.correction.emplace_back(c.displacement / kMicrometre);
    curve.expanded.emplace_back(2.0 / kMicrometre * c.covariance.diagonal().cwiseMax(0.0).cwiseSqrt());
  }
  return curve;
}

}  // namespace

std::optional<StoreRecord> storeRecord(const CalibrationStore& store, const Calibration& calibration) {
  if (calibration.id.empty() || !store.keeps(calibration.id)) return std::nullopt;
  StoreRecord record;
  record.folder = store.folder().string();
  record.active = store.linked("active") == calibration.id;
  std::set<std::string> others;  // of another machine
  for (const CalibrationStore::Entry& entry : store.history())
    if (entry.damaged.empty() && entry.machine != calibration.machineName) others.insert(entry.id);
  const auto promotions = store.promotions();
  for (std::size_t i = 0; i < promotions.size(); ++i) {
    if (others.count(promotions[i].id) > 0) continue;
    record.events.push_back({promotions[i].time, promotions[i].id,
                             promotions[i].action == "rollback" ? "made active again" : "made active",
                             i + 1 < promotions.size() ? promotions[i + 1].time : std::string()});
  }
  for (const CalibrationStore::Verified& v : store.verifications())
    if (others.count(v.id) == 0) record.events.push_back({v.time, v.id, verifiedInWords(v), {}});
  std::stable_sort(record.events.begin(), record.events.end(),
                   [](const StoreEvent& a, const StoreEvent& b) { return a.time < b.time; });
  return record;
}

std::vector<CorrectionCurve> correctionCurves(const Calibration& calibration) {
  std::vector<CorrectionCurve> curves;
  const Compensator compensator(calibration);
  const Domain& d = compensator.model().domain();
  State middle = middleState(compensator);
  middle.time = d.duration;
  middle.travel.assign(d.joints.size(), 1.0);
  for (std::size_t j = 0; j < d.joints.size(); ++j) {
    if (!(d.upper[j] - d.lower[j] > kStoodStill)) continue;
    CorrectionCurve curve = curveOver(compensator, middle, j);
    if (!curve.at.empty()) curves.push_back(std::move(curve));
  }
  return curves;
}

}  // namespace mm
