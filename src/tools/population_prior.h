#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

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

  /// Priors for those parameters of the model that the sisters have, in SI. @throw InputError: none of them.
  std::vector<ParameterPrior> forModel(const Session& session, const ModelSpec& model);
  /// Of the fits with and without the prior, the one to be used: without it where the session contradicts it.
  /// @param without empty: the session alone does not determine the model. Says what it did on standard
  /// error.
  Recalibration choose(Recalibration with, std::optional<Recalibration> without);
  nlohmann::ordered_json json() const;  ///< key "prior" of the result

 private:
  struct Used {
    PopulationPrior sisters;
    ParameterPrior si;
  };
  void judge(const CalibrationResult& with, const CalibrationResult* without);
  std::string folder_;
  std::vector<PopulationPrior> all_;
  std::vector<Used> used_;
  double chance_ = 1.0;  // of what the session says, were the machine a sister
  std::string worst_;    // the parameter that contradicts most, in words
  bool contradicted_ = false, alone_ = false;
};

}  // namespace mm
