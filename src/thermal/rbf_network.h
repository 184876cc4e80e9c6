#pragma once
#include "thermal/thermal_network.h"

namespace mm {

/// Exact radial-basis network, the rival in DFNN: one Gaussian centre a sample and an offset, so that every
/// sample is met; one spread for all, chosen by cross-validation over blocks of time. Longer series than
/// kMostCentres are thinned evenly to so many samples.
class RbfNetwork : public ThermalNetwork {
 public:
  static constexpr int kMostCentres = 300;
  explicit RbfNetwork(const NetworkSettings& settings) : ThermalNetwork(settings) {}  ///< not trained yet

  NetworkKind kind() const override { return NetworkKind::kRbf; }
  int rules() const override { return static_cast<int>(centres_.rows()); }
  void evaluate(const double* x, double* y) const override;
  std::string describe() const override;

 protected:
  void learn(int from) override;
  void write(std::vector<double>& numbers) const override;
  void read(const double*& next, const double* end) override;

 private:
  Eigen::RowVectorXd mean_, scale_;  // standardised x = (x - mean) * scale
  Eigen::MatrixXd centres_;          // centres x inputs, standardised
  double spread_ = 1.0;              // distance at which a centre's strength is one half, standardised
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  RowMajor weights_;  // centres x outputs
  Eigen::RowVectorXd offset_;
};

}  // namespace mm
