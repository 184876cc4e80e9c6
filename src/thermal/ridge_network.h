#pragma once
#include "thermal/ridge.h"
#include "thermal/thermal_network.h"

namespace mm {

/// Linear in the temperatures, with a ridge chosen by cross-validation over blocks of time: what every other
/// network has to beat.
class RidgeNetwork : public ThermalNetwork {
 public:
  explicit RidgeNetwork(const NetworkSettings& settings) : ThermalNetwork(settings) {}  ///< not trained yet

  NetworkKind kind() const override { return NetworkKind::kRidge; }
  void evaluate(const double* x, double* y) const override;
  std::string describe() const override;

 protected:
  void learn(int from) override;
  void write(std::vector<double>& numbers) const override;
  void read(const double*& next, const double* end) override;

 private:
  RidgeModel model_;
  double heldOut_ = 0.0;  // unit of y
};

}  // namespace mm
