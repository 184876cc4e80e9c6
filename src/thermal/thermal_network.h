#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "thermal/dfnn_rules.h"
#include "thermal/numbers.h"

namespace mm {

enum class NetworkKind { kDfnn, kRbf, kRidge };
/// "dfnn", "rbf", "ridge". networkKind() throws InputError for any other name.
std::string nameOf(NetworkKind kind);
NetworkKind networkKind(const std::string& name);

struct NetworkSettings {
  int blocks = 10;  // of time, for the cross-validation of ridge, spread and rules; at most one a sample
  DfnnSettings dfnn;
};

/// A learned map from temperatures to displacements, many outputs at a time. Inputs and outputs keep the
/// units they are given in (degC; m, or um); they are standardised inside. Evaluation is const and safe in
/// several threads.
class ThermalNetwork {
 public:
  virtual ~ThermalNetwork() = default;

  virtual NetworkKind kind() const = 0;                        ///< which network it is
  int inputs() const { return static_cast<int>(x_.cols()); }   ///< temperatures
  int outputs() const { return static_cast<int>(y_.cols()); }  ///< positions
  int samples() const { return static_cast<int>(x_.rows()); }  ///< that it learned
  /// The samples that it learned from, in the order of time: inputs, and outputs.
  const Eigen::MatrixXd& sampleInputs() const { return x_; }
  const Eigen::MatrixXd& sampleOutputs() const { return y_; }
  /// Rules of a DFNN, centres of an RBF network, 1 of a linear one.
  virtual int rules() const { return 1; }
  /// Constants that were fitted to the samples, at most one a value; a ridge holds some of them back.
  int unknowns() const;

  /// Learns from samples x inputs and samples x outputs, in the order of time, and forgets what was learned
  /// before. Throws InputError for shapes that do not fit, values that are not finite, or fewer than 3
  /// samples.
  void fit(const Eigen::MatrixXd& x, const Eigen::MatrixXd& y);
  /// Learns again from a new set beside the samples of fit(), so that nothing is forgotten. Needs fit()
  /// first.
  void update(const Eigen::MatrixXd& x, const Eigen::MatrixXd& y);

  /// Writes outputs() values for inputs() temperatures. Allocates nothing.
  virtual void evaluate(const double* x, double* y) const = 0;
  Eigen::MatrixXd evaluateAll(const Eigen::MatrixXd& x) const;

  /// Everything that makes the network, its samples included; networkFromNumbers() gives the same network to
  /// the bit.
  std::vector<double> toNumbers() const;

 protected:
  explicit ThermalNetwork(NetworkSettings settings) : settings_(settings) {}
  /// Learns from x_ and y_.
  virtual void learn() = 0;
  /// What it consists of beside the samples, in the order in which it is stored.
  virtual void store(NetworkNumbers& numbers) = 0;
  friend std::unique_ptr<ThermalNetwork> networkFromNumbers(const std::vector<double>& numbers);

  int blocks() const { return std::min(settings_.blocks, samples()); }

  NetworkSettings settings_;
  Eigen::MatrixXd x_, y_;  // the samples
};

/// Dynamic fuzzy neural network of DFNN: y_p = sum_k w_pk psi_k with linear consequents w_pk = a_pk0 + a_pk .
/// x.
///
/// As published, the consequents come from least squares. By default they are a line common to all rules plus
/// one departure from it a rule, both held back by a ridge of its own: with a strong ridge on the departures,
/// or with one rule, the network is ridge-linear regression exactly. Number of rules, their overlap and both
/// ridges are chosen by cross-validation over blocks of time, and more than one rule only where that lowers
/// the held-out error clearly. Throws InputError for settings out of range.
std::unique_ptr<ThermalNetwork> newDfnn(const NetworkSettings& settings);
/// Exact radial-basis network, the rival in DFNN: one Gaussian centre a sample and an offset, so that every
/// sample is met; one spread for all, chosen by cross-validation over blocks of time. Longer series than 300
/// samples are thinned evenly to so many.
std::unique_ptr<ThermalNetwork> newRbfNetwork(const NetworkSettings& settings);
/// Linear in the temperatures, with a ridge chosen by cross-validation over blocks of time: what every other
/// network has to beat.
std::unique_ptr<ThermalNetwork> newRidgeNetwork(const NetworkSettings& settings);

/// One of these, which has learned nothing yet. Throws InputError for settings out of range.
std::unique_ptr<ThermalNetwork> makeNetwork(NetworkKind kind, const NetworkSettings& settings = {});
/// The network that toNumbers() wrote. Throws InputError when the numbers are not those of a network.
std::unique_ptr<ThermalNetwork> networkFromNumbers(const std::vector<double>& numbers);

/// What a network says of every sample when it was fitted without the block of time that holds it. Throws
/// InputError as fit() does; `goOn`, asked before each block, stops it with Cancelled.
Eigen::MatrixXd heldOutPredictions(NetworkKind kind, const Eigen::MatrixXd& x, const Eigen::MatrixXd& y,
                                   const NetworkSettings& settings = {},
                                   const std::function<bool()>& goOn = {});
/// The same of no network: the mean of the other blocks.
Eigen::MatrixXd heldOutMeans(const Eigen::MatrixXd& y, const NetworkSettings& settings = {});

}  // namespace mm
