#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <sstream>

#include "base/error.h"
#include "base/format.h"
#include "base/names_of.h"
#include "base/units.h"
#include "machine/linear_inverse.h"
#include "session/artifact_file.h"
#include "session/plan.h"
#include "session/plan_tests.h"
#include "session/plan_ways.h"
#include "session/plan_writer.h"
#include "tools/bounds.h"
#include "tools/commands.h"
#include "tools/one_line.h"
#include "tools/output_files.h"

namespace mm {
namespace {

struct PlanOptions {
  std::string machine, artifact, balls, test, output;
  double radius = 3.9685, tip = 1.0, cone = 90.0, repeatability = 0.0;  // mm, mm, deg, um
  int points = 25;
  PlanTestSize size;
  OutputFiles files;
};

std::vector<double> middleOf(const Machine& machine) {
  std::vector<double> q;
  for (const Joint& j : machine.joints()) q.push_back(0.5 * (j.lower + j.upper));
  return q;
}

/// Where the nominal tip can be, m, workpiece: the box of the corners of the linear travels, rotary joints in
/// the middle.
Eigen::AlignedBox3d reachOf(const Machine& machine) {
  const std::vector<int> linear = linearJoints(machine.joints());
  Eigen::AlignedBox3d reach;
  for (unsigned corner = 0; corner < (1U << linear.size()); ++corner) {
    std::vector<double> q = middleOf(machine);
    for (std::size_t i = 0; i < linear.size(); ++i) {
      const std::size_t joint = static_cast<std::size_t>(linear[i]);
      const Joint& j = machine.joints()[joint];
      q[joint] = (corner >> i & 1U) != 0 ? j.upper : j.lower;
    }
    reach.extend(machine.nominal(q.data(), 0.0).position);
  }
  return reach;
}

/// "3x3". @throw InputError.
std::pair<int, int> gridOf(const std::string& text) {
  int nx = 0, ny = 0;
  char times = 0;
  std::istringstream in(text);
  if (!(in >> nx >> times >> ny) || times != 'x' || !(in >> std::ws).eof() || nx < 1 || ny < 1 || nx > 20 ||
      ny > 20)
    throw InputError("--balls: '" + text + "' is not <columns>x<rows>, each 1 to 20, e.g. 3x3");
  return {nx, ny};
}

/// Balls in a grid over the reach, at three heights in turn, so that scale and squareness of all axes show.
Artifact gridArtifact(const PlanOptions& o, const Machine& machine, double margin) {
  const auto [nx, ny] = gridOf(o.balls);
  const Eigen::AlignedBox3d reach = reachOf(machine);
  const Eigen::Vector3d lower = reach.min().array() + margin, upper = reach.max().array() - margin;
  const double sideways = std::min(upper.x() - lower.x(), upper.y() - lower.y());
  const Eigen::Vector3d size = reach.sizes() / kMillimetre;
  if (sideways < 0.0 || upper.z() < lower.z())
    throw InputError(o.machine + ": a ball of radius " + format("%.6g", o.radius) +
                     " mm with its approach does not fit into the travels of " +
                     format("%.6g x %.6g x %.6g mm", size.x(), size.y(), size.z()) +
                     "; take a smaller --ball-radius-mm");
  Artifact artifact;
  artifact.name = "grid_" + o.balls;
  artifact.poseKnown = false;
  artifact.tipRadius = o.tip * kMillimetre;
  if (o.repeatability > 0.0) artifact.repeatability = o.repeatability * kMicrometre;
  const auto between = [](double a, double b, int i, int n) {
    return n == 1 ? 0.5 * (a + b) : a + (b - a) * i / (n - 1);
  };
  // Stems end below the probe's way: the highest ball leaves room to pass over it.
  const double top = lower.z() + 0.6 * (upper.z() - lower.z());
  for (int iy = 0; iy < ny; ++iy)
    for (int ix = 0; ix < nx; ++ix) {
      Feature ball;
      ball.name = "b" + std::to_string(artifact.features.size());
      ball.radius = o.radius * kMillimetre;
      ball.position = {between(lower.x(), upper.x(), ix, nx), between(lower.y(), upper.y(), iy, ny),
                       between(lower.z(), top, (ix + 2 * iy) % 3, 3)};
      artifact.features.push_back(ball);
    }
  return artifact;
}

/// The joint that moves the probe most along + z of the workpiece, at its highest: everything can be passed.
std::string clearance(const Machine& machine) {
  const std::vector<double> q = middleOf(machine);
  const auto jacobian = machine.jacobian(q.data(), 0.0);
  int best = -1;
  for (const int j : linearJoints(machine.joints()))
    if (best < 0 || std::abs(jacobian(2, j)) > std::abs(jacobian(2, best))) best = j;
  if (best < 0) return {};
  const Joint& joint = machine.joints()[static_cast<std::size_t>(best)];
  const double end = jacobian(2, best) > 0.0 ? joint.upper : joint.lower;
  return "clearance: {" + joint.name + "_mm: " + format("%.6g", end / kMillimetre) + "}\n";
}

std::string touchPlan(const PlanOptions& o, const Machine& machine, const std::string& name) {
  constexpr double kApproach = 1.5, kOvertravel = 1.0;  // mm
  Artifact artifact;
  if (!o.artifact.empty()) {
    artifact = loadArtifact(o.artifact);
  } else {
    const double margin = (o.radius + o.tip + kApproach + 0.5) * kMillimetre;
    artifact = gridArtifact(o, machine, margin);
  }
  std::string text = "name: " + name + "\nartifact:\n" + artifactYaml(artifact, 2);
  text += "speeds: {rapid_mm_s: 10, approach_mm_s: 2}\n";
  text += format("approach: {distance_mm: %.6g, overtravel_mm: %.6g}\n", kApproach, kOvertravel);
  text += clearance(machine);
  // interleaved: time and temperature do not go with the ball; several speeds: a late trigger shows
  text += format(
      "touch:\n  - {features: all, points: %d, cone_deg: %.6g, order: interleaved, "
      "speeds_mm_s: [1, 2, 4]}\n",
      o.points, o.cone);
  if (artifact.repeatability > 0.0) return text;
  constexpr int kTargets = 24;  // touched twice: the repeatability to 15 %
  const int balls = static_cast<int>(artifact.features.size());
  text += format(
      "  # the same touches twice: without a stated repeatability these tell it\n"
      "  - {features: all, points: %d, cone_deg: %.6g, order: interleaved, repeats: 2}\n",
      std::min(o.points, (kTargets + balls - 1) / balls), std::min(o.cone, 60.0));
  return text;
}

/// The tests with what each needs, one a line.
std::string testsText() {
  std::string text = "Tests (--test):\n";
  for (const PlanTest& test : planTests())
    text += format("  %-12s", test.name.c_str()) + test.standard + "\n" + std::string(14, ' ') + "needs " +
            test.needs + "\n";
  return text;
}

void runNewPlan(PlanOptions& o) {
  const PlanTestSize& size = o.size;
  if (o.test.empty() && size.positions > 0) o.test = "positioning";
  const int kinds = (o.artifact.empty() ? 0 : 1) + (o.balls.empty() ? 0 : 1) + (o.test.empty() ? 0 : 1);
  if (kinds != 1)
    throw InputError(std::string(kinds == 0 ? "the plan needs something to measure"
                                            : "only one kind of measurement is possible") +
                     ": give --artifact, --balls, --test or --positions");
  if (o.test.empty() && (size.runs > 0 || size.hours > 0.0 || size.everyMin > 0.0))
    throw InputError("--runs, --hours and --every-min are for --test");
  o.files.input({o.machine, o.artifact});
  o.files.output("-o", o.output, FileKind::kPlan);
  o.files.check();
  const Machine machine = Machine::load(o.machine);
  if (o.test.empty() && linearJoints(machine.joints()).empty())
    throw InputError(o.machine + ": the machine has no linear axis; write its plan by hand (config/plans)");
  const std::string name = std::filesystem::path(o.output).stem().string();
  const std::string text =
      o.test.empty() ? touchPlan(o, machine, name) : testPlan(o.test, size, machine, name);
  const Plan plan =
      Plan::parse(text, o.output, {}, machine);  // within the limits, or a line that says where not
  warn(blockedWaysText(plan, blockedWays(plan, machine)));
  o.files.write(o.output, text);
  std::cout << plan.measurements() << " measurements on " << o.machine << " written to " << o.output << '\n';
}

}  // namespace

void addPlanCommand(CLI::App& app, int& exitStatus) {
  CLI::App* plan =
      app.add_subcommand("plan", "Create a measurement plan, for calibration or for verification");
  plan->require_subcommand(1);
  addPlanVerifyCommand(*plan, exitStatus);
  auto [o, command] = addCommand<PlanOptions>(
      *plan, exitStatus, runNewPlan, "new",
      "Create a measurement plan for a machine: touch an artifact, or read the axes with an instrument");
  command.add_option("--machine", o.machine, "three_axis, five_axis or the path of a URDF")->required();
  command.add_option("--artifact", o.artifact,
                     "artifact file, YAML: the artifact to touch and its position in the workpiece frame");
  command.add_option("--balls", o.balls,
                     "<columns>x<rows>: touch a ball plate that fills the travels, e.g. 3x3");
  standardOption(command, "--ball-radius-mm", o.radius, numberWithin(0.1, 500.0, "mm"), "of --balls");
  standardOption(command, "--tip-radius-mm", o.tip, numberWithin(0.01, 50.0, "mm"), "of --balls");
  standardOption(command, "--repeatability-um", o.repeatability, numberWithin(0.0, 1e4, "um"),
                 "repeatability of the probe, with --balls; 0: not stated");
  standardOption(command, "--points", o.points, wholeNumberWithin(4, 10000), "contacts on each ball");
  standardOption(command, "--cone-deg", o.cone, numberWithin(10.0, 120.0, "deg"),
                 "largest angle of a contact from the top of the ball");
  checkedOption(command, "--test", o.test, CLI::IsMember(allNames(planTests())),
                "measure a test of a standard with an independent instrument; see below what each needs");
  checkedOption(command, "--positions", o.size.positions, wholeNumberWithin(2, 1000),
                "of --test: targets of each axis or line, points of a circle; alone: --test positioning");
  checkedOption(command, "--runs", o.size.runs, wholeNumberWithin(1, 100),
                "of --test: how often they are measured");
  checkedOption(command, "--hours", o.size.hours, numberWithin(0.01, 1000.0, "h"),
                "of --test: how long the machine is loaded, or watched");
  checkedOption(command, "--every-min", o.size.everyMin, numberWithin(0.1, 600.0, "min"),
                "of --test: time between readings (default 5)");
  command.add_option("-o,--output", o.output, "the plan")->required();
  o.files.declare(command);
  command.footer(
      "Edit the plan as needed. Try it with mm simulate; run one that touches with the node measure.\n" +
      testsText() +
      "Examples:\n"
      "  mm plan new --machine mill.urdf --balls 3x3 --points 30 -o mill_plan.yaml\n"
      "  mm plan new --machine mill.urdf --positions 11 -o mill_axes.yaml\n"
      "  mm plan new --machine mill.urdf --test diagonal -o mill_diagonals.yaml");
}

}  // namespace mm
