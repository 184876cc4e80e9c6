#pragma once
#include <limits>

#include "calibration_file/calibration.h"
#include "machine/machine.h"

namespace mm::test {

/// A calibration with a value in every field, awkward numbers among them.
inline Calibration exampleCalibration(double rms = 0.31e-6) {
  Calibration c;
  const Machine machine = Machine::load("three_axis");
  c.machineName = "three_axis";
  c.urdf = machine.urdf();
  c.domain.setMachine(machine);
  c.domain.lower = {-0.02, -0.015, 0.1 + 0.2};
  c.domain.upper = {0.02, 1.0 / 3.0, 0.7};
  c.domain.positions = {{-0.02, 0.0, 0.02}, {}, {5e-324, 1.7976931348623157e308}};
  c.domain.sensors = {"bed", "frame: left"};
  c.domain.sensorLower = {19.9, std::numeric_limits<double>::quiet_NaN()};
  c.domain.sensorUpper = {25.1, std::numeric_limits<double>::quiet_NaN()};
  LearnedNetwork network;
  network.effect = "{type: thermal_network, axis: x, sensors: [bed, \"frame: left\"]}";
  network.active = true;
  network.sensors = {"bed", "frame: left"};
  network.positions = {-0.02, 0.1 + 0.2};
  network.numbers = {1.0, 2.0, 1.0 / 3.0, 5e-324};
  network.summary = "dfnn active: held out 0.4 um; from bed, frame: left # no comment";
  network.heldOut = 0.1 + 0.2;
  c.networks = {network};
  c.domain.covariates = {"humidity"};
  c.domain.covariateLower = {30.0};
  c.domain.covariateUpper = {45.5};
  c.domain.features = {"b0", "true", "1"};
  c.domain.featureRadius = {3.9685e-3, 0.0, 0.1};
  c.domain.duration = 1234.5;
  c.domain.maxSpeed = 0.02;
  c.domain.velocityLower = {-0.02, std::numeric_limits<double>::quiet_NaN(), 0.1 + 0.2};
  c.domain.velocityUpper = {0.01, std::numeric_limits<double>::quiet_NaN(), 1.0 / 3.0};
  c.domain.readingLower = -1.0 / 3.0;
  c.domain.readingUpper = 0.1 + 0.2;
  c.domain.tipLower = {-0.02, -0.015, -0.02};
  c.domain.tipUpper = {0.02, 0.035, 0.02};
  c.domain.artifactExpansion = 11.5e-6;
  EffectSpec scale("scale"), formula("formula");
  scale.keys = {{"axis", {{"x"}, false}}};
  formula.keys = {{"direction", {{"z"}, false}},
                  {"formula", {{"k1*x*y + k2*sin(2*pi*x), # : [odd]"}, false}},
                  {"start", {{"1e-3", "null"}, true}}};
  c.effects = {scale, formula};
  c.values = {{0, "s", "um/m", 1e6, -1.2345678901234567e-4, 3e-7, false},
              {1, "k1", "um", 1e6, 0.1, std::numeric_limits<double>::infinity(), false},
              {1, "k2", "um", 1e6, -0.0, 0.0, true}};
  c.covariance = Eigen::MatrixXd::Zero(3, 3);
  c.covariance << 9e-14, 1.0 / 7.0, 0, 1.0 / 7.0, 2, 0, 0, 0, 0;
  c.sessionSource = "plate session.bag";
  c.sessionHash = "00ff";
  c.sessionEpoch = 1000000012.5;
  c.sessionOrigin = "simulated";
  c.method = "staged_mutation";
  c.seed = 18446744073709551615ull;
  c.observations = 16310;
  c.rms = rms;
  c.heldOutRms = 0.33e-6;
  c.rmsAngular = std::numeric_limits<double>::quiet_NaN();
  c.heldOutRmsAngular = std::numeric_limits<double>::quiet_NaN();
  c.chi2PerDof = 1.02;
  c.degreesOfFreedom = 16289;
  c.artifact = CalibratedBy{"plate: \"no. 7\"", 9, false, 1e-3, 0.1 + 0.2, 2e-7, 1e-7, "A 17", {}};
  c.artifact->found.push_back({"b0", true, true, {0.1, 0.2, 1.0 / 3.0}, {1e-7, 2e-7, 3e-7}, 4e-3, 1e-7});
  c.sessionParts = {{"monday.bag", "0123"}, {"tuesday.bag", "4567"}};
  c.domain.styli = {"A", "B: long"};
  c.domain.recordings = 2;
  c.repeatability = 0.3e-6;
  c.repeatabilityFrom = "declared";
  LedgerEntry first;
  first.action = "calibrate";
  first.time = "2026-11-20T22:00:00Z";
  first.rmsBefore = std::numeric_limits<double>::quiet_NaN();
  LedgerEntry second = first;
  second.action = "add";
  second.effect = formula;
  second.calibration = "20261120T220000Z-01234567";
  c.ledger = {first, second};
  return c;
}

}  // namespace mm::test
