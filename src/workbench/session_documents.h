#pragma once
#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "estimation/calibrate.h"
#include "session/session.h"
#include "workbench/web_handler.h"

namespace mm {

// What the page shows of a session, as JSON in the units of people; no figure is NaN.

/// Machine, artifact, coverage (as `mm check --json`), what was assumed, set aside and is asked.
/// @param shownAs its name for people.
std::string sessionDocument(const Session& session, const std::string& shownAs);

/// The machine as the page draws it: name, URDF, joints with their limits.
std::string machineDocument(const Machine& machine);

/// One more set of residuals, of the same rows.
struct EarlierResiduals {
  std::string name;        // "without backlash of x"
  Eigen::VectorXd values;  // a data row, m or rad
};

/// Every residual with everything that was recorded of it, column by column: the page draws any against any.
/// @param earlier left out where its size is another.
std::string pointsDocument(const CalibrationResult& fit, const EarlierResiduals& earlier);

/// The contacts of a live session as they come. Each is written once, however many pages ask however often:
/// there may be 100,000.
class ContactsDocument {
 public:
  /// @param contacts nominal tips so far, m, workpiece. @return `{"at_mm": [[x, y, z], …]}`.
  WebAnswer of(const std::vector<Eigen::Vector3d>& contacts);

 private:
  std::string list_;  // what is written of it
  std::size_t count_ = 0;
  Eigen::Vector3d first_ = Eigen::Vector3d::Zero(), last_ = Eigen::Vector3d::Zero();
  std::shared_ptr<const std::string> body_;
};

/// Temperatures and covariates against time, thinned to what can be seen.
std::string heatDocument(const Session& session);

}  // namespace mm
