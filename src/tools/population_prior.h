#pragma once
#include <string>
#include <vector>

#include "base/json_text.h"
#include "fleet/prior.h"
#include "workflow/recalibration.h"

namespace mm {

/// The option --prior of `mm calibrate`: what sister machines say of the parameters of the model. Off unless
/// asked for; said on standard error, in the JSON and in the calibration file when it is used; and not used
/// where the session contradicts it.
class PriorOfSisters {
 public:
  /// @param folder results of mm batch, or stores; empty: no prior, and everything here does nothing.
  /// @param except machine that is left out of the sisters. @throw InputError.
  PriorOfSisters(const std::string& folder, const std::string& except);
  bool asked() const { return !folder_.empty(); }  ///< whether there is a prior at all

  /// Joins what the session said with what the sisters say, each by its covariance: the posterior of the
  /// linear problem, in which the session's other unknowns (pose, centres) have been integrated out. A
  /// parameter that the session holds at its convention stays there. Says on standard error what it did.
  /// @param fitted by the session alone. @throw InputError: the sisters have no parameter of this model.
  Recalibration join(Recalibration fitted, const Session& session, const CalibrateOptions& options);
  Json json() const;  ///< key "prior" of the result

 private:
  struct Used {
    PopulationPrior sisters;
    double toUnit = 1.0;
  };
  void match(const CalibrationResult& result);
  void judge(const CalibrationResult& result);
  void update(CalibrationResult& result) const;
  /// Held-out residuals and chi2 of the values with the prior, its rows among the data.
  void judgeAnew(const CalibrationResult& alone, CalibrationResult& joined) const;
  void tell(std::size_t fewest) const;
  std::string folder_;
  std::vector<PopulationPrior> all_;
  std::vector<Used> used_;
  std::vector<int> at_;         // the parameter of the model, of each
  Eigen::VectorXd mean_, std_;  // of each, SI
  double chance_ = 1.0;         // of what the session says, were the machine a sister
  std::string worst_;           // the parameter that contradicts most, in words
  bool contradicted_ = false;
};

}  // namespace mm
