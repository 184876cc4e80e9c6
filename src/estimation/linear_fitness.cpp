#include "estimation/linear_fitness.h"

#include <cmath>

#include "estimation/whitened.h"

namespace mm {
namespace {

/// The columns of a sparse matrix, made entry by entry.
class ColumnsOfGenes {
 public:
  ColumnsOfGenes(std::vector<SparseColumn>& columns, std::size_t genes, std::size_t rows)
      : columns_(columns), columnOf_(genes, -1), rows_(rows) {}
  void add(int gene, std::size_t row, double value) {
    if (value == 0.0) return;
    int& c = columnOf_[static_cast<std::size_t>(gene)];
    if (c < 0) {
      c = static_cast<int>(columns_.size());
      columns_.push_back({static_cast<std::size_t>(gene), std::vector<double>(rows_, 0.0)});
    }
    columns_[static_cast<std::size_t>(c)].values[row] += value;
  }

 private:
  std::vector<SparseColumn>& columns_;
  std::vector<int> columnOf_;
  std::size_t rows_;
};

/// Contacts on balls, balls and linear rows of a problem.
class LinearParts {
 public:
  LinearParts(const Problem& problem, const Eigen::VectorXd& x, const std::vector<char>& fixed,
              const std::vector<int>& genes, const Eigen::VectorXd& inverseSigma, double unit)
      : problem_(problem),
        x_(x),
        fixed_(fixed),
        inverseSigma_(inverseSigma),
        unit_(unit),
        genes_(genes.size()),
        geneOf_(static_cast<std::size_t>(problem.unknownCount()), -1),
        ballOf_(problem.session().artifact.features.size() * problem.session().placementCount(), -1) {
    for (std::size_t g = 0; g < genes.size(); ++g) geneOf_[genes[g]] = static_cast<int>(g);
    std::vector<int> sphere, other;
    for (int i = 0; i < problem.rowCount(); ++i) {
      if (inverseSigma[i] == 0.0 || !problem.uses(problem.rows()[i].observation)) continue;
      (touchesBall(problem.rows()[i].observation) ? sphere : other).push_back(i);
    }
    takeContacts(sphere);
    int prior = problem.rowCount();  // the rows of the priors follow the data
    for (const int u : problem.priors()) {
      if (fixed[u]) continue;
      if (geneOf_[u] >= 0) other.push_back(prior);
      ++prior;
    }
    if (!other.empty()) takeRows(other);
  }

  SphereContacts contacts;
  std::vector<SphereBall> balls;
  LinearRows rows;

 private:
  bool touchesBall(int observation) const {
    const Observation& o = problem_.session().observations[observation];
    return o.kind == ObservationKind::kContact &&
           problem_.session().artifact.features[o.feature].kind == FeatureKind::kBall;
  }

  void takeContacts(const std::vector<int>& sphere) {
    const Artifact& artifact = problem_.session().artifact;
    const ErrorLayout layout = problem_.model().machine().layout();
    Model::Workspace work;
    std::vector<ColumnsOfGenes> displacement;
    for (auto& columns : contacts.displacement) displacement.emplace_back(columns, genes_, sphere.size());
    ColumnsOfGenes distance(contacts.distanceColumns, genes_, sphere.size());
    for (std::size_t s = 0; s < sphere.size(); ++s) {
      const int o = problem_.rows()[sphere[s]].observation;
      const Observation& at = problem_.session().observations[o];
      const ProbePose pose = problem_.model().differentiated(problem_.state(o), x_.data(), work);
      // at the start the genes have values: take their part out, so that the contact is P0 + B c
      const Eigen::Vector3d reach = pose.orientation * problem_.reach(at.stylus, x_);
      Eigen::Vector3d p0 = pose.position + reach;
      double d0 = artifact.features[at.feature].radius +
                  (std::isfinite(at.laserReading) ? 0.0 : artifact.tipRadiusOf(at.stylus)) +
                  work.errors[layout.distance()];
      for (const Model::Derivative& d : work.derivatives) {
        const int g = geneOf_[d.parameter];
        if (g < 0) continue;
        const Eigen::Vector3d moved = work.bySlot.block<3, 1>(0, d.slot) +
                                      Eigen::Vector3d(work.bySlot.block<3, 1>(3, d.slot)).cross(reach);
        for (int k = 0; k < 3; ++k) {
          const double b = moved[k] * d.value;
          displacement[static_cast<std::size_t>(k)].add(g, s, b);
          p0[k] -= b * x_[d.parameter];
        }
        if (d.slot == layout.distance()) {
          distance.add(g, s, d.value);
          d0 -= d.value * x_[d.parameter];
        }
      }
      for (int k = 0; k < 3; ++k) contacts.position[k].push_back(p0[k]);
      contacts.distance.push_back(d0);
      contacts.weight.push_back(std::pow(inverseSigma_[sphere[s]] * unit_, 2));
      contacts.ball.push_back(ballAt(at.feature, at.placement));
    }
  }

  std::size_t ballAt(int feature, int placement) {
    int& ball = ballOf_[static_cast<std::size_t>(feature * problem_.session().placementCount() + placement)];
    if (ball < 0) {
      ball = static_cast<int>(balls.size());
      SphereBall b;
      b.centre = problem_.featureInWorkpiece(feature, placement, x_);
      b.free = problem_.poseFree(placement) || problem_.find(UnknownKind::kFeature, feature) >= 0;
      balls.push_back(b);
    }
    return static_cast<std::size_t>(ball);
  }

  void takeRows(const std::vector<int>& other) {
    const WhitenedSystem system(problem_, x_, inverseSigma_, fixed_);
    ColumnsOfGenes columns(rows.columns, genes_, other.size());
    for (std::size_t i = 0; i < other.size(); ++i) {
      double offset = system.residuals[other[i]] * unit_;
      for (std::size_t c = 0; c < system.free.size(); ++c) {
        const int g = geneOf_[system.free[c]];
        if (g < 0) continue;
        const double b =
            system.jacobian(other[i], static_cast<int>(c)) / system.scale[static_cast<int>(c)] * unit_;
        columns.add(g, i, b);
        offset -= b * x_[system.free[c]];
      }
      rows.offset.push_back(offset);
    }
  }

  const Problem& problem_;
  const Eigen::VectorXd& x_;
  const std::vector<char>& fixed_;
  const Eigen::VectorXd& inverseSigma_;
  double unit_;
  std::size_t genes_;
  std::vector<int> geneOf_;  // an unknown: its gene, or -1
  std::vector<int> ballOf_;  // a feature in a placement: its ball, or -1
};

}  // namespace

std::unique_ptr<SphereFitness> linearFitness(const Problem& problem, const Eigen::VectorXd& x,
                                             const std::vector<char>& fixed, const std::vector<int>& genes,
                                             const Eigen::VectorXd& inverseSigma, double unit) {
  const LinearParts parts(problem, x, fixed, genes, inverseSigma, unit);
  return std::make_unique<SphereFitness>(parts.contacts, parts.balls, parts.rows, genes.size());
}

}  // namespace mm
