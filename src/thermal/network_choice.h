#pragma once
#include <Eigen/Core>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "thermal/thermal_network.h"

namespace mm {

/// What a model asks for: a network of this kind, or, where it is empty, the one that predicts best.
using NetworkWish = std::optional<NetworkKind>;
/// "auto" or nothing: the one that predicts best; else as networkKind(). Throws InputError for other names.
NetworkWish networkWish(const std::string& name);

/// What a network, or none, leaves of blocks of time that it was not fitted to.
struct NetworkTrial {
  std::string name;           // "none", "ridge", "rbf" or "dfnn"
  double heldOutRms = 0.0;    // unit of the displacements
  Eigen::MatrixXd predicted;  // samples x outputs, each by the network that has not seen its block
};

/// Which network is to work, and why.
struct NetworkChoice {
  std::optional<NetworkKind> kind;   // empty: none, it predicts as well as any that may work
  std::string reason;                // in words, to be read after the name of what works
  std::vector<NetworkTrial> trials;  // of those that were asked: none, ridge, then rbf and dfnn

  const NetworkTrial* find(const std::string& name) const;  ///< null: not tried
  /// Of what works, or of none.
  const NetworkTrial& chosen() const { return *find(kind ? nameOf(*kind) : "none"); }
};

/// A network that is so many times the held-out error of a simpler one is not better than it.
inline constexpr double kClearlyLessError = 0.98;

/// Chooses on held-out blocks of time. Without a wish: the best of none, ridge, rbf and dfnn, the simpler one
/// where the difference is less than two per cent. With a wish: that kind where it beats none and is not
/// significantly worse than the ridge-linear network; else the ridge-linear one where that beats none; else
/// none. None is no correction, or the mean of the other blocks, whichever leaves less.
/// @param x samples x inputs; y samples x outputs, in the order of time. Throws InputError as
/// ThermalNetwork::fit() does, and for fewer than 4 samples; `goOn`, asked before each block, stops it with
/// Cancelled.
NetworkChoice chooseNetwork(const NetworkWish& wish, const Eigen::MatrixXd& x, const Eigen::MatrixXd& y,
                            const NetworkSettings& settings = {}, const std::function<bool()>& goOn = {});

/// Whether errors on held-out blocks are larger than those of another network by more than chance explains (5
/// %): by the differences of the blocks, or by the ratio of the mean squares, one degree of freedom a sample.
/// The second is for a network that fails in one block altogether, which makes the differences scatter so
/// much that the first sees nothing.
bool significantlyWorse(const Eigen::MatrixXd& errors, const Eigen::MatrixXd& others,
                        const NetworkSettings& settings = {});

}  // namespace mm
