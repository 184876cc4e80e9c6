#include "estimation/genetic_start.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.h"
#include "base/tiny.h"
#include "base/units.h"
#include "estimation/genetic_sphere_fitness.h"
#include "estimation/whitened.h"

namespace mm {
namespace {

/// The residuals themselves, for models that are not linear in their parameters.
class ResidualFitness final : public GeneticFitness {
 public:
  ResidualFitness(const Problem& problem, const Eigen::VectorXd& base, std::vector<int> genes,
                  const Eigen::VectorXd& inverseSigma, double unit, double metre,
                  std::function<bool()> cancelled)
      : problem_(problem),
        base_(base),
        genes_(std::move(genes)),
        inverseSigma_(inverseSigma),
        unit_(unit),
        metre_(metre),
        cancelled_(std::move(cancelled)) {
    placeOf_.assign(problem.rowCount(), -1);
    for (int u = 0; u < problem.unknownCount(); ++u)
      if (solvedInClosedForm(problem, u)) solved_.push_back(u);
    for (int i = 0; i < problem.rowCount(); ++i) {
      const Observation& o = problem.session().observations[problem.rows()[i].observation];
      for (std::size_t s = 0; s < solved_.size() && o.kind == ObservationKind::kContact; ++s)
        if (problem.unknowns()[solved_[s]].owner == o.feature &&
            problem.unknowns()[solved_[s]].component == problem.rows()[i].component)
          placeOf_[i] = static_cast<int>(s);
    }
  }
  /// The coordinates of free points are no genes: (9) gives them, the mean over the postures of where the
  /// probe is.
  static bool solvedInClosedForm(const Problem& problem, int unknown) {
    const Unknown& u = problem.unknowns()[unknown];
    return u.kind == UnknownKind::kFeature && u.priorStd == 0.0 && !problem.poseFree() &&
           problem.session().artifact.poseKnown &&
           problem.session().artifact.features[u.owner].kind == FeatureKind::kPoint;
  }
  /// Puts the points where the chromosome sees them.
  void solve(Eigen::VectorXd& x) const {
    const Eigen::VectorXd means = meansOf(problem_.residuals(x));
    for (std::size_t s = 0; s < solved_.size(); ++s) x[solved_[s]] += means[static_cast<Eigen::Index>(s)];
  }
  std::size_t dimension() const override { return genes_.size(); }
  void evaluate(const double* population, std::size_t count, double* costs) const override {
    for (std::size_t c = 0; c < count; ++c) {
      // A generation may take many seconds; one that is cut short only leaves its rest behind the best.
      if (cancelled_ && cancelled_()) {
        costs[c] = std::numeric_limits<double>::infinity();
        continue;
      }
      Eigen::VectorXd x = base_;
      for (std::size_t g = 0; g < genes_.size(); ++g) x[genes_[g]] = population[c * genes_.size() + g];
      const Eigen::VectorXd r = problem_.residuals(x);
      Eigen::VectorXd means = meansOf(r);
      double sum = 0.0;
      int used = 0;
      for (int i = 0; i < r.size(); ++i) {
        if (inverseSigma_[i] == 0.0) continue;
        const double w =
            (r[i] - (placeOf_[i] >= 0 ? means[placeOf_[i]] : 0.0)) * inverseSigma_[i] * unit_ / metre_;
        sum += w * w;
        ++used;
      }
      for (const UnitVector& v : problem_.unitVectors()) {  // LASER (11), also where the norm is a constraint
        const double h = v.excess(x.data() + v.first) * kMillimetre / metre_;
        sum += (v.penalty > 0.0 ? v.penalty : kPenalty) * h * h;
      }
      for (const int u : genes_) {
        const double priorStd = problem_.unknowns()[static_cast<std::size_t>(u)].priorStd;
        if (priorStd > 0.0) sum += std::pow(x[u] / priorStd * unit_ / metre_, 2);
      }
      costs[c] = sum / std::max(1, used);
    }
  }

 private:
  Eigen::VectorXd meansOf(const Eigen::VectorXd& r) const {
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(solved_.size())), weight = sum;
    for (int i = 0; i < r.size(); ++i) {
      if (placeOf_[i] < 0) continue;
      const double w = inverseSigma_[i] * inverseSigma_[i];
      sum[placeOf_[i]] += w * r[i];
      weight[placeOf_[i]] += w;
    }
    return sum.cwiseQuotient(weight.cwiseMax(kTiny));
  }

  static constexpr double kPenalty = 1e4;  // M of LASER, residuals in mm
  const Problem& problem_;
  const Eigen::VectorXd base_;
  std::vector<int> genes_;
  const Eigen::VectorXd& inverseSigma_;
  double unit_;   // m or rad that a residual of one standard deviation stands for
  double metre_;  // costs are squares of this many metres
  std::function<bool()> cancelled_;
  std::vector<int> solved_;   // unknowns
  std::vector<int> placeOf_;  // a data row: index in solved_, or -1
};

bool allLinear(const Problem& problem) {
  return std::all_of(problem.model().effects().begin(), problem.model().effects().end(),
                     [](const EffectPtr& e) { return e->separable(); });
}

/// Adds one entry to a sparse set of columns.
void addTo(std::vector<SparseColumn>& columns, std::vector<int>& columnOf, int coefficient, std::size_t row,
           std::size_t rows, double value) {
  if (value == 0.0) return;
  int& c = columnOf[coefficient];
  if (c < 0) {
    c = static_cast<int>(columns.size());
    columns.push_back({static_cast<std::size_t>(coefficient), std::vector<double>(rows, 0.0)});
  }
  columns[c].values[row] += value;
}

}  // namespace

GeneticSummary geneticStart(const Problem& problem, Eigen::VectorXd& x, const std::vector<char>& fixed,
                            const Eigen::VectorXd& sigma, const Eigen::VectorXd& weight,
                            const CalibrateOptions& options) {
  const auto& unknowns = problem.unknowns();
  const bool linear = allLinear(problem);
  double unit = 0.0;  // the mean sigma: costs are then squares of metres (or radians)
  for (int i = 0; i < sigma.size(); ++i) unit += sigma[i] / static_cast<double>(sigma.size());
  Eigen::VectorXd inverseSigma = weight.cwiseSqrt().cwiseQuotient(sigma);

  std::vector<int> genes;
  for (int u = 0; u < problem.unknownCount(); ++u)
    if (!fixed[u] && (unknowns[u].kind == UnknownKind::kEffect || unknowns[u].kind == UnknownKind::kSetup ||
                      (!linear && unknowns[u].kind != UnknownKind::kRadius &&
                       !ResidualFitness::solvedInClosedForm(problem, u))))
      genes.push_back(u);
  GeneticSummary summary;
  summary.method = nameOf(options.method);
  summary.seed = options.seed;
  if (genes.empty()) {
    summary.stop = "nothing to search";
    return summary;
  }
  GeneticRanges ranges;
  for (int u : genes) {
    const bool effect = unknowns[u].kind == UnknownKind::kEffect;
    // a mount is searched about where the chain says it is: 1 mm, 0.6 deg and 0.1 of the beam's direction,
    // and the features about where the contacts say they are
    const bool mount = effect && !problem.model().effects()[unknowns[u].owner]->unitVectors().empty();
    double half = mount    ? std::min(unknowns[u].bound, 10.0 * unknowns[u].scale)
                  : effect ? unknowns[u].bound
                           : std::min(unknowns[u].bound, 10.0 * unknowns[u].scale);
    constexpr double kOfScale = 1e-3;  // of a parameter whose start is zero: else its range would be empty
    if (effect && problem.model().effects()[unknowns[u].owner]->ofUnknownSize())
      half = 10.0 * std::max(std::abs(unknowns[u].start), kOfScale * unknowns[u].scale);
    if (effect && unknowns[u].priorStd > 0.0) half = std::min(half, 5.0 * unknowns[u].priorStd);
    ranges.low.push_back(std::max(x[u] - half, unknowns[u].minimum));
    ranges.high.push_back(std::min(x[u] + half, unknowns[u].maximum));
  }

  // LASER's fitness 1 / (1 + G) has a unit: G is in mm^2
  const double length = !linear && options.method == Method::kNiching ? kMillimetre : 1.0;
  std::unique_ptr<GeneticFitness> fitness;
  if (linear) {
    const auto& session = problem.session();
    SphereContacts contacts;
    LinearRows rows;
    std::vector<SphereBall> balls;
    std::vector<int> ballOf(session.artifact.features.size(), -1), geneOf(problem.unknownCount(), -1);
    for (std::size_t g = 0; g < genes.size(); ++g) geneOf[genes[g]] = static_cast<int>(g);
    std::vector<int> sphere, other;
    for (int i = 0; i < problem.rowCount(); ++i) {
      if (inverseSigma[i] == 0.0 || !problem.uses(problem.rows()[i].observation)) continue;
      const Observation& o = session.observations[problem.rows()[i].observation];
      const bool ball = o.kind == ObservationKind::kContact &&
                        session.artifact.features[o.feature].kind == FeatureKind::kBall;
      (ball ? sphere : other).push_back(i);
    }
    const ErrorLayout layout = problem.model().machine().layout();
    Model::Workspace work;
    std::array<std::vector<int>, 3> columnOf;
    for (auto& c : columnOf) c.assign(genes.size(), -1);
    std::vector<int> distanceColumnOf(genes.size(), -1), rowColumnOf(genes.size(), -1);
    for (std::size_t s = 0; s < sphere.size(); ++s) {
      const int o = problem.rows()[sphere[s]].observation;
      const Observation& at = session.observations[o];
      Eigen::Matrix<double, 6, Eigen::Dynamic> unused;
      const ProbePose pose = problem.model().corrected(problem.state(o), x.data(), work, &unused);
      // at the start the genes have values: take their part out, so that the contact is P0 + B c
      Eigen::Vector3d p0 = pose.position;
      double d0 = session.artifact.features[at.feature].radius +
                  (std::isfinite(at.laserReading) ? 0.0 : session.artifact.tipRadius) +
                  work.errors[layout.distance()];
      for (const Model::Derivative& d : work.derivatives) {
        const int g = geneOf[d.parameter];
        if (g < 0) continue;
        for (int k = 0; k < 3; ++k) {
          const double b = work.bySlot(k, d.slot) * d.value;
          addTo(contacts.displacement[k], columnOf[k], g, s, sphere.size(), b);
          p0[k] -= b * x[d.parameter];
        }
        if (d.slot == layout.distance()) {
          addTo(contacts.distanceColumns, distanceColumnOf, g, s, sphere.size(), d.value);
          d0 -= d.value * x[d.parameter];
        }
      }
      for (int k = 0; k < 3; ++k) contacts.position[k].push_back(p0[k]);
      contacts.distance.push_back(d0);
      contacts.weight.push_back(std::pow(inverseSigma[sphere[s]] * unit, 2));
      int& ball = ballOf[at.feature];
      if (ball < 0) {
        ball = static_cast<int>(balls.size());
        SphereBall b;
        b.centre = problem.featureInWorkpiece(at.feature, x);
        b.free = problem.poseFree() || problem.find(UnknownKind::kFeature, at.feature) >= 0;
        balls.push_back(b);
      }
      contacts.ball.push_back(static_cast<std::size_t>(ball));
    }
    int prior = problem.rowCount();  // the rows of the priors follow the data
    for (const int u : problem.priors()) {
      if (fixed[u]) continue;
      if (geneOf[u] >= 0) other.push_back(prior);
      ++prior;
    }
    if (!other.empty()) {
      const WhitenedSystem system(problem, x, inverseSigma, fixed);
      for (std::size_t i = 0; i < other.size(); ++i) {
        double offset = system.residuals[other[i]] * unit;
        for (std::size_t c = 0; c < system.free.size(); ++c) {
          const int g = geneOf[system.free[c]];
          if (g < 0) continue;
          const double b =
              system.jacobian(other[i], static_cast<int>(c)) / system.scale[static_cast<int>(c)] * unit;
          addTo(rows.columns, rowColumnOf, g, i, other.size(), b);
          offset -= b * x[system.free[c]];
        }
        rows.offset.push_back(offset);
      }
    }
    fitness = std::make_unique<SphereFitness>(contacts, balls, rows, genes.size());
  } else {
    fitness =
        std::make_unique<ResidualFitness>(problem, x, genes, inverseSigma, unit, length, options.cancelled);
  }

  GeneticControl control;
  control.cancelled = options.cancelled;
  control.progress = [&](const GeneticProgress& p) {
    if (options.progress)
      options.progress("genetic",
                       static_cast<double>(p.generation) / std::max<std::size_t>(1, p.generations));
  };
  const auto run = [&](auto settings, auto make) {
    settings.seed = options.seed;
    settings.threads = linear ? options.threads : 1;  // formulas are parsed by a thread at a time
    settings.start.clear();
    return make(settings).run(*fitness, ranges, control);
  };
  const auto search = [&] {
    return options.method == Method::kNiching
               ? run(options.niching, [](auto s) { return Niching(s); })
               : run(options.stagedMutation, [](auto s) { return StagedMutation(s); });
  };
  GeneticResult found;
  try {
    found = search();
  } catch (const NumericalError&) {
    if (!options.cancelled || !options.cancelled()) throw;
    summary.stop = nameOf(GeneticStop::kCancelled);  // before the first generation: the start is the best
    return summary;
  }
  for (std::size_t g = 0; g < genes.size(); ++g) x[genes[g]] = found.best[g];
  if (auto* nonlinear = dynamic_cast<ResidualFitness*>(fitness.get())) nonlinear->solve(x);
  summary.rms = found.rms() * length;
  summary.curve = found.rmsCurve();
  for (double& rms : summary.curve) rms *= length;
  summary.generations = found.generations;
  summary.evaluations = found.evaluations;
  summary.seconds = found.seconds;
  summary.stop = nameOf(found.stop);
  return summary;
}

}  // namespace mm
