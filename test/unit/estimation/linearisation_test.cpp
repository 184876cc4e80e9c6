#include "estimation/linearisation.h"

#include <gtest/gtest.h>

#include <cmath>

#include "model/observed_domain.h"
#include "simulation/simulate.h"

namespace mm {
namespace {

struct PlateWithPlay {
  Machine machine = Machine::load("three_axis");
  Simulation simulation = simulate(machine, Plan::load("config/plans/nine_ball_plate.yaml", machine),
                                   {{"backlash:x=3um"}, 5, ""});
  Problem problem{simulation.session,
                  Model(machine, observedDomain(simulation.session),
                        std::vector<EffectSpec>{EffectSpec("scale").set("axis", "x"),
                                                EffectSpec("backlash").set("axis", "y")})};
};

/// Somewhere beside the start, each unknown by its typical size.
Eigen::VectorXd away(const Problem& problem, double by) {
  Eigen::VectorXd x = problem.start();
  for (int u = 0; u < problem.unknownCount(); ++u) x[u] += by * problem.unknowns()[u].scale;
  return x;
}

TEST(Linearisation, IsTheProblemAndItsSlopesAtItsPoint) {
  const PlateWithPlay plate;
  const Problem& problem = plate.problem;
  const Eigen::VectorXd x = away(problem, 0.3);
  const Linearisation at = linearise(problem, x);
  EXPECT_EQ(at.x(), x);
  EXPECT_EQ(at.residuals(), problem.residuals(x));
  for (int u = 0; u < problem.unknownCount(); ++u) {
    const double step = 1e-3 * problem.unknowns()[u].scale;
    Eigen::VectorXd up = x, down = x;
    up[u] += step, down[u] -= step;
    const Eigen::VectorXd slope = (problem.residuals(up) - problem.residuals(down)) / (2.0 * step);
    EXPECT_LT((slope - at.jacobian().col(u)).norm(), 1e-5 * std::max(1.0, slope.norm())) << u;
  }
}

TEST(Linearisation, AnEffectOfTheModelHasTheColumnsOfItsUnknowns) {
  const PlateWithPlay plate;
  const Linearisation at = linearise(plate.problem, plate.problem.start());
  const Effect& scale = *plate.problem.model().effects()[0];
  const Eigen::MatrixXd columns = at.effectColumns(scale, {0.0});
  EXPECT_LT((columns.col(0) - at.jacobian().col(0)).norm(), 1e-12 * columns.norm());
  std::vector<char> asked(plate.simulation.session.observations.size(), 0);
  asked[3] = 1;
  const Eigen::MatrixXd one = at.effectColumns(scale, {0.0}, &asked);
  const int row = plate.problem.firstRow(3);
  EXPECT_EQ(one(row, 0), columns(row, 0));
  EXPECT_EQ(one.norm(), std::abs(columns(row, 0)));
}

TEST(Linearisation, IsAValueThatNoOtherPointChanges) {
  const PlateWithPlay plate;
  const Linearisation at = linearise(plate.problem, plate.problem.start());
  const Linearisation copy = at;
  const Linearisation other = linearise(plate.problem, away(plate.problem, 50.0));
  EXPECT_EQ(copy.jacobian(), at.jacobian());
  EXPECT_EQ(copy.slotGradients(), at.slotGradients());
  EXPECT_NE(other.residuals(), at.residuals());
  EXPECT_NE(other.slotGradients(), at.slotGradients());
}

TEST(Linearisation, GroupsCoverTheUnknownsInTheirOrder) {
  const PlateWithPlay plate;
  const Problem& problem = plate.problem;
  int next = 0;
  for (const UnknownGroup& group : linearise(problem, problem.start()).groups()) {
    EXPECT_EQ(group.first, next);
    EXPECT_EQ(problem.find(group.kind, group.owner), group.first);
    for (int u = group.first; u < group.first + group.count; ++u) {
      EXPECT_EQ(problem.unknowns()[u].kind, group.kind);
      EXPECT_EQ(problem.unknowns()[u].owner, group.owner);
    }
    next += group.count;
  }
  EXPECT_EQ(next, problem.unknownCount());
}

}  // namespace
}  // namespace mm
