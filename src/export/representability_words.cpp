#include <cmath>

#include "base/format.h"
#include "base/units.h"
#include "export/representability.h"

namespace mm {
namespace {

using nlohmann::ordered_json;

ordered_json micrometres(double metres) {
  return std::isfinite(metres) ? ordered_json(metres / kMicrometre) : ordered_json(nullptr);
}

ordered_json effectJson(const EffectSpec& spec) {
  ordered_json json{{"type", spec.type}};
  for (const auto& [key, value] : spec.keys) {
    if (value.list)
      json[key] = value.items;
    else
      json[key] = value.items.empty() ? std::string() : value.items[0];
  }
  return json;
}

std::string um(double metres) {
  return std::isfinite(metres) ? format("%.3g um", metres / kMicrometre) : std::string("not known");
}

}  // namespace

ordered_json representabilityJson(const Representability& judged) {
  const ExportFigures& f = judged.figures;
  ordered_json json{{"target", judged.target},
                    {"rms_um",
                     {{"uncorrected", micrometres(f.uncorrected)},
                      {"exported", micrometres(f.exported)},
                      {"full", micrometres(judged.full)}}},
                    {"rms_not_aligned_um",
                     {{"uncorrected", micrometres(f.unalignedUncorrected)},
                      {"exported", micrometres(f.unalignedExported)}}},
                    {"carries_nothing", judged.carriesNothing()}};
  if (std::isfinite(f.withOffsets)) json["rms_with_offsets_um"] = micrometres(f.withOffsets);
  json["effects"] = ordered_json::array();
  for (const CarriedEffect& e : judged.effects)
    json["effects"].push_back({{"effect", effectJson(e.effect)},
                               {"carried", e.carried},
                               {"why", e.why},
                               {"rms_um",
                                {{"uncorrected", micrometres(e.figures.uncorrected)},
                                 {"exported", micrometres(e.figures.exported)}}}});
  json["calibration"] = judged.calibration;
  json["axes"] = judged.letters;
  json["sensors"] = judged.sensors;
  json["files"] = ordered_json::array();
  for (const ExportedFile& file : judged.files)
    json["files"].push_back({{"path", file.path}, {"what", file.what}});
  return json;
}

std::string representabilityText(const Representability& judged) {
  const ExportFigures& f = judged.figures;
  std::string text =
      "RMS of a coordinate over the calibrated volume, temperatures and directions of travel:\n";
  text += "  uncorrected          " + um(f.uncorrected) + "\n  with this export     " + um(f.exported);
  if (std::isfinite(f.withOffsets)) text += "\n  and external offsets " + um(f.withOffsets);
  text += "\n  with the full model  " + um(judged.full) + " (what it left of the session)\n";
  text += "An alignment of the workpiece is taken out; without that " + um(f.unalignedUncorrected) + " and " +
          um(f.unalignedExported) + ".\n\n";
  for (const CarriedEffect& e : judged.effects)
    text += format("%-12s ", e.carried.c_str()) + e.effect.yaml() + "\n             " + e.why + "\n";
  if (judged.effects.empty()) text += "The calibration has no effects: there is nothing to carry.\n";
  return text;
}

}  // namespace mm
