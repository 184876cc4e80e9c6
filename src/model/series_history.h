#pragma once
#include <memory>
#include <mutex>
#include <vector>

#include "effects/state.h"
#include "session/session.h"

namespace mm {

/// Temperatures logged against time, as the effects with a memory ask for them: the exact response of a
/// first-order lag to the line through the logged values, constant beyond its ends. May be called from
/// several threads.
class SeriesHistory final : public TemperatureHistory {
 public:
  /// @param sensors in the order of the Domain; one without values answers NaN.
  explicit SeriesHistory(std::vector<Series> sensors);

  /// A time constant of 0 or less is no lag at all.
  double lagged(int sensor, double tau, double time, double* byTau) const override;

 private:
  /// How far the response is from the temperature at each logged time, and the derivative by tau (degC,
  /// degC/s).
  struct Response {
    int sensor = 0;
    double tau = 0.0;
    std::vector<double> behind, byTau;
  };
  std::shared_ptr<const Response> response(int sensor, double tau) const;

  std::vector<Series> sensors_;
  mutable std::mutex mutex_;
  mutable std::vector<std::shared_ptr<const Response>> recent_;  // the last few, newest first
};

}  // namespace mm
