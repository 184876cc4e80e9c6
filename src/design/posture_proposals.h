#pragma once
#include <string>
#include <vector>

#include "estimation/problem.h"

namespace mm {

/// A posture to measure a ball or point in, with a few contacts around the direction of the probe.
struct ProposedPosture {
  std::string feature;
  std::vector<double> position;        // readings with the probe on the feature, one a joint, m or rad
  double laserReading = kNotMeasured;  // m
};

/// Postures beside those that were measured, and what they would do.
struct PostureAdvice {
  std::vector<ProposedPosture> postures;  // the most useful first
  struct Gain {
    std::string parameter, unit;
    double before = 0.0, after = 0.0;  // standard deviation in `unit`; at most the parameter's bound
  };
  std::vector<Gain> gains;  // of the parameters that become at least twice as certain
};

/// Postures that the rotary joints' limits and the travel of the linear joints allow, picked one after the
/// other so that the sum of the variances of the effects' parameters, each in units of its typical size,
/// falls most (A-optimal design). Empty without rotary joints, without three linear ones, or when nothing
/// helps much.
/// @param x point of linearisation. @param inverseSigma a data row, 1/m or 1/rad.
PostureAdvice proposePostures(const Problem& problem, const Eigen::VectorXd& x,
                              const Eigen::VectorXd& inverseSigma);

}  // namespace mm
