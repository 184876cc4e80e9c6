#pragma once
#include <string>
#include <vector>

#include "base/json_text.h"
#include "import/import_file.h"
#include "import/import_questions.h"
#include "session/sense_checks.h"

namespace mm {

/// What a file would become: all that `mm import` and the page say of it before it is written.
struct ImportPreview {
  Imported imported;                  // as far as it was understood
  std::vector<std::string> faults;    // why it is refused, one line each; empty: it is not
  std::vector<ImportQuestion> asked;  // what would mend them in the mapping
  std::vector<Doubt> doubts;          // questions about the session that it became
};

/// Reads a file as importFile(); what that throws of the file becomes `faults`. Texts of the file are
/// shownText(). @param compensation that was
/// active while it was measured. @throw Cancelled.
ImportPreview previewImport(const ImportRequest& request, const Machine& machine, const Artifact* artifact,
                            const ControllerCompensation& compensation = {},
                            const ProgressCallback& progress = {});

/// For people: what was understood, what the session holds, and the questions about it.
std::string previewText(const ImportPreview& preview);
/// The same as an object, which `mm import --json` prints. @param written path of the bag; empty: none.
Json previewJson(const ImportRequest& request, const ImportPreview& preview, const std::string& written);

}  // namespace mm
