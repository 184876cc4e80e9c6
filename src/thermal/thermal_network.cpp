#include "thermal/thermal_network.h"

#include <algorithm>
#include <iterator>

#include "base/error.h"
#include "thermal/ridge.h"

namespace mm {
namespace {

constexpr double kVersion = 1.0;

/// By NetworkKind.
struct Kind {
  const char* name;
  std::unique_ptr<ThermalNetwork> (*make)(const NetworkSettings& settings);
};
constexpr Kind kKinds[] = {{"dfnn", newDfnn}, {"rbf", newRbfNetwork}, {"ridge", newRidgeNetwork}};

void check(const Eigen::MatrixXd& x, const Eigen::MatrixXd& y) {
  if (x.rows() != y.rows())
    throw InputError("thermal network: " + std::to_string(x.rows()) + " samples of temperature and " +
                     std::to_string(y.rows()) + " of displacement; the series must have the same length");
  if (x.cols() < 1 || y.cols() < 1)
    throw InputError("thermal network: at least one temperature and one displacement are needed");
  if (!x.allFinite() || !y.allFinite())
    throw InputError("thermal network: a value is not a finite number; fill the gap or leave the sample out");
}

/// Contiguous blocks of time, at most one a sample.
std::vector<Fold> foldsOf(Eigen::Index samples, const NetworkSettings& settings) {
  return blockedFolds(static_cast<int>(samples), std::min(settings.blocks, static_cast<int>(samples)));
}

}  // namespace

std::string nameOf(NetworkKind kind) { return kKinds[static_cast<std::size_t>(kind)].name; }

NetworkKind networkKind(const std::string& name) {
  for (std::size_t k = 0; k < std::size(kKinds); ++k)
    if (name == kKinds[k].name) return static_cast<NetworkKind>(k);
  throw InputError("thermal network '" + name + "' is not known; it is dfnn, rbf or ridge");
}

void ThermalNetwork::fit(const Eigen::MatrixXd& x, const Eigen::MatrixXd& y) {
  check(x, y);
  if (x.rows() < 3)
    throw InputError("thermal network: " + std::to_string(x.rows()) +
                     " samples are too few to learn from; at least 3 are needed");
  x_ = x;
  y_ = y;
  learn();
}

void ThermalNetwork::update(const Eigen::MatrixXd& x, const Eigen::MatrixXd& y) {
  check(x, y);
  if (samples() == 0)
    throw InputError("thermal network: nothing was learned yet that could be updated; fit it first");
  if (x.cols() != x_.cols() || y.cols() != y_.cols())
    throw InputError("thermal network: the new set has " + std::to_string(x.cols()) + " temperatures and " +
                     std::to_string(y.cols()) + " displacements, the network " + std::to_string(x_.cols()) +
                     " and " + std::to_string(y_.cols()) + "; measure with the same sensors and positions");
  const int from = samples();
  x_.conservativeResize(from + x.rows(), Eigen::NoChange);
  y_.conservativeResize(from + y.rows(), Eigen::NoChange);
  x_.bottomRows(x.rows()) = x;
  y_.bottomRows(y.rows()) = y;
  learn();
}

int ThermalNetwork::unknowns() const {
  int each = 1 + inputs();  // the line
  if (kind() == NetworkKind::kDfnn && rules() > 1) each += rules() * (1 + inputs());
  if (kind() == NetworkKind::kRbf) each = rules() + 1;
  return outputs() * std::min(each, samples());
}

Eigen::MatrixXd ThermalNetwork::evaluateAll(const Eigen::MatrixXd& x) const {
  Eigen::MatrixXd y(x.rows(), outputs());
  Eigen::VectorXd in(inputs()), out(outputs());
  for (Eigen::Index k = 0; k < x.rows(); ++k) {
    in = x.row(k).transpose();
    evaluate(in.data(), out.data());
    y.row(k) = out.transpose();
  }
  return y;
}

std::vector<double> ThermalNetwork::toNumbers() const {
  auto& self = const_cast<ThermalNetwork&>(*this);  // what writes changes nothing
  NetworkNumbers numbers;
  double version = kVersion;
  int which = static_cast<int>(kind());
  numbers(version);
  numbers(which);
  numbers(self.settings_.blocks);
  numbers(self.x_, -1, -1);
  numbers(self.y_, -1, -1);
  self.store(numbers);
  return numbers.written();
}

std::unique_ptr<ThermalNetwork> makeNetwork(NetworkKind kind, const NetworkSettings& settings) {
  if (settings.blocks < 2)
    throw InputError("thermal network: " + std::to_string(settings.blocks) +
                     " blocks for the cross-validation; at least 2 are needed");
  return kKinds[static_cast<std::size_t>(kind)].make(settings);
}

std::unique_ptr<ThermalNetwork> networkFromNumbers(const std::vector<double>& stored) {
  NetworkNumbers numbers(stored);
  double version = 0.0, kind = 0.0, blocks = 0.0;
  for (double* value : {&version, &kind, &blocks}) numbers(*value);
  if (version != kVersion || !(kind == 0.0 || kind == 1.0 || kind == 2.0) || !(blocks >= 2.0 && blocks < 1e6))
    throw InputError(
        "stored thermal network: its numbers are not those of a network of version 1; calibrate again");
  NetworkSettings settings;
  settings.blocks = static_cast<int>(blocks);
  std::unique_ptr<ThermalNetwork> network =
      makeNetwork(static_cast<NetworkKind>(static_cast<int>(kind)), settings);
  numbers(network->x_, -1, -1);
  numbers(network->y_, network->x_.rows(), -1);
  network->store(numbers);
  numbers.finish();
  return network;
}

Eigen::MatrixXd heldOutPredictions(NetworkKind kind, const Eigen::MatrixXd& x, const Eigen::MatrixXd& y,
                                   const NetworkSettings& settings, const std::function<bool()>& goOn) {
  check(x, y);
  Eigen::MatrixXd predicted(y.rows(), y.cols());
  for (const Fold& fold : foldsOf(y.rows(), settings)) {
    if (goOn && !goOn()) throw Cancelled("thermal network: cancelled");
    const std::unique_ptr<ThermalNetwork> network = makeNetwork(kind, settings);
    network->fit(rowsOf(x, fold.train), rowsOf(y, fold.train));
    predicted.middleRows(fold.test.front(), static_cast<Eigen::Index>(fold.test.size())) =
        network->evaluateAll(rowsOf(x, fold.test));
  }
  return predicted;
}

Eigen::MatrixXd heldOutMeans(const Eigen::MatrixXd& y, const NetworkSettings& settings) {
  Eigen::MatrixXd predicted(y.rows(), y.cols());
  for (const Fold& fold : foldsOf(y.rows(), settings)) {
    const Eigen::RowVectorXd mean = rowsOf(y, fold.train).colwise().mean();
    predicted.middleRows(fold.test.front(), static_cast<Eigen::Index>(fold.test.size())).rowwise() = mean;
  }
  return predicted;
}

}  // namespace mm
