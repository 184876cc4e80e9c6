#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "calibration_file/calibration.h"
#include "export/export_target.h"
#include "session/motion.h"
#include "session/progress.h"
#include "session/session.h"
#include "tools/file_kind.h"

namespace CLI {
class App;
}

namespace mm {

/// The files of one command: what it reads and what it will write. Nothing of value is overwritten: an output
/// that is an input of the same command, a file of another kind, the calibration of another session, a bag of
/// another origin or a file that a folder of calibrations keeps is refused before the work. A file is known
/// by what it is on the disk, whatever path or link names it. Every output of `mm` is written through this
/// class and nowhere else.
///
///     files.input(c.bag);
///     files.output("-o", c.output, FileKind::kCalibration);
///     files.check();
class OutputFiles {
 public:
  /// The option --force.
  void declare(CLI::App& command);

  /// Measurements, and what people write (model, artifact, plan, machine): never replaced, also not by force.
  void input(const std::string& file) { inputs_.push_back({file, false}); }
  void input(const std::vector<std::string>& files) {
    for (const std::string& file : files) input(file);
  }
  /// A calibration that is read: force may replace it.
  void calibration(const std::string& file) { inputs_.push_back({file, true}); }
  /// @param option as it is typed, for messages. @param file empty: not asked for.
  void output(const std::string& option, const std::string& file, FileKind kind);
  /// A bag written by `mm import` may replace one that was imported from the same file.
  /// @param origin as of `bagOrigin`.
  void bag(const std::string& option, const std::string& file, const std::string& origin);

  /// A folder of an export (checkExportFolder). @param target for which it is.
  void folder(const std::string& option, const std::string& folder, const std::string& target);

  /// @throw InputError: one line that names the option, the file, why it is refused, and the remedy.
  void check() const;
  /// Calibrations are of this session: checked when it was read, and before the work.
  /// One that is there is not replaced by one with fewer steps in its ledger.
  /// @param hashes of the session; more where it is used in two forms. @param steps of the ledger that is
  /// written. @throw InputError.
  void checkSession(const std::vector<std::string>& hashes, std::size_t steps) const;

  /// @throw InputError: full disk, no permission. As the functions of the folders that they call.
  void write(const std::string& file, const std::string& text) const;
  void write(const std::string& file, Calibration& calibration) const;
  void write(const std::string& file, const Session& session, const ProgressCallback& progress,
             const std::vector<MotionSample>& motion = {}) const;
  void write(const std::string& folder, const std::vector<ExportedFile>& files) const;
  /// What this run of `mm` has written so far, as it was named.
  static const std::vector<std::string>& written();

 private:
  struct Input {
    std::string file;
    bool replaceable;
  };
  struct Output {
    std::string option, file;
    FileKind kind;
    std::string origin;  // of a bag
  };
  void checkPlace(const Output& out) const;
  void checkInputs(const Output& out) const;
  void checkThatInputsAreThere() const;
  void checkName(const Output& out) const;
  void checkContent(const Output& out) const;
  void refuseUnlessForced(const Output& out, const std::string& why) const;
  void declared(const std::string& file) const;

  bool force_ = false;
  std::vector<Input> inputs_;
  std::vector<Output> outputs_;
  struct Folder {
    std::string option, folder, target;
  };
  std::vector<Folder> folders_;
};

}  // namespace mm
