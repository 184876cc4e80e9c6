#pragma once
#include "thermal/thermal_network.h"

namespace mm {

/// Dynamic fuzzy neural network of DFNN: y_p = sum_k w_pk psi_k with linear consequents w_pk = a_pk0 + a_pk .
/// x.
///
/// As published, the consequents come from least squares. By default they are a line common to all rules plus
/// one departure from it a rule, both held back by a ridge of its own: with a strong ridge on the departures,
/// or with one rule, the network is ridge-linear regression exactly. Number of rules, their overlap and both
/// ridges are chosen by cross-validation over blocks of time, and more than one rule only where that lowers
/// the held-out error clearly.
class Dfnn : public ThermalNetwork {
 public:
  explicit Dfnn(const NetworkSettings& settings);  ///< not trained yet

  NetworkKind kind() const override { return NetworkKind::kDfnn; }
  int rules() const override { return rules_.count(); }
  const DfnnRules& memberships() const { return rules_; }  ///< after fit()
  void evaluate(const double* x, double* y) const override;
  std::string describe() const override;

 protected:
  void learn(int from) override;
  void write(std::vector<double>& numbers) const override;
  void read(const double*& next, const double* end) override;

 private:
  void standardise();
  Eigen::MatrixXd scaledInputs() const;
  Eigen::MatrixXd scaledOutputs() const;
  void choose();
  void solve();

  Eigen::RowVectorXd meanX_, scaleX_, meanY_;  // scaled x = (x - mean) * scale
  double scaleY_ = 1.0;                        // scaled y = (y - mean) / scale
  DfnnRules rules_;
  double ridge_ = 0.0, departureRidge_ = 0.0;  // relative; 0 in a published network
  double heldOut_ = 0.0;                       // unit of y; 0 in a published network
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  RowMajor common_;   // (inputs + 1) x outputs, scaled: the line; zero in a published network
  RowMajor weights_;  // rules (inputs + 1) x outputs, scaled: the rules' consequents, or their departures
};

}  // namespace mm
