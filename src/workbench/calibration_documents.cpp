#include "workbench/calibration_documents.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/units.h"
#include "compensation/middle_state.h"
#include "effects/catalogue.h"
#include "effects/effect_words.h"
#include "export/export_target.h"
#include "report/json_parts.h"
#include "workbench/compact_json.h"

namespace mm {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kGrid = 5;                  // places along each linear joint
constexpr double kCorrectionStep = 1e-4;  // um

bool angularOnly(const Calibration& c) { return !std::isfinite(c.rms) && std::isfinite(c.rmsAngular); }

void setCalibratedFigures(Json& out, const Calibration& c) {
  const bool angular = angularOnly(c);
  setEither(out, "rms", angular ? c.rmsAngular : c.rms, angular);
  setEither(out, "held_out_rms", angular ? c.heldOutRmsAngular : c.heldOutRms, angular);
  setEither(out, "repeatability", c.repeatability, angular);
  out["repeatability_from"] = c.repeatabilityFrom;
  out["chi2_per_dof"] = number(c.chi2PerDof);
}

Json rangesJson(const Domain& domain) {
  Json out = Json::array();
  for (std::size_t j = 0; j < domain.joints.size(); ++j) {
    const bool rotary = domain.joints[j].kind == JointKind::kRotary;
    const double unit = rotary ? kDegree : kMillimetre;
    out.push_back({{"name", domain.joints[j].name},
                   {"unit", rotary ? "deg" : "mm"},
                   {"lower", rounded(domain.lower[j] / unit, kPlaceStep)},
                   {"upper", rounded(domain.upper[j] / unit, kPlaceStep)}});
  }
  for (std::size_t s = 0; s < domain.sensors.size(); ++s)
    out.push_back({{"name", "temperature " + domain.sensors[s]},
                   {"unit", "degC"},
                   {"lower", number(domain.sensorLower[s])},
                   {"upper", number(domain.sensorUpper[s])}});
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
  Json out;
  out["id"] = c.id;
  out["kept"] = kept;
  out["created"] = c.created;
  out["machine"] = c.machineName;
  out["session"] = c.sessionSource;
  out["method"] = c.method;
  out["seed"] = c.seed;
  out["observations"] = c.observations;
  out["unit"] = angularOnly(c) ? "arcsec" : "um";
  setCalibratedFigures(out, c);
  out["effects"] = parametersJson(c);
  for (std::size_t e = 0; e < c.effects.size(); ++e) out["effects"][e]["yaml"] = c.effects[e].yaml();
  out["ledger"] = ledgerJson(c.ledger, angularOnly(c));
  for (std::size_t i = 0; i < c.ledger.size(); ++i)
    out["ledger"][i]["yaml"] = c.ledger[i].effect.type.empty() ? "" : c.ledger[i].effect.yaml();
  out["ranges"] = rangesJson(c.domain);
  return compact(out);
}

std::string historyDocument(const CalibrationStore& store) {
  Json list = Json::array();
  for (const CalibrationStore::Entry& e : store.history()) {
    Json one{{"id", e.id},
             {"created", e.created},
             {"active", e.active},
             {"candidate", e.candidate},
             {"promotions", e.promotions},
             {"machine", e.machine},
             {"method", e.method},
             {"rms_um", number(e.rms / kMicrometre)},
             {"held_out_rms_um", number(e.heldOutRms / kMicrometre)},
             {"session", e.session},
             {"damaged", e.damaged}};
    one["effects"] = Json::array();
    if (e.damaged.empty()) {
      const Calibration c = store.load(e.id);
      one["effects"] = parametersJson(c);
      one["observations"] = c.observations;
    }
    list.push_back(std::move(one));
  }
  return compact({{"store", store.folder().string()}, {"calibrations", std::move(list)}});
}

std::string correctionDocument(const Calibration* active, const Calibration* candidate) {
  return compact({{"active", fieldOrReason(active)}, {"candidate", fieldOrReason(candidate)}});
}

std::string catalogueDocument() {
  Json list = Json::array();
  for (const CatalogueEntry& e : effectCatalogue())
    list.push_back({{"type", e.type},
                    {"example", e.example},
                    {"shown_by", e.shownBy},
                    {"cause", e.cause},
                    {"composite", e.composite}});
  Json controllers = Json::array();
  for (const ExportTarget& target : exportTargets())
    controllers.push_back({{"name", target.name}, {"title", target.title}});
  return compact({{"effects", std::move(list)}, {"controllers", std::move(controllers)}});
}

}  // namespace mm
