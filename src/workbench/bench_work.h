#pragma once
#include <chrono>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "calibration_file/calibration_store.h"
#include "diagnosis/diagnose.h"
#include "estimation/calibrate.h"
#include "import/import_preview.h"
#include "session/progress.h"
#include "workbench/documents.h"
#include "workbench/live_machine.h"
#include "workbench/machine_meshes.h"
#include "workbench/session_documents.h"
#include "workflow/job.h"
#include "workflow/learning.h"

namespace mm {

/// How the workbench reads what other folders know to read.
struct BenchSources {
  /// A session's bag. @param fallback machine of a bag that has none; may be null.
  std::function<Session(const std::filesystem::path&, const ProgressCallback&, const Machine* fallback)>
      readBag;
  /// Writes a session that was imported. @param file that does not exist yet.
  std::function<void(const Session&, const std::filesystem::path& file, const std::vector<MotionSample>&,
                     const ProgressCallback&)>
      writeBag;
  /// Namespace of the nodes that measured a bag; empty: none.
  std::function<std::string(const std::filesystem::path&)> spaceOf;
  /// Where the meshes are that a machine's URDF names by a package; empty: no package is known.
  PackageFolder packageFolder;
};

/// What `mm workbench` is started with.
struct BenchOptions {
  std::filesystem::path bag, calibration;  // empty: none
  std::filesystem::path store;             // empty: the machine's own folder of calibrations
  std::filesystem::path folder;            // of imported bags; empty: that of the bag, else the current one
  unsigned threads = 0;                    // 0: all cores
  std::chrono::milliseconds heartbeat{1000};  // without one for so long, the machine is stopped
};

/// How a page wants the file read that it sent. Texts of files, never their paths.
struct ImportWish {
  std::uint64_t file = 0, asked = 0;  // number of the file; number that the page gives the preview
  std::uint64_t session = 0;          // number of the document of the session in hand; 0: none
  std::string machine, urdf;          // a name; empty: as in hand. urdf not empty: that machine
  std::string artifact;               // YAML; empty: none, or
  bool artifactOfSession = false;     // that of the session in hand
  std::string mapping, format;        // as `mm import` takes them; empty: none
  std::string compensation;           // "none", or empty: not stated
  std::string output;                 // name of the bag
};

/// The loop on one session: what `mm` does from one command to the next, with what it needs kept. Every task
/// publishes what the page shows of it. All but the functions that say otherwise belong to the thread that
/// works. Each task @throw InputError, NumericalError, Cancelled as the functions of
/// workflow/recalibration.h, and @return a sentence that says what was done.
class BenchWork {
 public:
  /// @param live null: a recorded session alone. All must outlive it.
  BenchWork(BenchOptions options, BenchSources sources, Documents& documents, Job& job, LiveMachine* live);

  std::string begin();  ///< opens what the options name
  /// Another session's bag. @param shownAs its name for people.
  std::string open(const std::filesystem::path& bag, const std::string& shownAs);
  /// From any thread: takes a file of measurements, which `preview` and `import` read. @throw InputError: it
  /// is no text.
  std::string receive(const std::string& name, std::shared_ptr<const std::string> content);
  /// From any thread: publishes what the file would become; a file that is refused is shown with its faults.
  std::string preview(const ImportWish& wish);
  /// Writes what the file became into the folder of imported bags, and opens it. @throw InputError too: its
  /// name is no plain one, or is taken; what it takes from the session in hand is not of the one that was
  /// seen.
  std::string import(const ImportWish& wish);
  /// What the machine has measured so far. @param beside with the session in hand, as moves that its
  /// diagnosis proposed.
  std::string openLive(bool beside = false);
  /// @param model YAML: {effects: […]}; empty: the effects of the calibration in use. No file that it names
  /// is opened.
  std::string calibrate(const std::string& model, const std::string& method, std::uint64_t seed);
  std::string diagnose();
  std::string add(const std::string& effect);     ///< YAML
  std::string remove(const std::string& effect);  ///< YAML
  std::string addAll();
  std::string use(const std::string& id);  ///< a calibration of the store, on this session
  std::string promote(const std::string& id);
  std::string rollback(const std::string& id);
  /// The active calibration against this session, as `mm verify`. @throw InputError too when it was fitted to
  /// this very session.
  std::string verify();
  std::string report();  ///< the page of `mm report`
  /// From any thread: publishes what a plan (YAML) would do on the machine, as planDocument(); nothing moves.
  std::string lookAt(const std::string& plan) const;

  /// The tables for a controller, as a ZIP archive: `mm export` without options of its own. @param controller
  /// as `mm export --to` calls it.
  std::string exportTo(const std::string& controller);
  /// Where it is kept who did what: in the folder of calibrations; empty: that is not known yet.
  std::filesystem::path logFile() const;

  /// Whether a formula can be added, from any thread: `{"ok": …, "message": …, "effect": …}`.
  std::string judgeFormula(const std::string& direction, const std::string& formula,
                           const std::string& start) const;

 private:
  struct ImportFile {
    std::uint64_t number = 0;
    std::string name;
    std::shared_ptr<const std::string> content;
    std::size_t lines = 0;
  };
  std::shared_ptr<const Session> opened() const;  // from any thread
  std::filesystem::path importFolder() const;
  std::filesystem::path bagFor(const std::string& output) const;
  std::string freeBagName(const std::string& file) const;
  void offerFile();  ///< to the page, with a name for its bag
  void checkInHand(const ImportWish& wish) const;
  ImportFile fileOf(const ImportWish& wish) const;
  Machine machineOf(const ImportWish& wish, const Session* like) const;
  ImportPreview read(const ImportWish& wish, const ImportFile& file, const Machine& machine,
                     const Session* like, const ProgressCallback& progress) const;
  std::string openBag(const std::filesystem::path& bag, const std::string& shownAs, UrdfOrigin origin);
  using Change = Recalibration (*)(const Session&, const Calibration&, const EffectSpec&,
                                   const CalibrateOptions&);
  std::string change(const std::string& effect, Change change, const char* done);
  void take(Session session, const std::string& shownAs);
  void keep(Recalibration& done);
  void show();
  void showMachine(const Machine& machine);
  void showStore();
  void showDiagnosis(const Diagnosis& diagnosis);
  std::string activated(std::string message);
  void forget(std::initializer_list<const char*> documents);
  void chooseStore(const Session& session);
  void nominalResiduals();
  void firstFit();
  const Session& session() const;
  const Calibration& calibration() const;
  CalibrationStore& store();
  CalibrateOptions options() const;

  BenchOptions options_;
  BenchSources sources_;
  Documents& documents_;
  Job& job_;
  LiveMachine* live_;
  std::string shownAs_, space_;
  UrdfOrigin origin_ = UrdfOrigin::kThisComputer;  // of the session's machine
  std::string drawnUrdf_;                          // whose meshes are published
  UrdfOrigin drawnOrigin_ = UrdfOrigin::kThisComputer;
  std::optional<Calibration> calibration_;
  bool kept_ = false;
  EarlierResiduals earlier_;
  std::optional<CalibrationStore> store_;
  mutable std::mutex mutex_;  // guards the next; the working thread alone writes session_
  std::shared_ptr<const Session> session_;
  ImportFile file_;                         // that was sent to be imported
  std::shared_ptr<const Domain> domain_;    // of the session
  std::shared_ptr<const Machine> machine_;  // that is shown
};

}  // namespace mm
