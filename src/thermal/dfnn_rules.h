#pragma once
#include <Eigen/Core>
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
  /// psi_j = phi_j / sum phi, with phi_j = exp(-|x - C_j|^2 / sigma_j^2); finite however far x is from all
  /// centres.
  void strengths(const double* x, double* psi) const;
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
/// @param start rules to go on from; the first `known` samples then only count for the consequents, and the
/// thresholds are at their final values.
DfnnRules growRules(const Eigen::MatrixXd& x, const Eigen::MatrixXd& y, const DfnnSettings& settings,
                    double ridge, const DfnnRules& start = {}, int known = 0);

/// eta_j of each rule: root mean square, over its columns and the outputs, of the error reduction ratios of
/// the orthogonalised design. Needs no fewer samples than columns.
Eigen::VectorXd errorReduction(const Eigen::MatrixXd& design, const Eigen::MatrixXd& y, int rules);

}  // namespace mm
