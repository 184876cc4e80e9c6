#pragma once
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "simulation/chain.h"
#include "simulation/probe.h"
#include "simulation/source.h"
#include "simulation/thermal.h"
#include "simulation/true_artifact.h"

namespace mm {

/// A logged quantity that is no temperature, as it really goes: mean, swing and slow noise.
struct TrueCovariate {
  std::string name, unit;
  double mean = 0.0, swing = 0.0, period = 3600.0, phase = 0.0;     // in `unit`; s; rad
  double from = 0.0, to = std::numeric_limits<double>::infinity();  // s; zero outside
  double at(double time) const;                                     ///< in `unit`; time in s
};

/// Everything that is wrong with one instrument.
struct Physics {
  std::vector<Source> sources;
  std::vector<double> gap;  // play of each joint, m or rad
  SeatedProbe probe;
  LaserProbe laser;
  TrueArtifact artifact;
  int artifactBody = 0;             // body of the ThermalModel whose temperature the artifact has
  std::vector<Follower> followers;  // bodies after those of the ThermalModel
  std::vector<TrueCovariate> covariates;

  Distortion distortion(const Condition& condition) const;  ///< sum of all sources
};

/// A state of which the truth is asked: what a contact records. SI units.
struct TrueState {
  double time = 0.0;             // s from the session's start
  std::vector<double> position;  // latched readings
  std::vector<double> velocity;
  std::vector<double> travel;  // -1, +1: side to which the play is taken up; 0: in its middle
  Eigen::Vector3d approach = Eigen::Vector3d::Zero();  // unit vector in workpiece; zero: no contact
  Eigen::Vector3d push = Eigen::Vector3d::Zero();      // into the surface; zero: along the approach
  double laserReading = std::numeric_limits<double>::quiet_NaN();  // m; NaN: touch probe
  double incidenceCosine = 1.0;                                    // of the laser beam on the surface
};

/// Where the probe really was: judge of corrections. Immutable; safe to call from several threads.
class Truth {
 public:
  Truth(Chain chain, Physics physics, ThermalModel thermal)
      : chain_(std::move(chain)), physics_(std::move(physics)), thermal_(std::move(thermal)) {}

  /// What its errors depend on in a state.
  Condition condition(const TrueState& state) const;
  /// True tip centre (touch) or surface point (laser) and true orientation of the probe, in workpiece.
  /// Times beyond the session's end have its last temperatures.
  ProbePose pose(const TrueState& state) const;
  Eigen::Vector3d position(const TrueState& state) const { return pose(state).position; }
  /// What the readings say without any correction.
  Eigen::Vector3d nominal(const TrueState& state) const;
  /// True centre of a ball, or a point, in workpiece at a time (s).
  Eigen::Vector3d featureCentre(int feature, double time) const;
  /// True temperature (degC) of a body at a time (s). @param body index in the ThermalModel.
  double temperature(int body, double time) const { return thermal_.recorded(time)[body]; }
  const Physics& physics() const { return physics_; }

 private:
  Chain chain_;
  Physics physics_;
  ThermalModel thermal_;
};

}  // namespace mm
