#include "tools/population_prior.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>

#include "benchmark_session.h"
#include "fleet/fleet_database.h"
#include "session/plan.h"
#include "simulation/simulate.h"

namespace mm {
namespace {

namespace fs = std::filesystem;

const std::vector<std::string> kEffects{"{type: scale, axis: x}", "{type: scale, axis: y}",
                                        "{type: squareness, axis: y, of: x}"};

/// A session of a machine that has none of the errors of the model, and what sisters say of these errors.
class PriorFigures : public testing::Test {
 protected:
  PriorFigures() {
    std::string pattern = (fs::temp_directory_path() / "mm_prior_XXXXXX").string();
    folder_ = mkdtemp(pattern.data());
    std::string yaml = "machine: three_axis\neffects:\n";
    for (const std::string& effect : kEffects) yaml += "  - " + effect + "\n";
    model_ = parseModelSpec(yaml, "model");
    options_.method = Method::kLeastSquares;
  }
  ~PriorFigures() override { fs::remove_all(folder_); }
  static Session session(int contacts, std::uint64_t seed = 1) {
    std::ifstream in("config/plans/nine_ball_plate.yaml");
    std::ostringstream text;
    text << in.rdbuf();
    SessionVariant variant;
    variant.contacts = contacts;
    const Machine machine = Machine::load("three_axis");
    SimulationRequest request;
    request.seed = seed;
    return simulate(machine, Plan::parse(varied(text.str(), "plan", variant), "plan", {}, machine), request)
        .session;
  }
  /// Results of eight sisters whose errors are 0 but for this standard deviation, um/m.
  std::string sisters(double spread) const {
    const ResultsFolder results(folder_);
    FleetDatabase tables(results.database(), Database::Use::kWrite);
    std::mt19937_64 random(4);
    std::normal_distribution<double> normal;
    std::vector<BatchJob> jobs(8);
    std::vector<JobResult> all;
    for (std::size_t m = 0; m < jobs.size(); ++m) {
      jobs[m].key = std::to_string(m);
      jobs[m].machine = "m" + jobs[m].key;
      jobs[m].bag = "/" + jobs[m].key + ".bag";
      JobResult r;
      r.key = jobs[m].key;
      r.status = "done";
      for (const std::string& effect : kEffects)
        r.parameters.push_back({effect, effect.find("scale") != std::string::npos ? "scale" : "slope", "um/m",
                                spread * normal(random), 0.01 * spread, false});
      all.push_back(r);
    }
    tables.plan(jobs);
    tables.enter(all, results);
    return folder_.string();
  }
  fs::path folder_;
  ModelSpec model_;
  CalibrateOptions options_;
};

TEST_F(PriorFigures, areThoseOfTheSessionWhereThePriorSaysNothing) {
  const Session s = session(60);
  const Recalibration alone = recalibrate(s, model_, options_);
  const Recalibration both =
      PriorOfSisters(sisters(1e6), {}).join(recalibrate(s, model_, options_), s, options_);
  EXPECT_NEAR(both.calibration.heldOutRms, alone.calibration.heldOutRms, 1e-3 * alone.calibration.heldOutRms);
  const double dof = alone.result.figures.degreesOfFreedom;
  EXPECT_NEAR(both.calibration.chi2PerDof, alone.calibration.chi2PerDof * dof / (dof + 3.0),
              0.02 * alone.calibration.chi2PerDof);
}

TEST_F(PriorFigures, areBetterWhereThePriorKnowsWhatTheSessionHardlyShows) {
  const std::string folder = sisters(0.5);
  double without = 0.0, with = 0.0;
  for (std::uint64_t seed = 1; seed <= 16; ++seed) {  // of one session it is a matter of chance
    const Session s = session(30, seed);
    const Recalibration alone = recalibrate(s, model_, options_);
    const Recalibration both = PriorOfSisters(folder, {}).join(recalibrate(s, model_, options_), s, options_);
    if (both.calibration.method == alone.calibration.method) continue;  // contradicted by chance
    without += std::pow(alone.calibration.heldOutRms, 2);
    with += std::pow(both.calibration.heldOutRms, 2);
    EXPECT_EQ(both.calibration.ledger.at(0).heldOutAfter, both.calibration.heldOutRms);
    EXPECT_EQ(both.result.figures.heldOutRms, both.calibration.heldOutRms);
  }
  EXPECT_GT(with, 0.0);
  EXPECT_LT(with, without);
}

}  // namespace
}  // namespace mm
