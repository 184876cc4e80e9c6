#pragma once
#include <vector>

namespace mm {

/// The smoothest functions on -1 … 1: the straight line and the bending modes of a free beam. These are the
/// eigenfunctions of the mean squared second derivative (Demmler and Reinsch 1975): orthonormal over the
/// range and without a mean, and under the prior of the smoothing spline (Wahba 1990) their coefficients are
/// independent, with standard deviations that fall with roughness. No function is larger at one place than at
/// another by much, so the prior is as wide in the middle as near the ends; polynomials flare there.
class SmoothBasis {
 public:
  /// @param functions 1 or more, the straight line among them. @param smoothness power with which the
  /// standard deviation falls with the wave number: 2 is the cubic smoothing spline's, 1 a rougher curve's.
  SmoothBasis(int functions, double smoothness);

  int size() const { return static_cast<int>(priorStd_.size()); }  ///< number of functions
  /// Writes size() values. @param u beyond -1 … 1 as at the end; NaN gives NaN.
  void values(double u, double* out) const;
  /// Of coefficient i, where the curve's mean square over the range is 1.
  double priorStd(int i) const { return priorStd_[static_cast<std::size_t>(i)]; }

 private:
  struct Mode {
    double wave = 0.0;   // tan(wave) = -tanh(wave) of an even mode, tanh(wave) of an odd one
    double atEnd = 0.0;  // cos(wave) of an even mode, sin(wave) of an odd one
    bool even = true;
  };
  std::vector<Mode> modes_;
  std::vector<double> priorStd_;
};

}  // namespace mm
