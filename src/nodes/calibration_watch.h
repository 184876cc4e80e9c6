#pragma once
#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "calibration_file/calibration_store.h"
#include "compensation/compensator.h"

namespace mm {

/// A calibration in memory, ready to be applied. Immutable.
struct LoadedCalibration {
  std::string id;
  Calibration calibration;
  Compensator frames;    // without uncertainty: for every joint state
  Compensator contacts;  // with it
  LoadedCalibration(Calibration c, double margin);
};

/// What is active and what is the candidate, at one moment. Immutable: a frame is made from one of these.
struct CalibrationPair {
  std::shared_ptr<const LoadedCalibration> active, candidate;
  std::string warning, candidateWarning;  // why it is not what the folder says, or that its file is damaged
  bool operator==(const CalibrationPair& o) const {
    return active == o.active && candidate == o.candidate && warning == o.warning &&
           candidateWarning == o.candidateWarning;
  }
};

/// Follows a folder of calibrations. What is in memory stays in use until something readable takes its place:
/// a file that is damaged or gone while it is active changes nothing but the warning. One that the disk does
/// not give is asked for again once a second, or when its link or file changes.
class CalibrationWatch {
 public:
  /// @param machine and @param space that a calibration must fit (misfitOf): another one's is refused.
  /// @param margin as Compensator::Options.
  CalibrationWatch(CalibrationStore store, const Machine& machine, std::string space, double margin);

  /// Looks whether links or files changed, and loads what did. @return a new pair, or null when neither a
  /// calibration nor a warning changed. Does not throw: what is wrong is in the warnings.
  std::shared_ptr<const CalibrationPair> refresh();
  /// What is in memory with another margin, as Compensator::Options. @return a new pair.
  std::shared_ptr<const CalibrationPair> setMargin(double margin);

 private:
  struct Link {
    std::string id;     // empty: no link
    std::string wrong;  // why it leads nowhere
    std::filesystem::file_time_type changed{};
    std::uintmax_t size = 0;
    bool operator==(const Link& o) const {
      return id == o.id && wrong == o.wrong && changed == o.changed && size == o.size;
    }
  };
  using Wall = std::chrono::steady_clock;
  struct Followed {
    Link link;                              // as it was when it was last loaded
    std::optional<Wall::time_point> again;  // the disk did not give it: when it is to be asked again
    bool due(const Link& now) const { return !(now == link) || (again && Wall::now() >= *again); }
    void note(const Link& now, bool given);
  };
  Link look(const char* name) const;
  std::shared_ptr<const LoadedCalibration> fitting(Calibration calibration, std::string& warning) const;
  /// @return false: the disk did not give it, and it is to be asked again.
  bool load(const Link& link, const char* what, std::shared_ptr<const LoadedCalibration>& loaded,
            std::string& warning) const;
  void loadFirst();
  bool followActive();  ///< @return whether its link or file changed
  void followCandidate(bool activeChanged);

  CalibrationStore store_;
  Machine machine_;
  std::string space_;
  double margin_;
  bool first_ = true;
  Followed active_, candidate_;
  CalibrationPair now_;
};

}  // namespace mm
