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
  constexpr double kNothing = 1e-9;  // m: less than any controller or instrument resolves
  if (!std::isfinite(metres)) return "not known";
  return metres > 0.0 && metres < kNothing ? "below 0.001 um" : format("%.3g um", metres / kMicrometre);
}

std::string expectedWords(const Representability& judged) {
  if (!std::isfinite(judged.heldOut))
    return "The part of the session that the model does not explain is unknown: it has no lengths.\n";
  return "Expected: together with the " + um(judged.unexplained()) +
         " that the model does not explain of its session, the root of the difference of squares of\n"
         "what was left there (" +
         um(judged.heldOut) + ") and the repeatability of a contact (" + um(judged.repeatability) + ").\n";
}

}  // namespace

ordered_json representabilityJson(const Representability& judged) {
  const ExportFigures& f = judged.figures;
  ordered_json json{
      {"target", judged.target},
      {"touched", judged.touched},
      {"compensation", {{"active", judged.compensation.inWords()}, {"in_words", judged.activeWords}}},
      {"rms_um",
       {{"uncorrected", micrometres(f.uncorrected)}, {"exported", micrometres(f.exported)}, {"full", 0.0}}},
      {"expected_rms_um",
       {{"uncorrected", micrometres(judged.expected(f.uncorrected))},
        {"exported", micrometres(judged.expected(f.exported))},
        {"full", micrometres(judged.unexplained())}}},
      {"unexplained_um", micrometres(judged.unexplained())},
      {"held_out_rms_um", micrometres(judged.heldOut)},
      {"repeatability_um", micrometres(judged.repeatability)},
      {"rms_not_aligned_um",
       {{"uncorrected", micrometres(f.unalignedUncorrected)},
        {"exported", micrometres(f.unalignedExported)}}},
      {"carries_nothing", judged.carriesNothing()}};
  if (std::isfinite(f.withOffsets)) {
    json["rms_with_offsets_um"] = micrometres(f.withOffsets);
    json["expected_rms_um"]["with_offsets"] = micrometres(judged.expected(f.withOffsets));
  }
  json["not_followed"] = judged.notFollowed;
  json["effects"] = ordered_json::array();
  for (const CarriedEffect& e : judged.effects) {
    json["effects"].push_back({{"effect", effectJson(e.effect)},
                               {"carried", e.carried},
                               {"why", e.why},
                               {"rms_um",
                                {{"uncorrected", micrometres(e.figures.uncorrected)},
                                 {"exported", micrometres(e.figures.exported)}}}});
    if (!e.iso230.empty()) json["effects"].back()["iso230"] = e.iso230;
  }
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
      "RMS of a coordinate over the calibrated volume, temperatures and directions of travel:\n"
      "                       left of the model   expected at the probe\n";
  const auto line = [&](const char* what, double left) {
    text += format("  %-20s %-19s ", what, um(left).c_str()) + um(judged.expected(left)) + "\n";
  };
  line("uncorrected", f.uncorrected);
  line("with this export", f.exported);
  if (std::isfinite(f.withOffsets)) line("and external offsets", f.withOffsets);
  line("with the full model", 0.0);
  text += expectedWords(judged);
  text += "An alignment of the workpiece is taken out of what is left of the model; without that " +
          um(f.unalignedUncorrected) + " and " + um(f.unalignedExported) + ".\n";
  for (const std::string& told : judged.notFollowed) text += "Not followed: " + told + ".\n";
  text += "\n";
  for (const CarriedEffect& e : judged.effects)
    text += format("%-12s ", e.carried.c_str()) + e.effect.yaml() +
            (e.iso230.empty() ? "" : " (" + e.iso230 + ")") + "\n             " + e.why + "\n";
  if (judged.effects.empty()) text += "The calibration has no effects, so there is nothing to export.\n";
  return text;
}

}  // namespace mm
