#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "estimation/calibrate.h"

namespace mm {

/// Residuals as vectors in space, for one or more fits of the same session: from where the target should be
/// to where the machine found it.
struct ResidualVectors {
  struct Place {
    Eigen::Vector3d at;  // touched point, or tip, in workpiece, mm
    std::int64_t row = 0;
    int feature = -1;  // of the artifact
    bool outlier = false;
  };
  struct State {
    std::string name;
    std::vector<Eigen::Vector3d> vectors;  // a place: um, in workpiece
    std::vector<double> values;  // a place: um; along the ball's outward normal, else the vector's length
  };
  struct Ball {
    std::string name;
    Eigen::Vector3d centre;  // in workpiece, mm
    double radius = 0.0;     // mm
  };
  std::vector<Place> places;
  std::vector<State> states;
  std::vector<Ball> balls;
  bool signedValues = false;  // all places are contacts on balls: values have a sign
  int observations = 0;       // before thinning
};

/// One of several fits to show.
struct NamedFit {
  std::string name;
  const CalibrationResult* fit = nullptr;
};

/// @param fits of one session; the first gives the balls' places. Positions that lie on one line, and
/// sessions of deviations only, give no places: there is nothing to see in space. At most 3000 places, evenly
/// thinned.
ResidualVectors residualVectors(std::vector<NamedFit> fits);

}  // namespace mm
