#pragma once
#include <filesystem>
#include <memory>
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
};

/// Follows a folder of calibrations. What is in memory stays in use until something readable takes its place:
/// a file that is damaged or gone while it is active changes nothing but the warning. One that the disk does
/// not give is asked for again at each look.
class CalibrationWatch {
 public:
  /// @param machine and @param space that a calibration must fit (misfitOf): another one's is refused.
  /// @param margin as Compensator::Options.
  CalibrationWatch(CalibrationStore store, const Machine& machine, std::string space, double margin);

  /// Looks whether links or files changed, and loads what did. @return a new pair, or null when nothing
  /// changed. Does not throw: what is wrong is in the warnings.
  std::shared_ptr<const CalibrationPair> refresh();

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
  Link look(const char* name) const;
  std::shared_ptr<const LoadedCalibration> fitting(Calibration calibration, std::string& warning) const;
  /// @return false: the disk did not give it, and it is to be asked again.
  bool load(const Link& link, const char* what, std::shared_ptr<const LoadedCalibration>& loaded,
            std::string& warning) const;
  void loadFirst();

  CalibrationStore store_;
  Machine machine_;
  std::string space_;
  double margin_;
  bool first_ = true, unreadable_ = false;
  Link activeLink_, candidateLink_;
  CalibrationPair now_;
};

}  // namespace mm
