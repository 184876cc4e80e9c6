#include <cmath>

#include "base/format.h"
#include "base/json_text.h"
#include "base/nearest_name.h"
#include "base/quantity_words.h"
#include "base/units.h"
#include "export/representability.h"

namespace mm {
namespace {

Json micrometres(double metres) { return orNull(std::isfinite(metres), metres / kMicrometre); }

Json effectJson(const EffectSpec& spec) {
  Json json{{"type", spec.type}};
  for (const auto& [key, value] : spec.keys)
    json[key] = value.list ? Json(value.items) : value.items.empty() ? Json("") : Json(value.items[0]);
  return json;
}

std::string um(double metres) { return std::isfinite(metres) ? errorInWords(metres, false) : "not known"; }

/// "uncorrected", "exported" … of a figure in m.
template <typename Figure>
Json eachJson(const LeftAlong& along, const Figure& figure) {
  return jsonObject({{{"uncorrected", micrometres(figure(along.uncorrected))},
                      {"exported", micrometres(figure(along.exported))},
                      {"full", micrometres(figure(along.full))}},
                     entryIf(std::isfinite(along.withOffsets.rms), "with_offsets",
                             micrometres(figure(along.withOffsets)))});
}

Json alongJson(const Representability& judged, const LeftAlong& along) {
  using Left = const LeftOfModel&;
  return {{"rms_um", eachJson(along, [](Left l) { return l.rms; })},
          {"expected_rms_um", eachJson(along, [&](Left l) { return judged.expected(l).rms; })},
          {"expected_rms_std_um", eachJson(along, [&](Left l) { return judged.expected(l).std; })},
          {"measured_rms_um", eachJson(along, [&](Left l) { return judged.measured(l).rms; })},
          {"measured_rms_std_um", eachJson(along, [&](Left l) { return judged.measured(l).std; })},
          {"by_parameters_um", micrometres(along.full.byParameters)}};
}

std::string alongText(const Representability& judged, const LeftAlong& along) {
  std::string text = along.direction.empty() ? "a coordinate\n" : "along " + along.direction + "\n";
  const auto line = [&](const char* what, const LeftOfModel& left) {
    if (std::isfinite(left.rms))
      text += format("  %-20s %-19s %-20s ", what, um(left.rms).c_str(),
                     judged.expected(left).inWords().c_str()) +
              judged.measured(left).inWords() + "\n";
  };
  line("uncorrected", along.uncorrected);
  line("with this export", along.exported);
  line("and external offsets", along.withOffsets);
  line("with the full model", along.full);
  return text;
}

std::string expectedWords(const Representability& judged) {
  std::string text =
      "At the probe: what is left of the model, and the larger of the standard uncertainty that its "
      "parameters\nleave (" +
      um(judged.along.front().full.byParameters) + ") and what the model does not explain of its session (";
  text += std::isfinite(judged.heldOut)
              ? um(judged.unexplained()) + ", the root of the difference of\nsquares of " +
                    um(judged.heldOut) + " left there and a repeatability of " + um(judged.repeatability) +
                    ")"
              : "unknown: the session has no lengths)";
  return text + ". Measured: with the repeatability of one measurement.\n± is k = 2.\n";
}

}  // namespace

std::string ExpectedError::inWords() const {
  if (!std::isfinite(rms)) return "not known";
  return expanded(rms / kMicrometre, std / kMicrometre, nameOfUnit(false));
}

Json representabilityJson(const Representability& judged) {
  const ExportFigures& f = judged.figures;
  const auto effect = [](const CarriedEffect& e) {
    return jsonObject({{{"effect", effectJson(e.effect)},
                        {"carried", e.carried},
                        {"why", e.why},
                        {"rms_um",
                         {{"uncorrected", micrometres(e.figures.uncorrected)},
                          {"exported", micrometres(e.figures.exported)}}}},
                       entryIf(!e.iso230.empty(), "iso230", e.iso230)});
  };
  Json along = Json::array();
  for (const LeftAlong& a : judged.along)
    if (!a.direction.empty())
      along.push_back(jsonObject({alongJson(judged, a), {{"direction", a.direction}}}));
  return jsonObject(
      {{{"target", judged.target},
        {"touched", judged.touched},
        {"compensation", {{"active", judged.compensation.inWords()}, {"in_words", judged.activeWords}}},
        {"unexplained_um", micrometres(judged.unexplained())},
        {"held_out_rms_um", micrometres(judged.heldOut)},
        {"repeatability_um", micrometres(judged.repeatability)},
        {"rms_not_aligned_um",
         {{"uncorrected", micrometres(f.unalignedUncorrected)},
          {"exported", micrometres(f.unalignedExported)}}},
        {"carries_nothing", judged.carriesNothing()}},
       entryIf(std::isfinite(f.withOffsets), "rms_with_offsets_um", micrometres(f.withOffsets)),
       judged.along.empty() ? Json() : alongJson(judged, judged.along.front()),
       {{"along", along},
        {"not_moved", judged.notMoved},
        {"not_followed", judged.notFollowed},
        {"effects", jsonList(judged.effects, effect)},
        {"calibration", judged.calibration},
        {"axes", judged.letters},
        {"sensors", judged.sensors},
        {"files", jsonList(judged.files, [](const ExportedFile& file) {
           return Json{{"path", file.path}, {"what", file.what}};
         })}}});
}

std::string representabilityText(const Representability& judged) {
  const ExportFigures& f = judged.figures;
  std::string text =
      "RMS over the calibrated volume, temperatures and directions of travel:\n"
      "                       left of the model   at the probe         measured\n";
  for (const LeftAlong& along : judged.along) text += alongText(judged, along);
  if (!judged.notMoved.empty())
    text += "Not told along " + listOf(judged.notMoved) + ": no axis moved there in the session.\n";
  if (!judged.along.empty()) text += expectedWords(judged);
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
