#include "report/certificate.h"

#include <algorithm>
#include <set>

#include "base/format.h"
#include "compensation/compensator.h"
#include "effects/effect_words.h"
#include "machine/joint_units.h"

namespace mm {
namespace {

constexpr std::size_t kCurvePoints = 41, kMostCurvePoints = 10241;  // even; doubled until they follow it
constexpr double kFollowed = 0.01;  // of the range of a curve: what chords may leave of it
constexpr double kRounding = 1e-6;  // um: of what is constant there is no more
/// Of the way from one point to the next, where a chord is held against its curve: a wave whose nodes are at
/// the points has none there.
constexpr double kBetween = 0.382;

std::string verifiedInWords(const CalibrationStore::Verified& v) {
  const double unit = v.angular ? kArcsecond : kMicrometre;
  return "compared with fresh points: " + spaced(v.verdict) +
         format(", %.3g ± %.1g → %.3g ± %.1g %s (k = 2) at %d points", v.before / unit,
                2.0 * v.beforeStd / unit, v.after / unit, 2.0 * v.afterStd / unit,
                v.angular ? "arcsec" : "µm", v.points) +
         (v.session.empty() ? "" : " (" + v.session + ")");
}

/// Correction and its covariance along one axis. @param j index of its joint. @param count even points over
/// the calibrated range. @return no points where an input is not known.
CorrectionCurve curveOver(const Compensator& compensator, const State& middle, std::size_t j,
                          std::size_t count) {
  const Domain& d = compensator.model().domain();
  const JointUnit unit = readingUnit(d.joints[j]);
  CorrectionCurve curve;
  curve.axis = d.joints[j].name;
  curve.unit = unit.symbol;
  for (std::size_t i = 0; i < count; ++i) {
    State state = middle;
    state.position[j] =
        d.lower[j] + (d.upper[j] - d.lower[j]) * static_cast<double>(i) / static_cast<double>(count - 1);
    compensator.model().place(state);
    const Correction c = compensator.apply(state);
    if (!c.displacement.allFinite() || !c.covariance.allFinite()) return {};
    curve.at.push_back(state.position[j] / unit.factor);
    curve.correction.emplace_back(c.displacement / kMicrometre);
    curve.expanded.emplace_back(2.0 / kMicrometre * c.covariance.diagonal().cwiseMax(0.0).cwiseSqrt());
  }
  return curve;
}

/// Whether chords between its points follow a curve.
bool follows(const CorrectionCurve& curve, const Compensator& compensator, const State& middle,
             std::size_t j) {
  Eigen::Vector3d low = curve.correction.front(), high = low;
  for (const Eigen::Vector3d& c : curve.correction) low = low.cwiseMin(c), high = high.cwiseMax(c);
  double left = 0.0;
  const double unit = readingUnit(compensator.model().domain().joints[j]).factor;
  for (std::size_t i = 0; i + 1 < curve.at.size(); ++i) {
    State state = middle;
    state.position[j] = (curve.at[i] + kBetween * (curve.at[i + 1] - curve.at[i])) * unit;
    compensator.model().place(state);
    const Eigen::Vector3d is = compensator.apply(state).displacement / kMicrometre;
    const Eigen::Vector3d chord = (1.0 - kBetween) * curve.correction[i] + kBetween * curve.correction[i + 1];
    left = std::max(left, (is - chord).cwiseAbs().maxCoeff());
    low = low.cwiseMin(is);
    high = high.cwiseMax(is);
  }
  return left <= std::max(kFollowed * (high - low).maxCoeff(), kRounding);
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
    CorrectionCurve curve = curveOver(compensator, middle, j, kCurvePoints);
    while (!curve.at.empty() && curve.at.size() < kMostCurvePoints && !follows(curve, compensator, middle, j))
      curve = curveOver(compensator, middle, j, 2 * curve.at.size() - 1);
    if (!curve.at.empty()) curves.push_back(std::move(curve));
  }
  return curves;
}

}  // namespace mm
