#pragma once
#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <vector>

#include "estimation/genetic.h"
#include "estimation/genetic_sphere_kernel.h"

namespace mm {

/// One column of a sparse matrix: the factor of one coefficient in every row.
struct SparseColumn {
  std::size_t coefficient = 0;
  std::vector<double> values;
};

/// Contacts on balls, linear in the coefficients c: residual = |P0 + B c - C| - (D + E c), in metres.
struct SphereContacts {
  std::array<std::vector<double>, 3> position;            // P0: x, y, z, m, frame `workpiece`
  std::array<std::vector<SparseColumn>, 3> displacement;  // B: the columns of x, y, z
  std::vector<double> distance;                           // D: R + r, m
  std::vector<SparseColumn> distanceColumns;              // E
  std::vector<double> weight;                             // of the squared residual; empty: 1
  std::vector<std::size_t> ball;                          // index into `balls`
  std::size_t size() const { return distance.size(); }    ///< contacts
};

/// A ball: its centre in `workpiece`, m; of a free one, where the search for it starts.
struct SphereBall {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  bool free = true;
};

/// Further residuals y0 + b c: deviations of an independent instrument, points, priors.
struct LinearRows {
  std::vector<double> offset;
  std::vector<SparseColumn> columns;
};

/// How the centre of a free ball follows the chromosomes.
enum class CentreRule {
  /// MMT: recomputed by least squares after each generation, with its best chromosome.
  kOfBest,
  /// Besides, each chromosome is judged by the residual that is left when the centres follow it, to first
  /// order, by
  /// least squares: the three components that a shift of the centre explains are projected out of each ball's
  /// residuals.
  kFollow
};

/// The fitness of MMT (16), vectorised over chromosomes: cost = sum of w r^2 over contacts and linear rows,
/// divided by their number; m^2 with unit weights.
class SphereFitness : public GeneticFitness {
 public:
  /// @param coefficients length of c, which is the chromosome. Sizes must agree, and values be finite.
  SphereFitness(const SphereContacts& contacts, std::vector<SphereBall> balls, const LinearRows& rows,
                std::size_t coefficients, CentreRule rule = CentreRule::kFollow);

  std::size_t dimension() const override { return dimension_; }
  void evaluate(const double* population, std::size_t count, double* costs) const override;
  bool newGeneration(const double* best) override;
  std::vector<double> principalAxes(const GeneticRanges& ranges) const override;

  /// Centres, m, frame `workpiece`: those of the chromosome of the last newGeneration().
  const std::vector<SphereBall>& balls() const { return balls_; }

 private:
  struct Group {  // the contacts of one ball
    std::size_t first = 0, count = 0, padded = 0;
    std::size_t row = 0;  // of its first contact in rows_
    std::size_t ball = 0;
    Eigen::Matrix3d inverse = Eigen::Matrix3d::Zero();  // of the normal equations of the centre
  };
  Eigen::MatrixXd informationOfCoefficients() const;
  void copyContacts(const SphereContacts& contacts, const LinearRows& rows);
  void correct(const double* coefficients);
  void recomputeCentre(const Group& group);
  void fillRows(Group& group);
  void finishGroup(const Group& group, std::size_t lanes, const double* sums, double* costs) const;

  std::size_t dimension_, contactCount_ = 0, residualCount_ = 0, linearRows_ = 0;
  std::size_t linearTerms_ = 0;
  CentreRule rule_;
  std::vector<SphereBall> balls_;
  std::vector<Group> groups_;
  SphereTerms terms_;
  std::vector<std::size_t> termCoefficient_, linearCoefficient_;  // coefficient of each column
  std::array<std::vector<double>, 3> position_, corrected_;       // sorted by ball
  std::vector<double> distance_, correctedDistance_, rootWeight_;
  std::vector<double> columns_;  // contact-major: terms_.total() values a contact
  std::vector<double> linear_;   // row-major: offset and factors, times the root of the weight
  std::vector<float> rows_;      // what the kernel reads
  std::size_t stride_ = 0;
  bool filled_ = false, anyFree_ = false;
};

/// The fitness of MMT's centre GA (B2) from uncorrected contacts at `position` (x, y, z), which are
/// `distance` (R + r) away from the centre of one ball: the chromosome is how far that is from `near`, m.
SphereFitness ballCentreFitness(const std::array<std::vector<double>, 3>& position,
                                const std::vector<double>& distance, const Eigen::Vector3d& near);

}  // namespace mm
