#include "workbench/calibration_documents.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/quantity_words.h"
#include "base/units.h"
#include "compensation/compensator.h"
#include "effects/catalogue.h"
#include "effects/effect_words.h"
#include "export/export_target.h"
#include "machine/joint_units.h"
#include "report/json_parts.h"
#include "report/symbols_of.h"
#include "report/text_parts.h"

namespace mm {
namespace {

constexpr int kGrid = 5;                  // places along each linear joint
constexpr double kCorrectionStep = 1e-4;  // um

Json calibratedFigures(const Calibration& c) {
  const bool angular = angularOnly(c);
  return jsonObject({figureOf(angular, "rms", angular ? c.rmsAngular : c.rms),
                     figureOf(angular, "held_out_rms", angular ? c.heldOutRmsAngular : c.heldOutRms),
                     figureOf(angular, "repeatability", c.repeatability),
                     {{"repeatability_from", c.repeatabilityFrom}, {"chi2_per_dof", c.chi2PerDof}}});
}

Json rangesJson(const Domain& domain) {
  Json out = Json::array();
  for (std::size_t j = 0; j < domain.joints.size(); ++j) {
    const JointUnit unit = readingUnit(domain.joints[j]);
    out.push_back(rangeJson(domain.joints[j].name, unit.symbol,
                            rounded(domain.lower[j] / unit.factor, kPlaceStep),
                            rounded(domain.upper[j] / unit.factor, kPlaceStep)));
  }
  for (std::size_t s = 0; s < domain.sensors.size(); ++s)
    out.push_back(
        rangeJson("temperature " + domain.sensors[s], "degC", domain.sensorLower[s], domain.sensorUpper[s]));
  return out;
}

/// The linear joints that were moved, at most three: the grid runs over them.
std::vector<std::size_t> gridJoints(const Domain& domain) {
  std::vector<std::size_t> joints;
  for (std::size_t j = 0; j < domain.joints.size() && joints.size() < 3; ++j)
    if (domain.joints[j].kind == JointKind::kLinear && domain.upper[j] - domain.lower[j] > kStoodStill)
      joints.push_back(j);
  return joints;
}

Json fieldJson(const Calibration& calibration) {
  const Compensator compensator(calibration);
  const Domain& domain = calibration.domain;
  State state = middleState(compensator);
  state.travel.assign(state.position.size(), 1.0);
  const std::vector<std::size_t> joints = gridJoints(domain);
  Compensator::Workspace work;
  Json at = Json::array(), move = Json::array(), sigma = Json::array();
  std::string reason;
  int count = 1;
  for (std::size_t j = 0; j < joints.size(); ++j) count *= kGrid;
  for (int place = 0; place < count; ++place) {
    int rest = place;
    for (const std::size_t j : joints) {
      const double share = static_cast<double>(rest % kGrid) / (kGrid - 1);
      state.position[j] = domain.lower[j] + share * (domain.upper[j] - domain.lower[j]);
      rest /= kGrid;
    }
    compensator.model().place(state);
    const Correction c = compensator.apply(state, work);
    if (!c.valid) reason = c.reason;
    if (!c.valid || !c.displacement.allFinite()) continue;
    at.push_back(roundedList(c.nominal.position / kMillimetre, kPlaceStep));
    move.push_back(roundedList(c.displacement / kMicrometre, kCorrectionStep));
    sigma.push_back(rounded(c.sigma / kMicrometre, kCorrectionStep));
  }
  return {{"id", calibration.id},        {"effects", calibration.effects.size()},
          {"at_mm", std::move(at)},      {"move_um", std::move(move)},
          {"std_um", std::move(sigma)},  {"reason", reason},
          {"ranges", rangesJson(domain)}};
}

Json fieldOrReason(const Calibration* calibration) {
  if (calibration == nullptr) return nullptr;
  try {
    return fieldJson(*calibration);
  } catch (const Error& e) {
    return {{"id", calibration->id}, {"reason", e.what()}, {"at_mm", Json::array()}};
  }
}

}  // namespace

std::string calibrationDocument(const Calibration& c, bool kept) {
  const bool angular = angularOnly(c);
  Json effects = parametersJson(c), ledger = ledgerJson(c.ledger, angular, symbolsOf(c));
  for (std::size_t e = 0; e < c.effects.size(); ++e) effects[e]["yaml"] = c.effects[e].yaml();
  for (std::size_t i = 0; i < c.ledger.size(); ++i)
    ledger[i]["yaml"] = c.ledger[i].effect.type.empty() ? "" : c.ledger[i].effect.yaml();
  return jsonLine(jsonObject({{{"id", c.id},
                               {"kept", kept},
                               {"created", c.created},
                               {"machine", c.machineName},
                               {"session", c.sessionSource},
                               {"method", c.method},
                               {"seed", c.seed},
                               {"observations", c.observations},
                               {"unit", nameOfUnit(angular)}},
                              calibratedFigures(c),
                              {{"effects", effects}, {"ledger", ledger}, {"ranges", rangesJson(c.domain)}}}));
}

std::string historyDocument(const CalibrationStore& store) {
  const auto entry = [&](const CalibrationStore::Entry& e) {
    Json one = storedJson(e);
    one["method"] = e.method;
    one["effects"] = Json::array();
    if (!e.damaged.empty()) return one;
    const Calibration c = store.load(e.id);
    one["effects"] = parametersJson(c);
    one["observations"] = c.observations;
    return one;
  };
  return jsonLine({{"store", store.folder().string()}, {"calibrations", jsonList(store.history(), entry)}});
}

std::string correctionDocument(const Calibration* active, const Calibration* candidate) {
  return jsonLine({{"active", fieldOrReason(active)}, {"candidate", fieldOrReason(candidate)}});
}

std::string catalogueDocument() {
  const auto effect = [](const CatalogueEntry& e) -> Json {
    return {{"type", e.type},
            {"example", e.example},
            {"shown_by", e.shownBy},
            {"cause", e.cause},
            {"composite", e.composite}};
  };
  const auto controller = [](const ExportTarget& target) -> Json {
    return {{"name", target.name}, {"title", target.title}};
  };
  return jsonLine({{"effects", jsonList(effectCatalogue(), effect)},
                   {"controllers", jsonList(exportTargets(), controller)}});
}

}  // namespace mm
