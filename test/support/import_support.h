#pragma once
#include <string>

#include "base/error.h"
#include "import/import_file.h"
#include "session/artifact_file.h"
#include "session_files.h"

namespace mm::test {

/// Two balls of 3.9685 mm, touched with a tip of 1 mm.
inline Artifact twoBalls() {
  return parseArtifact(
      "name: two\npose: free\nprobe: {tip_radius_mm: 1.0}\nballs:\n"
      "  - {name: b1, centre_mm: [0, 0, 0], radius_mm: 3.9685}\n"
      "  - {name: b2, centre_mm: [12, 3, -1], radius_mm: 3.9685}\n",
      "two.yaml");
}

/// Imports files, or texts as files, with or without a mapping.
class Importer {
 public:
  explicit Importer(const std::string& machine = "three_axis") : machine_(Machine::load(machine)) {}
  explicit Importer(Machine machine) : machine_(std::move(machine)) {}

  Imported file(const std::filesystem::path& file, const std::string& mapping = "",
                const Artifact* artifact = nullptr, const std::string& format = "") const {
    ImportRequest request;
    request.file = file;
    request.format = format;
    if (!mapping.empty()) request.mapping = folder_.write("mapping.yaml", mapping);
    Imported imported;
    importFile(request, machine_, artifact, imported);
    return imported;
  }
  Imported text(const std::string& text, const std::string& mapping = "", const Artifact* artifact = nullptr,
                const std::string& format = "") const {
    return file(folder_.write("f.txt", text), mapping, artifact, format);
  }
  /// Why a text is refused; empty: it is not.
  std::string refusal(const std::string& text, const std::string& mapping = "",
                      const Artifact* artifact = nullptr) const {
    return messageOf<InputError>([&] { this->text(text, mapping, artifact); });
  }
  const Machine& machine() const { return machine_; }

 private:
  Machine machine_;
  Folder folder_;
};

inline const UnderstoodColumn* columnNamed(const Imported& imported, const std::string& name) {
  for (const UnderstoodColumn& c : imported.columns)
    if (c.name == name) return &c;
  return nullptr;
}

}  // namespace mm::test
