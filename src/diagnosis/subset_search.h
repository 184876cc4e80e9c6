#pragma once
#include <Eigen/Core>
#include <functional>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "diagnosis/candidates.h"
#include "diagnosis/structure.h"

namespace mm {

/// One effect chosen by the search, with the values found for its nonlinear parameters.
struct Chosen {
  int candidate = 0;
  std::vector<double> nonlinear;
  Eigen::MatrixXd columns;  // projected on the model only
};

/// A set of effects and how well it explains the residual.
struct Subset {
  std::vector<Chosen> chosen;
  Eigen::MatrixXd basis;  // orthonormal columns of the set
  Eigen::VectorXd left;   // what it leaves of the target
  double rss = 0.0;
  double penalty = 0.0;    // 1/2 ln N for each parameter
  double objective = 0.0;  // penalised negative log-likelihood: 1/2 N ln(rss / N) + penalty

  bool contains(int candidate) const;
};

/// Residuals; beyond, the search is narrower.
inline constexpr int kLargeSession = 4000;

/// The same physical cause: same type at the same place; degree, power, order, harmonic, period and lag are
/// its shape.
bool sameCause(const EffectSpec& a, const EffectSpec& b);

/// What one effect adds to a set.
struct Gain {
  int candidate = -1;
  std::vector<double> nonlinear;
  Eigen::MatrixXd columns;
  double drop = 0.0;  // of the residual sum of squares
  int rank = 0;
  double objective = 0.0;  // of the set with it
  double logP = 0.0;       // F test, not corrected
};

/// Candidates of one cause that has several shapes (degrees), each with one column.
struct Family {
  std::vector<int> candidates;
  Eigen::MatrixXd columns;  // projected, in units of the parameters' scale; a candidate each
  Eigen::MatrixXd gram;
};

/// What another shape of an effect of the model could do.
struct ShapeInModel {
  EffectSpec spec;
  Eigen::MatrixXd columns;  // projected, orthonormal
  double explained = 0.0;   // what the effect does in the session, whitened, squared
};

/// Which set of effects explains a residual: forward search with a beam, exchange of each member against
/// every other candidate, and a backward look. Everything is judged after joint refit, by projection.
class SubsetSearch {
 public:
  SubsetSearch(const ResidualSpace& space, const CandidateSet& set);

  /// Significance after correction for everything that was tried.
  double significance = 1e-3;
  int largest = 8;  // effects

  std::function<bool()> cancelled;
  Subset run() const;

  Subset empty() const;
  Subset extend(const Subset& subset, const Chosen& chosen) const;
  Subset without(const Subset& subset, std::size_t member) const;
  /// What is left when further columns explain what they can; the chosen effects stay.
  Subset withColumns(const Subset& subset, const Eigen::MatrixXd& columns) const;
  /// Without the members that are no longer significant beside further columns, the least first.
  /// @param spared members of this cause stay.
  Subset countingBeside(const Subset& subset, const Eigen::MatrixXd& columns,
                        const EffectSpec* spared = nullptr) const;
  /// What a member explains beside the others and further columns.
  Gain gainBeside(const Subset& subset, std::size_t member, const Eigen::MatrixXd& columns) const;
  /// The best `count` candidates to add, nonlinear parameters refined, best first.
  std::vector<Gain> bestGains(const Subset& subset, int count, bool refine) const;
  /// Gain of one candidate near given nonlinear values.
  Gain gainOf(const Subset& subset, int candidate, const std::vector<double>& nonlinear, bool refine) const;
  /// What the shape of a found effect may differ by from the catalogue's: its columns times low-order
  /// functions of the variables it depends on, projected on the model, orthonormal. No physical effect is
  /// exactly a Legendre polynomial or one exponential: what lies in this span is the same cause in another
  /// shape before it is another cause.
  const Eigen::MatrixXd& shapeOf(const Chosen& chosen) const;
  /// The same for the profiles that the model has already (straightness and the like, or a cause in several
  /// shapes), which rarely end with the last degree.
  const std::vector<ShapeInModel>& shapesInModel() const;
  /// Orthonormal columns of the subset and of the shapes of all its members (of those whose cause is not
  /// `but`).
  Eigen::MatrixXd withShapes(const Subset& subset, const EffectSpec* but = nullptr) const;
  /// Whether columns chosen among exp(`choices`) explain more than what a subset's basis does.
  bool beyond(const Subset& subset, const Eigen::MatrixXd& columns, double choices) const;
  /// False when a gain is only what the shape of a larger member leaves over.
  bool standsAlone(const Subset& subset, const Gain& gain) const;
  /// Number of different causes in a subset: the same type at the same place in other shapes is one.
  int causes(const Subset& subset) const;
  /// The found effects' columns times each variable: what is left if the size of an effect depends on another
  /// variable.
  Eigen::MatrixXd modulations(const Subset& subset) const;
  /// With one more effect where that pays, of another cause than candidate `but`: one effect may stand for
  /// two.
  Subset completed(const Subset& subset, int but) const;
  /// `rest` with one cause added in as many of its shapes as pay; `rest` itself when none can be.
  Subset withFamily(const Subset& rest, const Family& family) const;
  /// Its objective, without making it.
  double objectiveWith(const Subset& rest, const Family& family) const;
  const std::vector<Family>& families() const { return families_; }
  /// log of the p-value of a gain, corrected for the number of atoms tried.
  double correctedLogP(const Gain& gain) const;
  bool significant(const Gain& gain) const;
  double degreesOfFreedom() const { return dof_; }

 private:
  /// Raw columns of an effect times low-order functions of its variables, projected.
  Eigen::MatrixXd shaped(const EffectSpec& spec, const Eigen::MatrixXd& raw) const;
  void exchange(Subset& subset) const;
  /// One or two members against one cause in several shapes (degrees): a smooth profile is rarely one
  /// polynomial.
  bool exchangeForFamilies(Subset& subset) const;
  void prune(Subset& subset) const;
  /// Whether an effect of this size would be far larger than all that the model leaves, and be hidden by it.
  /// @param values of its linear parameters, in their scales.
  bool hidden(int candidate, const Eigen::VectorXd& values) const;
  /// Whether members take each other back, each far larger than what both explain. @param member one of them.
  bool cancelling(const Subset& subset, std::size_t& member) const;
  void refineAll(Subset& subset) const;
  /// Places in the family that pay, in the order found. @param objective of the subset with them.
  std::vector<int> chooseShapes(const Subset& rest, const Family& family, double& objective) const;
  Gain evaluate(const Subset& subset, int candidate, const std::vector<double>& nonlinear,
                Eigen::MatrixXd columns) const;
  /// False when an effect would have to be larger than its parameters can plausibly be.
  bool plausible(const Subset& subset, int candidate, const Eigen::MatrixXd& columns) const;
  double penaltyOf(const Subset& subset, int candidate) const;

  const ResidualSpace& space_;
  const CandidateSet& set_;
  mutable std::map<std::pair<int, std::vector<double>>, Eigen::MatrixXd> shapes_;
  mutable std::optional<std::vector<ShapeInModel>> inModel_;
  std::vector<Variable> variables_;
  std::vector<Family> families_;
  double dof_ = 1.0;                    // residuals minus the model's unknowns
  std::vector<Eigen::MatrixXd> grams_;  // an atom
};

}  // namespace mm
