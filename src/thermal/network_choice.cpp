#include "thermal/network_choice.h"

#include <algorithm>
#include <cmath>

#include "base/distributions.h"
#include "base/error.h"
#include "thermal/ridge.h"

namespace mm {
namespace {

constexpr double kChance = 0.05;

double rms(const Eigen::MatrixXd& errors) {
  return errors.norm() / std::sqrt(static_cast<double>(errors.size()));
}

NetworkTrial without(const Eigen::MatrixXd& y, const NetworkSettings& settings) {
  NetworkTrial none{"none", 0.0, heldOutMeans(y, settings)};
  none.heldOutRms = rms(none.predicted - y);
  if (rms(y) <= none.heldOutRms) {
    none.predicted.setZero();
    none.heldOutRms = rms(y);
  }
  return none;
}

/// The best, in the order of the trials where they are as good as equal.
const NetworkTrial& best(const std::vector<NetworkTrial>& trials) {
  const NetworkTrial* least = &trials.front();
  for (const NetworkTrial& trial : trials)
    if (trial.heldOutRms < kClearlyLessError * least->heldOutRms) least = &trial;
  return *least;
}

}  // namespace

NetworkWish networkWish(const std::string& name) {
  if (name.empty() || name == "auto") return std::nullopt;
  return networkKind(name);
}

const NetworkTrial* NetworkChoice::find(const std::string& name) const {
  const auto found =
      std::find_if(trials.begin(), trials.end(), [&](const NetworkTrial& t) { return t.name == name; });
  return found == trials.end() ? nullptr : &*found;
}

bool significantlyWorse(const Eigen::MatrixXd& errors, const Eigen::MatrixXd& others,
                        const NetworkSettings& settings) {
  if (errors.rows() != others.rows() || errors.cols() != others.cols() || errors.rows() < 2)
    throw InputError("thermal network: errors of " + std::to_string(errors.rows()) + " and of " +
                     std::to_string(others.rows()) + " samples cannot be compared");
  if (!(kClearlyLessError * rms(errors) > rms(others))) return false;
  const auto samples = static_cast<int>(errors.rows());
  if (errors.squaredNorm() > fisherLimit(kChance, samples, samples) * others.squaredNorm()) return true;
  const std::vector<Fold> folds = blockedFolds(samples, std::min(settings.blocks, samples));
  Eigen::VectorXd differences(static_cast<Eigen::Index>(folds.size()));
  for (std::size_t b = 0; b < folds.size(); ++b) {
    const auto rows = static_cast<Eigen::Index>(folds[b].test.size());
    const auto of = [&](const Eigen::MatrixXd& e) {
      return e.middleRows(folds[b].test.front(), rows).squaredNorm() / static_cast<double>(rows * e.cols());
    };
    differences(static_cast<Eigen::Index>(b)) = of(errors) - of(others);
  }
  const double blocks = static_cast<double>(folds.size()), mean = differences.mean();
  const double std = std::sqrt((differences.array() - mean).square().sum() / (blocks * (blocks - 1.0)));
  return mean > studentLimit(kChance, blocks - 1.0) * std;
}

NetworkChoice chooseNetwork(const NetworkWish& wish, const Eigen::MatrixXd& x, const Eigen::MatrixXd& y,
                            const NetworkSettings& settings, const std::function<bool()>& goOn) {
  if (y.rows() < 4)
    throw InputError("thermal network: " + std::to_string(y.rows()) +
                     " samples are too few to hold blocks of them out; at least 4 are needed");
  NetworkChoice choice;
  const auto attempt = [&](NetworkKind kind) {
    NetworkTrial trial{nameOf(kind), 0.0, heldOutPredictions(kind, x, y, settings, goOn)};
    trial.heldOutRms = rms(trial.predicted - y);
    choice.trials.push_back(std::move(trial));
  };
  choice.trials.push_back(without(y, settings));
  attempt(NetworkKind::kRidge);
  for (const NetworkKind kind : {NetworkKind::kRbf, NetworkKind::kDfnn})
    if (!wish || *wish == kind) attempt(kind);

  const NetworkTrial &none = choice.trials[0], &ridge = choice.trials[1];
  const auto works = [&](const NetworkTrial& trial) {
    return trial.heldOutRms < kClearlyLessError * none.heldOutRms;
  };
  if (!wish) {
    const NetworkTrial& least = best(choice.trials);
    if (&least != &none) choice.kind = networkKind(least.name);
    choice.reason = choice.kind ? "it predicts held-out blocks of time best"
                                : "neither ridge, rbf nor dfnn beats no network on held-out blocks of time";
    return choice;
  }
  const std::string asked = nameOf(*wish);
  const NetworkTrial& trial = choice.trials.back();  // the ridge-linear one where that was asked for
  const bool worse = significantlyWorse(trial.predicted - y, ridge.predicted - y, settings);
  if (works(trial) && !worse) {
    choice.kind = wish;
    choice.reason = "as asked for";
  } else if (works(ridge)) {
    choice.kind = NetworkKind::kRidge;
    choice.reason = "instead of " + asked + ", which " +
                    (worse ? "is significantly worse than ridge-linear" : "does not beat no network") +
                    " on held-out blocks of time";
  } else {
    choice.reason =
        (*wish == NetworkKind::kRidge ? "it does not beat" : "neither it nor ridge-linear beats") +
        std::string(" no network on held-out blocks of time");
  }
  return choice;
}

}  // namespace mm
