#include "export/export_page.h"

#include <cmath>

#include "base/format.h"
#include "base/units.h"
#include "export/compensation_statement.h"
#include "export/export_folder.h"
#include "machine/joint_units.h"

namespace mm {
namespace {

/// The place where the tables add most to one axis.
struct SignCheck {
  const ExportAxis* axis = nullptr;
  State state;
  double added = 0.0;  // m
};

SignCheck signCheck(const NeededCorrection& needed, const ExportTarget& target, const Exported& exported) {
  const std::unique_ptr<const LoadedCompensation> tried = triedExport(target.name, exported);
  SignCheck best;
  for (const State& state : needed.states(128, 51)) {
    const std::map<std::string, double> adds = tried->tablesAdd(needed.commandOf(state));
    for (const int joint : needed.linear()) {
      const ExportAxis& axis = needed.axis(joint);
      const double added = adds.at(axis.letter);
      if (std::abs(added) > std::abs(best.added)) best = {&axis, state, added};
    }
  }
  return best;
}

std::string signText(const NeededCorrection& needed, const ExportTarget& target, const Exported& exported) {
  const SignCheck check = signCheck(needed, target, exported);
  if (check.axis == nullptr) return "The tables are zero everywhere, so there is no sign to check.\n";
  std::string text =
      "With the tables in effect, command this position, arriving in the stated directions:\n\n";
  for (const ExportAxis& axis : needed.axes()) {
    const int j = axis.joint;
    const JointUnit unit = readingUnit(needed.model().machine().joints()[j]);
    text +=
        format("    %s %.3f %s, %s\n", capital(axis.letter).c_str(), check.state.position[j] / unit.factor,
               unit.symbol, check.state.travel[j] > 0 ? "upwards" : "downwards");
  }
  const Domain& d = needed.model().domain();
  for (std::size_t k = 0; k < d.sensors.size(); ++k)
    if (std::isfinite(check.state.temperature[k]))
      text += format("    %s at %.2f degC\n", d.sensors[k].c_str(), check.state.temperature[k]);
  return text +
         format(
             "\n"
             "The motor of %s (or a dial gauge against the same move without the tables) must then stand "
             "%.2f um %s of where it stands without them. If it stands on the other side, all signs are "
             "reversed: do not use the tables as they are.\n",
             capital(check.axis->letter).c_str(), std::abs(check.added) / kMicrometre,
             check.added > 0.0 ? "on the positive side" : "on the negative side");
}

std::string numbered(const std::vector<std::string>& steps) {
  std::string text;
  for (std::size_t i = 0; i < steps.size(); ++i) text += format("%zu. ", i + 1) + steps[i] + "\n";
  return text;
}

std::string bulleted(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += "- " + line + "\n";
  return text;
}

std::string range(const NeededCorrection& needed) {
  std::string text;
  for (const ExportAxis& axis : needed.axes()) {
    const JointUnit unit = readingUnit(needed.model().machine().joints()[axis.joint]);
    text +=
        format("- joint %s is axis %s, %.4g to %.4g %s\n", axis.name.c_str(), capital(axis.letter).c_str(),
               axis.lower / unit.factor, axis.upper / unit.factor, unit.symbol);
  }
  const Domain& d = needed.model().domain();
  for (std::size_t k = 0; k < d.sensors.size(); ++k)
    if (std::isfinite(d.sensorLower[k]))
      text += format("- temperature %s, %.4g to %.4g degC\n", d.sensors[k].c_str(), d.sensorLower[k],
                     d.sensorUpper[k]);
  return text;
}

/// How large the errors are with and without the tables: what the model predicts, to be validated by
/// measuring.
std::string beforeAndAfterText(const Representability& judged) {
  if (!std::isfinite(judged.heldOut)) return "not known: the session has no lengths";
  const auto um = [&](const LeftOfModel& left) { return judged.measured(left).inWords(); };
  std::string text;
  for (const LeftAlong& along : judged.along) {
    if (along.direction.empty()) continue;
    text +=
        (text.empty() ? "" : "; ") + along.direction + " " + um(along.uncorrected) + " before, " +
        um(along.exported) + " after" +
        (std::isfinite(along.withOffsets.rms) ? ", " + um(along.withOffsets) + " with the external offsets"
                                              : "");
  }
  return "RMS that a measurement along each axis of the workpiece is predicted to show (k = 2): " + text +
         ". Validate it with the tables in effect: measure fresh points, then `mm verify`";
}

/// What ISO/TR 16907 asks to be told.
std::string compensationText(const Calibration& calibration, const ExportTarget& target,
                             const Exported& exported, const Representability& judged) {
  std::vector<EffectSpec> carried;
  for (const CarriedEffect& e : judged.effects)
    if (e.carried != "none") carried.push_back(e.effect);
  std::vector<std::string> lines = {"Compensation: tables of " + target.title + ", " + exported.holds};
  if (exported.offsets)
    lines.front() +=
        "; external offsets add what the tables leave of the model; the next lines are of the tables";
  for (const CompensationFact& fact : compensationFacts(calibration, carried))
    lines.push_back(fact.name + ": " + fact.text);
  lines.push_back("Before and after: " + beforeAndAfterText(judged));
  return bulleted(lines);
}

/// What the files were held against, and what is left to the machine.
std::vector<std::string> checkedText(const ExportTarget& target, const Representability& judged) {
  std::vector<std::string> lines;
  if (!judged.carriesNothing())
    lines.push_back("By calculation: the files were read back by an interpreter of the rules of " +
                    target.title +
                    " (documentation, interpreters) that shares no code with the export; the figures above "
                    "are of what it then adds at fresh positions.");
  lines.push_back("Not on this machine: do the check with one move, then `mm verify` on fresh points.");
  return lines;
}

/// README.md of an export: what to install where and in which order, from where positions count, how one move
/// shows that the sign is right, what is carried, what was checked, and what is open.
std::string exportPage(const Calibration& calibration, const ExportTarget& target,
                       const NeededCorrection& needed, const Exported& exported,
                       const Representability& judged) {
  std::string text = "# Calibration of " + calibration.machineName + " for " + target.title +
                     "\n\nFrom calibration `" + calibration.id + "` (" + calibration.created + ").\n\n";
  if (judged.carriesNothing())
    text += "**" + target.title + " can carry nothing of this calibration**: it holds " + exported.holds +
            ". Correct readings with `mm apply` instead.\n\n";
  text += "## Compensation that was active\n\n" + activeWords(target, needed, exported) + "\n\n";
  text += "## Files\n\n| file | what |\n|---|---|\n";
  for (const ExportedFile& file : exported.files) text += "| `" + file.path + "` | " + file.what + " |\n";
  text += "\n## Install\n\n" + numbered(exported.load) + "\n## Reference point\n\n" + exported.reference +
          "\n"
          "\n"
          "It is valid over the range that the session covered; beyond it the tables are not based on "
          "measurements.\n"
          "\n" +
          range(needed) + "\n## Check the sign with one move\n\n" + signText(needed, target, exported);
  text += "\n## What is carried\n\n" + target.title + " holds " + exported.holds + ".\n\n```\n" +
          representabilityText(judged) + "```\n";
  text += "\n## Numerical compensation, by ISO/TR 16907\n\n" +
          compensationText(calibration, target, exported, judged);
  if (!exported.notes.empty()) text += "\n## Notes\n\n" + bulleted(exported.notes);
  text += "\n## What was checked\n\n" + bulleted(checkedText(target, judged));
  if (!exported.unverified.empty())
    text += "\n## Open: what the documents do not say, or the figures leave out\n\n" +
            bulleted(exported.unverified);
  return text;
}

}  // namespace

std::vector<ExportedFile> exportFolderOf(const Calibration& calibration, const ExportTarget& target,
                                         const NeededCorrection& needed, const Exported& exported,
                                         Representability& judged) {
  judged.touched = exported.axes;
  judged.compensation = needed.compensation();
  judged.activeWords = activeWords(target, needed, exported);
  std::vector<ExportedFile> files = exported.files;
  files.push_back({"README.md", "what to install where, and how to check it",
                   exportPage(calibration, target, needed, exported, judged)});
  files.push_back(
      {"representability.txt", "effect by effect, what is carried", representabilityText(judged)});
  files.push_back({"representability.json", "the same for programs", ""});
  judged.files = files;
  files.back().text = representabilityJson(judged).dump(2) + "\n";
  return files;
}

}  // namespace mm
