#include <iostream>

#include "base/error.h"
#include "base/format.h"
#include "base/units.h"
#include "calibration_file/calibration_yaml.h"
#include "session/plan_writer.h"
#include "tools/commands.h"
#include "tools/one_line.h"
#include "tools/output_files.h"

namespace mm {
namespace {

struct ArtifactCommand {
  std::string calibration, output;
  OutputFiles files;
};

/// As the sessions found it: a position's standard uncertainty is the largest of its three.
Artifact foundArtifact(const CalibratedBy& by) {
  Artifact artifact;
  artifact.name = by.name;
  artifact.serial = by.serial;
  artifact.poseKnown = false;
  artifact.tipRadius = by.tipRadius;
  for (const FoundInArtifact& f : by.found) {
    Feature feature;
    feature.name = f.name;
    feature.kind = f.ball ? FeatureKind::kBall : FeatureKind::kPoint;
    feature.position = f.position;
    feature.positionStd = f.std.maxCoeff();
    feature.radius = f.radius;
    feature.radiusStd = f.radiusStd;
    artifact.features.push_back(std::move(feature));
  }
  return artifact;
}

std::string tableOf(const CalibratedBy& by) {
  std::string text = "artifact '" + by.name + "'" + (by.serial.empty() ? "" : ", serial " + by.serial) +
                     ", in its own frame; ± is twice the standard uncertainty\n";
  for (const FoundInArtifact& f : by.found)
    text += "  " + f.name + ": " +
            format("%.5f %.5f %.5f mm", f.position.x() / kMillimetre, f.position.y() / kMillimetre,
                   f.position.z() / kMillimetre) +
            (f.free ? format(" ± %.2g %.2g %.2g um", 2.0 * f.std.x() / kMicrometre,
                             2.0 * f.std.y() / kMicrometre, 2.0 * f.std.z() / kMicrometre)
                    : std::string(" as in its file")) +
            "\n";
  return text;
}

void runArtifact(ArtifactCommand& c) {
  c.files.input(c.calibration);
  c.files.output("-o", c.output, FileKind::kArtifact);
  c.files.check();
  const Calibration calibration = loadCalibration(c.calibration);
  if (!calibration.artifact || calibration.artifact->found.empty())
    throw InputError(c.calibration +
                     ": contains no artifact: it was calibrated without one, or by an older version; "
                     "calibrate again with a session that measured one");
  std::cout << tableOf(*calibration.artifact);
  bool free = false;
  for (const FoundInArtifact& f : calibration.artifact->found) free |= f.free;
  if (!free)
    warn(
        "every position was taken from the artifact file and none was estimated: declare them free (centre: "
        "free) and measure the artifact in several placements");
  if (c.output.empty()) return;
  c.files.write(c.output, artifactYaml(foundArtifact(*calibration.artifact)));
  std::cout << "written to " << c.output << '\n';
  say("a calibration does not store styli, repeatability, expansion and temperature sensor: copy these lines "
      "from the original artifact file");
}

}  // namespace

void addArtifactCommand(CLI::App& app, int& exitStatus) {
  auto [c, command] = addCommand<ArtifactCommand>(
      app, exitStatus, runArtifact, "artifact",
      "Write the artifact file with the positions and radii that a calibration estimated");
  command.add_option("calibration", c.calibration, "the calibration file")->required();
  command.add_option("-o,--output", c.output, "the artifact file");
  c.files.declare(command);
  command.footer(
      "Quantities declared free, or known with an uncertainty, get their estimates; all others are "
      "unchanged.\n"
      "Example:\n"
      "  mm calibrate flat.bag turned.bag --model model.yaml -o plate.yaml\n"
      "  mm artifact plate.yaml -o plate_measured.yaml");
}

}  // namespace mm
