#pragma once
#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "session/session.h"

namespace mm {

struct Circle {
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
  double radius = 0.0;
};

/// Least squares of the distances from the circle (Gauss-Newton from the algebraic fit); in the unit of the
/// points.
Circle leastSquaresCircle(const std::vector<Eigen::Vector2d>& points);

/// A point of a circular path: where it should be on the circle, and how far the machine was from there.
struct CirclePoint {
  double angle = 0.0;       // rad, counter-clockwise from the plane's first axis
  double u = 0.0, v = 0.0;  // um, actual minus nominal along the first and second axis
  bool counterClockwise = true;
};

/// One path in one sense: radial deviations about the centre of its own least-squares circle (LSC).
struct CirclePath {
  std::vector<double> angle;       // rad, 0 … 2 pi, ascending
  std::vector<double> radial;      // um, F: actual minus nominal radius, positive away from the centre
  double circular = kNotMeasured;  // G, um: range of the radius about the LSC's centre
  double largest = kNotMeasured, smallest = kNotMeasured;  // F max, F min, um
};

/// Figures of ISO 230-4:2005 (G, G(b), F, D, about the centre of the least-squares circle) and the circular
/// hysteresis H of its first edition (1996), um. NaN where a sense was not measured.
struct CircleFigures {
  CirclePath counterClockwise, clockwise;
  double bidirectional = kNotMeasured;  // G(b): range of the radius of both paths about their common centre
  double meanRadial = kNotMeasured;     // D: radius of the LSC of both paths minus the nominal radius
  double hysteresis = kNotMeasured;     // H: largest difference of the radii of both paths at one angle
};

/// @param radius nominal, mm. A sense counts when its points leave no gap of more than 30 degrees.
CircleFigures circleFigures(const std::vector<CirclePoint>& points, double radius);

/// A circle that the session measured in one plane, with one zero of the instrument.
struct CircleTest {
  std::string first, second;  // axes of the plane; seen so that the second is counter-clockwise of the first
  std::string setup;          // empty: there is only one
  double radius = 0.0;        // mm, nominal
  CircleFigures measured, calibrated;  // as the machine is; what the model leaves
};

/// One measured place of a circle: the nominal point, and actual minus nominal as measured and as left.
struct CirclePlace {
  Eigen::Vector2d nominal, measured, left;  // mm, um, um
};

/// A circle, when the places in the order of time are one: its radius and figures; the names are the
/// caller's.
std::optional<CircleTest> circleTest(const std::vector<CirclePlace>& places);

}  // namespace mm
