#include "report/certificate.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "base/format.h"
#include "base/units.h"
#include "compensation/middle_state.h"

namespace mm {
namespace {

constexpr int kCurvePoints = 41;

std::string verifiedInWords(const CalibrationStore::Verified& v) {
  const double unit = v.angular ? kArcsecond : kMicrometre;
  std::string verdict = v.verdict;
  std::replace(verdict.begin(), verdict.end(), '_', ' ');
  return "verified: " + verdict +
         format(", %.3g ± %.1g → %.3g ± %.1g %s (k = 2) at %d points", v.before / unit,
                2.0 * v.beforeStd / unit, v.after / unit, 2.0 * v.afterStd / unit,
                v.angular ? "arcsec" : "um", v.points) +
         (v.session.empty() ? "" : " (" + v.session + ")");
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

const std::string& numberOf(const Certificate& c) { return c.number.empty() ? c.calibration.id : c.number; }

std::vector<CorrectionCurve> correctionCurves(const Calibration& calibration) {
  std::vector<CorrectionCurve> curves;
  const Compensator compensator(calibration);
  const Domain& d = compensator.model().domain();
  State middle = middleState(compensator);
  middle.time = d.duration;
  middle.travel.assign(d.joints.size(), 1.0);
  for (std::size_t j = 0; j < d.joints.size(); ++j) {
    const double range = d.upper[j] - d.lower[j];
    if (!(range > kStoodStill)) continue;
    const bool rotary = d.joints[j].kind == JointKind::kRotary;
    CorrectionCurve curve;
    curve.axis = d.joints[j].name;
    curve.unit = rotary ? "deg" : "mm";
    bool known = true;
    for (int i = 0; i < kCurvePoints && known; ++i) {
      State state = middle;
      state.position[j] = d.lower[j] + range * i / (kCurvePoints - 1);
      compensator.model().place(state);
      const Correction c = compensator.apply(state);
      known = c.displacement.allFinite() && c.covariance.allFinite();
      curve.at.push_back(state.position[j] / (rotary ? kDegree : kMillimetre));
      curve.correction.emplace_back(c.displacement / kMicrometre);
      curve.expanded.emplace_back(2.0 / kMicrometre * c.covariance.diagonal().cwiseMax(0.0).cwiseSqrt());
    }
    if (known) curves.push_back(std::move(curve));
  }
  return curves;
}

}  // namespace mm
