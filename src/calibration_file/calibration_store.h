#pragma once
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "calibration_file/calibration.h"

namespace mm {

/// A folder in which every calibration is kept: `<id>.yaml`, the links `active` and `candidate`,
/// `promotions`, the list of what was made active and when, and `verifications`, what fresh points said of
/// them. Every change is one rename of something complete,
/// so that whoever is killed at any moment loses nothing; writers of several processes wait for each other.
class CalibrationStore {
 public:
  /// What is active, or why it is not what was promoted.
  struct Active {
    std::optional<Calibration> calibration;  // empty: none was promoted yet
    std::string warning;  // names a damaged file and what took its place; empty: all is well
  };

  /// One calibration kept, for a table.
  struct Entry {
    std::string id, created, machine, session, method;
    std::filesystem::path file;
    double rms = 0.0, heldOutRms = 0.0;  // m; NaN: none
    std::size_t effects = 0;
    bool active = false, candidate = false;
    int promotions = 0;     // how often it was made active
    int lastPromotion = 0;  // the last time among all promotions of the store, from 1; 0: never
    std::string damaged;    // why it cannot be read; empty: it can
  };

  /// One line of `promotions`.
  struct Promotion {
    std::string time;    // ISO 8601, UTC
    std::string action;  // promote or rollback
    std::string id;
  };

  /// One line of `verifications`: what fresh points said of a calibration that is kept.
  struct Verified {
    std::string time;  // ISO 8601, UTC
    std::string id, verdict;
    double before = 0.0, after = 0.0;        // RMS, m (rad where `angular`)
    double beforeStd = 0.0, afterStd = 0.0;  // their standard uncertainties
    bool angular = false;
    int points = 0;
    std::string session;  // where the points came from
  };

  /// One line of `certificates`: an issue of a certificate of a calibration that is kept.
  struct Issue {
    std::string stamp, id, form;  // when, as its number has it; of the calibration; "paper" or "digital"
    int count = 0;                // among the issues of this calibration, from 1
  };

  /// @param folder made when something is first written. A folder that does not exist is an empty store.
  explicit CalibrationStore(std::filesystem::path folder) : folder_(std::move(folder)) {}

  /// `$MM_CALIBRATIONS`, else `~/.measuring_machine/calibrations`. @throw InputError when neither is known.
  static std::filesystem::path defaultFolder();
  const std::filesystem::path& folder() const { return folder_; }

  /// Keeps the calibration and makes it the candidate; completes its id (and changes it when another
  /// calibration has it). @return its id. @throw InputError: full disk, no permission.
  std::string add(Calibration& calibration);

  /// Refuses a calibration by throwing an InputError.
  using Check = std::function<void(const Calibration&)>;

  /// @param id empty: the candidate. @param check asked before it becomes active. @return the id made active.
  /// @throw InputError: none such, damaged, or refused by `check`.
  std::string promote(const std::string& id = {}, const Check& check = {});

  /// Makes active again what was active before (the last that is undamaged), or the one named. @return its
  /// id.
  /// @throw InputError: nothing before, none such, never active, or damaged; UnreadableFile: the one before
  /// may be whole, but the disk does not give it.
  std::string rollback(const std::string& id = {}, const Check& check = {});

  /// Id to which a link of the folder ("active", "candidate") leads; empty: there is no such link.
  /// @throw InputError: it leads out of the folder, or is no link.
  std::string linked(const char* link) const;

  /// The active calibration. When its file is damaged, the one that was active before it becomes active (as
  /// by rollback) and the warning says so. One that the disk does not give stays the active one in the
  /// folder.
  /// @throw InputError when no undamaged one was ever active; UnreadableFile when the one before is not
  /// given.
  Active active() const;
  /// The candidate; none when it is also the active one. A damaged file is a warning.
  Active candidate() const;

  /// @throw InputError: none such, or damaged.
  Calibration load(const std::string& id) const;

  /// All that is kept, oldest first.
  std::vector<Entry> history() const;
  /// What was made active and when, oldest first.
  std::vector<Promotion> promotions() const;

  bool keeps(const std::string& id) const;  ///< whether a calibration of that id is kept
  /// Adds to the list of verifications. @param verified its time may be empty: now.
  /// @throw InputError: the folder keeps no such calibration, or cannot be written.
  void note(Verified verified) const;
  /// What was noted, oldest first; lines that cannot be read are left out.
  std::vector<Verified> verifications() const;

  /// Adds to the list of certificates. @param issue its count is the least that it may get. @return the count
  /// that no other issue of the calibration has. @throw InputError as note.
  int noteIssue(Issue issue) const;
  /// Oldest first; lines that cannot be read are left out.
  std::vector<Issue> issues() const;

 private:
  std::filesystem::path fileOf(const std::string& id) const;
  std::string linkedHere(const char* link) const;  // as linked; empty where that refuses
  /// What was active before `id`, latest first.
  std::vector<std::string> before(const std::string& id) const;
  void makeActive(const std::string& id, const std::string& action) const;
  std::string fallBack(const std::string& damaged, std::string& passedOver) const;
  void prepareFolder() const;

  std::filesystem::path folder_;
};

}  // namespace mm
