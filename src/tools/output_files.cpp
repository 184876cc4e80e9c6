#include "tools/output_files.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <map>
#include <stdexcept>

#include "base/error.h"
#include "base/read_file.h"
#include "calibration_file/atomic_file.h"
#include "calibration_file/calibration_yaml.h"
#include "export/export_folder.h"
#include "ros_bridge/bag_session.h"

namespace mm {
namespace {

namespace fs = std::filesystem;

/// The same file on the disk, by whatever path or link; for files that do not exist yet, the same path.
bool sameFile(const fs::path& a, const fs::path& b) {
  std::error_code error;
  if (fs::exists(a, error) && fs::exists(b, error)) return fs::equivalent(a, b, error) && !error;
  return fs::weakly_canonical(fs::absolute(a), error) == fs::weakly_canonical(fs::absolute(b), error);
}

/// A folder of calibrations is known by its links and its list.
bool keptByStore(const fs::path& file) {
  std::error_code error;
  const fs::path folder = fs::weakly_canonical(fs::absolute(file), error).parent_path();
  return fs::is_symlink(folder / "active", error) || fs::is_symlink(folder / "candidate", error);
}

/// A link keeps its place: what it points to is written.
fs::path throughLinks(const fs::path& file) {
  std::error_code error;
  return fs::exists(file, error) ? fs::canonical(file) : file;
}

std::vector<std::string>& filesWritten() {
  static std::vector<std::string> files;
  return files;
}

}  // namespace

void OutputFiles::declare(CLI::App& command) {
  command.add_flag("--force", force_, "overwrite an existing output; inputs are never overwritten");
}

void OutputFiles::output(const std::string& option, const std::string& file, FileKind kind) {
  if (!file.empty()) outputs_.push_back({option, file, kind, {}});
}

void OutputFiles::bag(const std::string& option, const std::string& file, const std::string& origin) {
  if (!file.empty()) outputs_.push_back({option, file, FileKind::kBag, origin});
}

void OutputFiles::folder(const std::string& option, const std::string& folder, const std::string& target) {
  folders_.push_back({option, folder, target});
}

void OutputFiles::check() const {
  for (const Folder& f : folders_) {
    if (keptByStore(fs::path(f.folder) / "file") || keptByStore(f.folder))
      throw InputError(f.option + " " + f.folder +
                       ": is or lies in a folder of calibrations, which mm promote keeps; name "
                       "another folder");
    checkExportFolder(f.folder, f.target, force_);
  }
  for (std::size_t i = 0; i < outputs_.size(); ++i) {
    const Output& out = outputs_[i];
    checkPlace(out);
    for (std::size_t j = 0; j < i; ++j)
      if (kindOf(out.file) != FileKind::kStream && sameFile(out.file, outputs_[j].file))
        throw InputError(outputs_[j].option + " and " + out.option + " name the same file, " + out.file +
                         "; name another for one of them");
    checkInputs(out);
    try {
      checkContent(out);
    } catch (const InputError&) {
      checkThatInputsAreThere();  // what is mistyped first
      throw;
    }
    checkName(out);
  }
}

void OutputFiles::checkPlace(const Output& out) const {
  const fs::path file(out.file), folder = file.parent_path();
  if (!folder.empty() && !fs::is_directory(folder))
    throw InputError(out.file + ": the folder '" + folder.string() +
                     "' does not exist; make it, or name another");
  if (fs::is_directory(file)) throw InputError(out.file + ": is a folder; name a file");
  if (out.kind == FileKind::kBag && kindOf(file) == FileKind::kStream)
    throw InputError(out.option + " " + out.file +
                     ": is not a regular file, as a bag must be; name another file");
  if (keptByStore(file))
    throw InputError(out.option + " " + out.file +
                     ": lies in a folder of calibrations, which mm promote keeps; name a file elsewhere");
}

void OutputFiles::checkInputs(const Output& out) const {
  if (kindOf(out.file) == FileKind::kStream) return;
  for (const Input& in : inputs_) {
    std::error_code error;
    if (in.file.empty() || !fs::exists(in.file, error) || !sameFile(out.file, in.file)) continue;
    const std::string why = in.file == out.file
                                ? "is read by this command"
                                : "is the same file as " + in.file + ", which this command reads";
    if (in.replaceable) {
      refuseUnlessForced(out, why);
      continue;
    }
    throw InputError(out.option + " " + out.file + ": " + why +
                     "; inputs are never overwritten: name another file");
  }
}

void OutputFiles::checkThatInputsAreThere() const {
  for (const Input& in : inputs_) {
    std::error_code error;
    const bool path = fs::path(in.file).has_extension() || fs::path(in.file).has_parent_path();
    if (!in.file.empty() && path && !fs::exists(in.file, error))
      throw InputError(fs::path(in.file).string() + ": no such file; check the path");
  }
}

/// A name that promises another kind of file leads somebody to read it as that.
void OutputFiles::checkName(const Output& out) const {
  static const std::map<std::string, std::vector<FileKind>> kNames = {
      {".csv", {FileKind::kTable, FileKind::kStates, FileKind::kCurve}},
      {".bag", {FileKind::kBag}},
      {".html", {FileKind::kPage, FileKind::kCertificate}},
      {".pdf", {FileKind::kCertificate, FileKind::kPage}},
      {".xml", {FileKind::kCertificate}},
      {".urdf", {FileKind::kMachine}}};
  const auto promised = kNames.find(fs::path(out.file).extension().string());
  if (promised == kNames.end() || kindOf(out.file) == FileKind::kStream) return;
  const std::vector<FileKind>& kinds = promised->second;
  if (std::find(kinds.begin(), kinds.end(), out.kind) == kinds.end())
    refuseUnlessForced(
        out, "is written as " + nameOf(out.kind) + ", which a name in " + promised->first + " does not say");
}

void OutputFiles::checkContent(const Output& out) const {
  const FileKind there = kindOf(out.file);
  if (there == FileKind::kNothing || there == FileKind::kStream) return;
  if (there != out.kind)
    return refuseUnlessForced(out, "holds " + nameOf(there) + ", not " + nameOf(out.kind));
  if (there == FileKind::kTable)
    return refuseUnlessForced(out, "holds a table that may contain measurements");
  if (there == FileKind::kKey)
    return refuseUnlessForced(out, "holds " + nameOf(there) + " that may have been measured");
  for (const FileKind kind : {FileKind::kMachine, FileKind::kModel, FileKind::kPlan})
    if (there == kind)
      return refuseUnlessForced(out, "holds " + nameOf(kind) + " that may have been edited by hand");
  if (there != FileKind::kBag) return;
  const std::string origin = bagOrigin(out.file);
  if (origin != out.origin)
    refuseUnlessForced(out, "holds a session that was " + origin + ", not " + out.origin);
}

void OutputFiles::checkSession(const std::vector<std::string>& hashes, std::size_t steps) const {
  for (const Output& out : outputs_) {
    if (out.kind != FileKind::kCalibration || kindOf(out.file) != FileKind::kCalibration) continue;
    Calibration there;
    try {
      there = loadCalibration(out.file);
    } catch (const UnreadableFile&) {
      throw;
    } catch (const InputError&) {
      refuseUnlessForced(out, "holds a calibration that is damaged or of a newer version");
      continue;
    }
    if (std::find(hashes.begin(), hashes.end(), there.sessionHash) != hashes.end()) {
      if (there.ledger.size() > steps)
        refuseUnlessForced(out, "holds a calibration with " + std::to_string(there.ledger.size()) +
                                    " steps in its ledger, of which " + std::to_string(steps) +
                                    " would be left");
      continue;
    }
    refuseUnlessForced(out, "holds the calibration of another session (machine " + there.machineName +
                                ", from " + there.sessionSource + ", " + std::to_string(there.observations) +
                                " observations, made " + there.created + ")");
  }
}

void OutputFiles::refuseUnlessForced(const Output& out, const std::string& why) const {
  if (!force_)
    throw InputError(out.option + " " + out.file + ": " + why +
                     "; name another file, or replace it with --force");
}

void OutputFiles::declared(const std::string& file) const {
  if (std::none_of(outputs_.begin(), outputs_.end(), [&](const Output& o) { return o.file == file; }))
    throw std::logic_error(file + " is written without a check");
}

const std::vector<std::string>& OutputFiles::written() { return filesWritten(); }

void OutputFiles::write(const std::string& file, const std::string& text) const {
  declared(file);
  writeFileAtomically(file, text);
  filesWritten().push_back(file);
}

void OutputFiles::write(const std::string& file, Calibration& calibration) const {
  declared(file);
  saveCalibration(calibration, file);
  filesWritten().push_back(file);
}

void OutputFiles::write(const std::string& folder, const std::vector<ExportedFile>& files) const {
  writeExportFolder(folder, files);
  filesWritten().push_back(folder);
}

void OutputFiles::write(const std::string& file, const Session& session, const ProgressCallback& progress,
                        const std::vector<MotionSample>& motion) const {
  declared(file);
  writeSessionBag(session, throughLinks(file), progress, motion);
  filesWritten().push_back(file);
}

}  // namespace mm
