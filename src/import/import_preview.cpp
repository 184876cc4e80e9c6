#include "import/import_preview.h"

#include <cmath>

#include "base/error.h"
#include "base/text.h"
#include "session/input_faults.h"
#include "session/session_summary.h"

namespace mm {
namespace {

Json told(const std::string& text) { return orNull(!text.empty(), text); }

Json columnJson(const UnderstoodColumn& c) {
  return {{"name", c.name},
          {"meaning", told(c.meaning)},
          {"unit", told(c.unit)},
          {"unit_from", told(c.unit.empty() ? "" : c.from)},
          {"range", orNull(!std::isnan(c.lower), std::vector<double>{c.lower, c.upper})},
          {"first", told(c.first)}};
}

Json doubtJson(const Doubt& d) {
  return {{"question", d.question}, {"before_um", d.before * 1e6}, {"after_um", d.after * 1e6}};
}

Json askedJson(const ImportQuestion& q) {
  return {{"key", q.key}, {"column", told(q.column)}, {"suggested", q.suggested}, {"choices", q.choices}};
}

Json sessionJson(const Session& session) {
  const auto setAside = [&](const SetAside& a) { return setAsideText(session, a); };
  return {{"observations", session.observations.size()},
          {"assumed", told(assumedText(session))},
          {"set_aside", jsonList(session.setAside, setAside)},
          {"compensation", session.compensation.inWords()}};
}

/// Cells and names of the file as people see them.
void makeShown(Imported& imported) {
  const auto each = [](std::vector<std::string>& texts) {
    for (std::string& text : texts) text = shownText(text);
  };
  for (UnderstoodColumn& c : imported.columns)
    for (std::string* text : {&c.name, &c.meaning, &c.unit, &c.first}) *text = shownText(*text);
  for (std::vector<std::string>& row : imported.rows) each(row);
  each(imported.head);
  for (std::string& note : imported.notes) note = printableText(note);
}

void read(const ImportRequest& request, const Machine& machine, const Artifact* artifact,
          const ProgressCallback& progress, ImportPreview& preview) {
  try {
    importFile(request, machine, artifact, preview.imported, progress);
  } catch (const InputFaults& e) {
    preview.faults = e.faults();
  } catch (const InputError& e) {
    preview.faults = {e.what()};
  }
}

}  // namespace

ImportPreview previewImport(const ImportRequest& request, const Machine& machine, const Artifact* artifact,
                            const ControllerCompensation& compensation, const ProgressCallback& progress) {
  ImportPreview preview;
  read(request, machine, artifact, progress, preview);
  makeShown(preview.imported);
  for (std::string& fault : preview.faults) fault = printableText(fault);
  if (!preview.faults.empty()) {
    preview.imported.session.reset();
    preview.asked = questionsOf(preview.imported.lacks, machine);
    return preview;
  }
  preview.imported.session->compensation = compensation;
  preview.doubts = sensibleDoubts(*preview.imported.session);
  for (Doubt& d : preview.doubts) d.question = printableText(d.question);
  return preview;
}

std::string previewText(const ImportPreview& preview) {
  const Imported& imported = preview.imported;
  std::string text = imported.columns.empty() && !imported.session ? "" : understoodText(imported);
  if (imported.session) text += summarize(*imported.session);
  for (const Doubt& d : preview.doubts) text += "question: " + d.question + "\n";
  return printableText(text, true);
}

Json previewJson(const ImportRequest& request, const ImportPreview& preview, const std::string& written) {
  const Imported& imported = preview.imported;
  const Json noSession{{"observations", nullptr},
                       {"assumed", nullptr},
                       {"set_aside", Json::array()},
                       {"compensation", nullptr}};
  return jsonObject({{{"file", request.file.string()},
                      {"format", told(imported.format)},
                      {"how", imported.how},
                      {"columns", jsonList(imported.columns, columnJson)},
                      {"rows", imported.rows},
                      {"head", imported.head},
                      {"remarks", imported.notes},
                      {"faults", preview.faults},
                      {"asked", jsonList(preview.asked, askedJson)},
                      {"questions", jsonList(preview.doubts, doubtJson)}},
                     imported.session ? sessionJson(*imported.session) : noSession,
                     {{"written", told(written)}}});
}

}  // namespace mm
