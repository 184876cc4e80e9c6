#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace mm {

/// Settings of the dynamic fuzzy neural network: DFNN, after Wu and Er, IEEE Trans. SMC-B 30(2) (2000)
/// 358-364, whose values for their first example these are. Distances and errors are in the units of the
/// standardised quantities.
struct DfnnSettings {
  bool published =
      false;  // consequents by least squares, as printed; else with a ridge, all by cross-validation
  bool standardise = true;       // false: thresholds are in the units of the inputs and outputs themselves
  double distanceMax = 2.0;      // d_max
  double distanceMin = 0.2;      // d_min
  double distanceDecay = 0.977;  // gamma
  double errorMax = 1.1;         // e_max
  double errorMin = 0.02;        // e_min
  double errorDecay = 0.9;       // beta
  double firstWidth = 2.0;       // sigma_0
  double overlap = 1.1;          // k: width of a new rule over its distance from the nearest
  double widening = 1.1;         // k_w
  double pruning = 0.0015;       // k_err
  int largestRules = 0;  // 0: as many as growth wants (published), or as cross-validation wants; at most 64
  /// Throws InputError, naming setting, value and bound.
  void validate() const;
};

/// Largest number of rules: evaluation keeps their strengths on the stack.
inline constexpr int kMostRules = 64;

/// The fuzzy rules of a network: Gaussian memberships with one width a rule, normalised over the rules.
struct DfnnRules {
  Eigen::MatrixXd centres;  // rules x inputs, standardised
  Eigen::VectorXd widths;   // sigma
  /// Range of the samples and a margin, standardised: beyond it the departures of RidgeConsequents stay as at
  /// its border, so that only the common line goes on. Empty: they go on too.
  Eigen::RowVectorXd low, high;

  int count() const { return static_cast<int>(widths.size()); }    ///< rules
  int inputs() const { return static_cast<int>(centres.cols()); }  ///< temperatures
  /// phi_j = exp(-|x - C_j|^2 / sigma_j^2), all times one factor that keeps them finite however far x is from
  /// all centres; psi_j is phi_j / sum phi. @param x(i): coordinate i. @return the sum.
  template <typename Coordinate>
  double memberships(Coordinate x, double* phi) const {
    double nearest = std::numeric_limits<double>::infinity(), sum = 0.0;
    for (int j = 0; j < count(); ++j) {
      double square = 0.0;
      for (int i = 0; i < inputs(); ++i) {
        const double d = x(i) - centres(j, i);
        square += d * d;
      }
      phi[j] = square / (widths(j) * widths(j));
      nearest = std::min(nearest, phi[j]);
    }
    for (int j = 0; j < count(); ++j) sum += phi[j] = std::exp(nearest - phi[j]);
    return sum;
  }
  /// Columns psi_j, psi_j x_1 … psi_j x_r of every rule: samples x rules (r + 1).
  Eigen::MatrixXd design(const Eigen::MatrixXd& x) const;
  /// Sets the range from the samples.
  void limitTo(const Eigen::MatrixXd& x);
  Eigen::MatrixXd limited(const Eigen::MatrixXd& x) const;
  void add(const Eigen::RowVectorXd& centre, double width);
  void keep(const std::vector<int>& rules);
};

/// Grows rules sample by sample: a new one where the error and the distance to the nearest centre are above
/// their falling thresholds, a wider one where only the error is; prunes by error reduction ratio after each
/// new rule. The consequents are refitted at every sample, with `ridge` (relative; 0: least squares).
/// @param x samples x inputs, standardised; y samples x outputs, standardised.
DfnnRules growRules(const Eigen::MatrixXd& x, const Eigen::MatrixXd& y, const DfnnSettings& settings,
                    double ridge);

/// Consequents of a fuzzy network with a ridge, in two steps: the ridge-linear fit, common to all rules, and
/// the departure of each rule from it, fitted to what the line leaves. So the network goes over into
/// ridge-linear regression as the ridge on the departures grows, and beyond the samples it goes on as that
/// does. Penalties are relative to the number of samples; the common offset is not penalised.
class RidgeConsequents {
 public:
  /// Columns 1, x and, where there are several rules, those of DfnnRules::design() for x within the rules'
  /// range.
  static Eigen::MatrixXd design(const Eigen::MatrixXd& x, const DfnnRules& rules);

  /// @param z design() of the samples, y samples x outputs, inputs: how many.
  RidgeConsequents(const Eigen::MatrixXd& z, const Eigen::MatrixXd& y, Eigen::Index inputs);
  /// Coefficients of the design's columns, columns x outputs, for each of the ridges on the line.
  std::vector<Eigen::MatrixXd> solve(const std::vector<double>& ridges, double departureRidge) const;
  Eigen::MatrixXd solve(double ridge, double departureRidge) const {
    return solve(std::vector<double>{ridge}, departureRidge).front();
  }

 private:
  Eigen::MatrixXd gram_, right_;  // of all columns
  double samples_;
  Eigen::Index line_;  // columns of the line
};

/// Moves centres and widths of the rules to the nearest minimum of the penalised squared error, the
/// consequents being those of each step (variable projection; Levenberg-Marquardt). Widths stay within a
/// factor of 10 of the start.
DfnnRules refineRules(const Eigen::MatrixXd& x, const Eigen::MatrixXd& y, const DfnnRules& start,
                      double ridge, double departureRidge);

}  // namespace mm
