#pragma once
#include "session/contacts_csv.h"

namespace mm {

/// The rows of a CSV in the package's own columns.
inline Session readContactsCsv(const std::filesystem::path& file, const Machine& machine,
                               const Artifact* artifact, const ProgressCallback& progress = {}) {
  const TextFile text(file);
  return readTable(text, ownForm(text, machine), machine, artifact, progress).session;
}

}  // namespace mm
