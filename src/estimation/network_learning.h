#pragma once
#include <Eigen/Core>
#include <vector>

#include "estimation/calibrate.h"

namespace mm {

/// A model whose networks have learned, and what belongs to it.
struct LearnedModel {
  Model model;
  Eigen::VectorXd start;  // of its parameters: the other effects' fitted values, 1 for each gain
  /// By how much the networks, learned without the block of time that holds an observation, differ there from
  /// those that have seen everything: observations x joints, m or rad.
  Eigen::MatrixXd heldOutShift;
};

/// Whether the model has a thermal_network that has not learned yet.
bool hasToLearn(const Model& model);

/// What a new session adds to the networks of a calibrated model.
struct UpdatedNetworks {
  std::vector<LearnedNetwork> networks;  // of the model, updated
  Domain domain;                         // of the model, with the temperatures of both sessions in range
  std::vector<std::string> effects;      // canonical specs of the networks that were updated
  /// RMS over the new sets, m or rad: before, and after; judged on blocks of the new sets that the update did
  /// not see.
  double before = 0.0, after = 0.0, heldOut = 0.0;
  int sets = 0;
};

/// Updates the active networks with the sets of a session: the samples that they learned from stay, so
/// nothing is forgotten, and which kind of network works is chosen again, from the sets of all sessions
/// (where none beats no network, the kind stays). All other parameters stay as they are.
/// @param held a calibration with its effects held on the new session.
/// @throw InputError: no active network; the session lacks a sensor, an axis or positions of a network.
UpdatedNetworks updateNetworks(const CalibrationResult& held);

/// Physical effects come first: the model without its networks is fitted, and each network, in the order of
/// the model, learns what is left. Which kind works is chosen on held-out blocks of time (chooseNetwork()):
/// the best, or the one asked for by name unless a ridge-linear one is significantly better; where none beats
/// no network, nothing is active. Its summary says what works, and why. Deterministic.
/// @param start of the model's parameters; empty: the effects' own.
/// @throw InputError: no temperatures, too few sets, a listed sensor that does not vary. Cancelled.
LearnedModel learnNetworks(const Session& session, const Model& model, const CalibrateOptions& options,
                           const Eigen::VectorXd& start);

}  // namespace mm
