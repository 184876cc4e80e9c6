#pragma once
#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "effects/registry.h"

namespace mm {

/// {type: profile, direction, variable} or {… variables: [a, b]}: a smooth function of one recorded variable,
/// or of two, where no effect of the catalogue has the shape.
EffectType profileType();

/// The spec of a profile. @param variables one or two, by the names of FormulaVariables.
EffectSpec profileSpec(const std::string& direction, const std::vector<std::string>& variables);
/// That of one which may change within a thirtieth of the range of its variable: a dent, a damaged place of a
/// scale.
EffectSpec roughProfileSpec(const std::string& direction, const std::string& variable);
/// The same profile with a size. @param size root mean square that the curve is expected to have over the
/// observed range, m (rad where the direction is a rotary joint); 0: the default.
EffectSpec sizedProfile(EffectSpec profile, double size, const Domain& domain);

/// What a profile says over the observed range of its variables, with its band; in the units of people.
struct ProfileCurve {
  struct Variable {
    std::string name, unit;  // unit of a covariate: empty
    double lower = 0.0, upper = 0.0;
  };
  struct Point {
    std::array<double, 2> at{};  // of the variables
    double value = 0.0,
           std = 0.0;  // error (true minus indicated, without its mean) and its standard deviation
  };
  std::vector<Variable> variables;  // one or two
  std::string unit;                 // of value and std: um or arcsec
  std::vector<Point> points;        // of two variables: points x points, the second changes first
};

/// @param spec of a profile. @param coefficients, covariance of its parameters, SI. @param points along each
/// variable.
/// @throw InputError as createEffect.
ProfileCurve profileCurve(const EffectSpec& spec, const Domain& domain, const Eigen::VectorXd& coefficients,
                          const Eigen::MatrixXd& covariance, int points = 101);

}  // namespace mm
