#include "estimation/genetic_sphere_fitness.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <random>

#include "estimation/genetic_staged_mutation.h"
#include "genetic_mmt_problem.h"
#include "long_tests.h"

namespace mm {
namespace {

using mm_test::MmtContacts;
using mm_test::mmtFitness;
using mm_test::scatterGenes;

/// A small problem with everything that a fitness may have: two balls, one with a known centre, weights, a
/// free radius, linear rows; its cost is computed here with plain loops in double precision.
struct Mixed {
  SphereContacts contacts;
  std::vector<SphereBall> balls;
  LinearRows rows;
  static constexpr std::size_t kCoefficients = 6;

  Mixed() {
    std::mt19937_64 generator(3);
    std::uniform_real_distribution<double> even(-1.0, 1.0);
    balls = {{{0.003, -0.002, 0.001}, true}, {{-0.02, 0.01, 0.005}, false}};
    for (auto& component : contacts.displacement)
      for (std::size_t k : {0u, 2u, 3u, 5u}) component.push_back({k, {}});
    contacts.displacement[1].pop_back();
    contacts.distanceColumns = {{1, {}}};
    for (std::size_t i = 0; i < 467; ++i) {  // not a multiple of any tile, and the balls mixed
      const std::size_t ball = i % 5 < 2 ? 1 : 0;
      Eigen::Vector3d n(even(generator), even(generator), 1.2 + even(generator));
      const double distance = 0.006 + 0.002 * static_cast<double>(ball);
      const Eigen::Vector3d p = balls[ball].centre + (distance + 2e-6 * even(generator)) * n.normalized();
      for (std::size_t axis = 0; axis < 3; ++axis) {
        contacts.position[axis].push_back(p[static_cast<Eigen::Index>(axis)]);
        for (SparseColumn& column : contacts.displacement[axis])
          column.values.push_back(0.02 * (0.7 + even(generator)));
      }
      contacts.distance.push_back(distance);
      contacts.distanceColumns[0].values.push_back(0.01);
      contacts.ball.push_back(ball);
      contacts.weight.push_back(1.0 + 0.5 * even(generator));
    }
    rows.columns = {{0, {}}, {4, {}}};
    for (std::size_t i = 0; i < 11; ++i) {
      rows.offset.push_back(1e-5 * even(generator));
      for (SparseColumn& column : rows.columns) column.values.push_back(0.02 * even(generator));
    }
  }

  double residual(const double* c, std::size_t i, const Eigen::Vector3d& centre) const {
    Eigen::Vector3d p;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      double value = contacts.position[axis][i];
      for (const SparseColumn& column : contacts.displacement[axis])
        value += c[column.coefficient] * column.values[i];
      p[static_cast<Eigen::Index>(axis)] = value;
    }
    return (p - centre).norm() - contacts.distance[i] - c[1] * contacts.distanceColumns[0].values[i];
  }

  /// With the free centre where it stands, or moved to its own least squares.
  double cost(const double* c, bool follow) const {
    Eigen::Vector3d centre = balls[0].centre;
    for (int iteration = 0; follow && iteration < 30; ++iteration) {
      Eigen::Matrix3d h = Eigen::Matrix3d::Zero();
      Eigen::Vector3d g = Eigen::Vector3d::Zero();
      for (std::size_t i = 0; i < contacts.size(); ++i) {
        if (contacts.ball[i] != 0) continue;
        Eigen::Vector3d slope;
        for (int axis = 0; axis < 3; ++axis) {
          const Eigen::Vector3d step = 1e-6 * Eigen::Vector3d::Unit(axis);
          slope[axis] = (residual(c, i, centre + step) - residual(c, i, centre - step)) / 2e-6;
        }
        h += contacts.weight[i] * slope * slope.transpose();
        g += contacts.weight[i] * residual(c, i, centre) * slope;
      }
      centre -= h.ldlt().solve(g);
    }
    double sum = 0.0;
    for (std::size_t i = 0; i < contacts.size(); ++i) {
      const double r = residual(c, i, contacts.ball[i] == 0 ? centre : balls[1].centre);
      sum += contacts.weight[i] * r * r;
    }
    for (std::size_t i = 0; i < rows.offset.size(); ++i) {
      const double r = rows.offset[i] + c[0] * rows.columns[0].values[i] + c[4] * rows.columns[1].values[i];
      sum += r * r;
    }
    return sum / static_cast<double>(contacts.size() + rows.offset.size());
  }
};

std::vector<double> randomPopulation(std::size_t count, std::size_t genes, double size) {
  std::mt19937_64 generator(11);
  std::uniform_real_distribution<double> even(-size, size);
  std::vector<double> population(count * genes);
  for (double& gene : population) gene = even(generator);
  return population;
}

TEST(SphereFitness, costIsThatOfPlainLoops) {
  Mixed mixed;
  mixed.balls[0].free = false;
  const SphereFitness constant(mixed.contacts, mixed.balls, mixed.rows, Mixed::kCoefficients);
  for (const double size :
       {0.2, 1e-3, 1e-5}) {  // displacements of millimetres down to tenths of a micrometre
    SphereFitness fitness = constant;
    const std::vector<double> population = randomPopulation(77, Mixed::kCoefficients, size);
    fitness.newGeneration(std::vector<double>(Mixed::kCoefficients, 0.0).data());
    std::vector<double> costs(77);
    fitness.evaluate(population.data(), 77, costs.data());
    for (std::size_t i = 0; i < 77; ++i) {
      const double expected = mixed.cost(population.data() + i * Mixed::kCoefficients, false);
      EXPECT_NEAR(costs[i], expected, 3e-5 * expected) << size << " chromosome " << i;
    }
  }
}

TEST(SphereFitness, costFollowsTheCentresByLeastSquares) {
  Mixed mixed;
  SphereFitness fitness(mixed.contacts, mixed.balls, mixed.rows, Mixed::kCoefficients, CentreRule::kFollow);
  const std::vector<double> population = randomPopulation(40, Mixed::kCoefficients, 2e-4);  // micrometres
  fitness.newGeneration(std::vector<double>(Mixed::kCoefficients, 0.0).data());
  std::vector<double> costs(40);
  fitness.evaluate(population.data(), 40, costs.data());
  double larger = 0.0;
  for (std::size_t i = 0; i < 40; ++i) {
    const double* c = population.data() + i * Mixed::kCoefficients;
    const double expected = mixed.cost(c, true);
    EXPECT_NEAR(costs[i], expected, 5e-3 * expected);
    larger = std::max(larger, mixed.cost(c, false) / expected);
  }
  EXPECT_GT(larger, 1.2);  // else the test could not tell the two rules apart
}

TEST(SphereFitness, centreOfTheBestIsTheLeastSquaresCentre) {
  Mixed mixed;
  for (const CentreRule rule : {CentreRule::kOfBest, CentreRule::kFollow}) {
    SphereFitness fitness(mixed.contacts, mixed.balls, mixed.rows, Mixed::kCoefficients, rule);
    const std::vector<double> best = {0.01, 1e-4, -0.02,
                                      0.03, 1e-4, 0.015};  // centre moves by tenths of a millimetre
    EXPECT_TRUE(fitness.newGeneration(best.data()));
    double cost = 0.0;
    fitness.evaluate(best.data(), 1, &cost);
    const double expected = mixed.cost(best.data(), true);
    EXPECT_NEAR(cost, expected, 1e-4 * expected);
    EXPECT_GT(mixed.cost(best.data(), false), 1.1 * expected);
    EXPECT_EQ(fitness.balls()[1].centre, mixed.balls[1].centre);
  }
}

TEST(SphereFitness, costDoesNotDependOnTheBlock) {
  Mixed mixed;
  SphereFitness fitness(mixed.contacts, mixed.balls, mixed.rows, Mixed::kCoefficients);
  const std::vector<double> population = randomPopulation(70, Mixed::kCoefficients, 1e-3);
  fitness.newGeneration(population.data());
  std::vector<double> together(70), alone(70);
  fitness.evaluate(population.data(), 70, together.data());
  for (std::size_t i = 0; i < 70; ++i)
    fitness.evaluate(population.data() + i * Mixed::kCoefficients, 1, &alone[i]);
  EXPECT_EQ(together, alone);
}

TEST(SphereFitness, instructionSetsAgree) {
  std::mt19937_64 generator(5);
  std::uniform_real_distribution<float> even(-1.0f, 1.0f);
  SphereBlock block;
  block.terms = {3, 2, 4, 1};
  block.stride = kRowHead + block.terms.total();
  block.contacts = 24;
  block.lanes = 64;
  std::vector<float> rows(block.contacts * block.stride), coefficients(block.terms.total() * block.lanes);
  for (float& value : rows) value = even(generator);
  for (float& value : coefficients) value = 0.1f * even(generator);
  for (std::size_t i = 0; i < block.contacts; ++i) {
    rows[i * block.stride + kSquare] = 9.0f;
    rows[i * block.stride + kDistance] = 3.0f;
  }
  block.rows = rows.data();
  block.coefficients = coefficients.data();
  const auto sumsOf = [&](SphereInstructions instructions) {
    std::vector<double> sums(4 * block.lanes, 0.0);
    addSphereBlock(block, sums.data(), instructions);
    return sums;
  };
  const std::vector<double> portable = sumsOf(SphereInstructions::kPortable);
  for (const auto instructions : {SphereInstructions::kAvx2, SphereInstructions::kAvx512}) {
    if (instructions > sphereInstructions()) continue;
    const std::vector<double> sums = sumsOf(instructions);
    for (std::size_t i = 0; i < sums.size(); ++i) EXPECT_NEAR(sums[i], portable[i], 2e-5);
  }
}

/// MMT's constants on MMT's data: the published population and generations reach the noise.
TEST(SphereFitness, stagedMutationReachesTheNoiseFromEverySeed) {
  const double noise = 0.5e-6;
  const MmtContacts data(17, 40e-6, noise);
  GeneticRanges ranges;
  SphereFitness fitness = mmtFitness(data, 100e-6, CentreRule::kFollow, ranges);
  for (std::uint64_t seed = 1; seed <= (mm_test::thoroughTests() ? 5 : 1); ++seed) {
    StagedMutationSettings settings;
    settings.seed = seed;
    settings.threads = 2;
    SphereFitness own = fitness;
    const GeneticResult result = runStagedMutation(own, ranges, settings);
    EXPECT_LE(std::sqrt(result.cost), 1.5 * noise) << "seed " << seed;
    EXPECT_EQ(result.generations, 100u);
    double field = 0.0;  // judged by the physics: distances of corrected contacts from the centres found
    std::array<double, MmtContacts::kConstants> constants{};
    scatterGenes(result.best.data(), constants.data());
    for (std::size_t i = 0; i < data.readings.size(); ++i) {
      const Eigen::Vector3d p = data.readings[i] + data.deviation(data.readings[i], constants.data());
      const double r = (p - own.balls()[data.ball[i]].centre).norm() - MmtContacts::kDistance;
      field += r * r;
    }
    EXPECT_LE(std::sqrt(field / static_cast<double>(data.readings.size())), 1.5 * noise) << "seed " << seed;
  }
}

TEST(SphereFitness, sameBitsWithOneAndTwoThreads) {
  const MmtContacts data(18, 40e-6, 0.5e-6);
  for (const CentreRule rule : {CentreRule::kFollow, CentreRule::kOfBest}) {
    GeneticRanges ranges;
    const SphereFitness fitness = mmtFitness(data, 100e-6, rule, ranges);
    std::vector<GeneticResult> results;
    for (const unsigned threads : {1u, 2u, 5u}) {
      StagedMutationSettings settings;
      settings.population = 200;
      settings.generations = 12;
      settings.threads = threads;
      SphereFitness own = fitness;
      results.push_back(runStagedMutation(own, ranges, settings));
    }
    for (const GeneticResult& other : results) {
      EXPECT_EQ(results[0].best, other.best);
      EXPECT_EQ(results[0].curve, other.curve);
      EXPECT_EQ(results[0].cost, other.cost);
    }
  }
}

/// The centre GA of MMT (B2): the centre is within 3760 um of where it is thought to be.
TEST(SphereFitness, centreOfABallByItsOwnAlgorithm) {
  std::mt19937_64 generator(2);
  std::normal_distribution<double> normal;
  const Eigen::Vector3d centre(2.1e-3, 12.4e-3, -1.7e-3), guess(0.5e-3, 11e-3, 0.3e-3);
  std::array<std::vector<double>, 3> positions;
  std::vector<double> distances;
  for (int i = 0; i < 233; ++i) {
    const double height = -1.0 + 0.7 * i / 233.0, turn = 2.4 * i;
    const double across = std::sqrt(1.0 - height * height);
    const Eigen::Vector3d n(across * std::cos(turn), height, across * std::sin(turn));
    const Eigen::Vector3d p = centre + (7.937e-3 + 0.5e-6 * normal(generator)) * n;
    for (int axis = 0; axis < 3; ++axis) positions[static_cast<std::size_t>(axis)].push_back(p[axis]);
    distances.push_back(7.937e-3);
  }
  SphereFitness fitness = ballCentreFitness(positions, distances, guess);
  GeneticRanges ranges;
  for (int axis = 0; axis < 3; ++axis) {
    ranges.low.push_back(-3760e-6);
    ranges.high.push_back(3760e-6);
  }
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    StagedMutationSettings settings;
    settings.seed = seed;
    const GeneticResult result = runStagedMutation(fitness, ranges, settings);
    for (int axis = 0; axis < 3; ++axis)
      EXPECT_NEAR(guess[axis] + result.best[static_cast<std::size_t>(axis)], centre[axis], 0.5e-6)
          << "seed " << seed;
    EXPECT_LE(std::sqrt(result.cost), 0.6e-6);
  }
}

}  // namespace
}  // namespace mm
