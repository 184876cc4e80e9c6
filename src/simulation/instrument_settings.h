#pragma once
#include <string>
#include <vector>

#include "base/units.h"
#include "simulation/physics.h"
#include "simulation/roughness.h"
#include "simulation/thermal.h"

namespace mm {

/// Random errors of the measurement.
struct NoiseSettings {
  double repeatability = 0.3e-6;               // m, standard deviation of a latched reading of a linear joint
  double angularRepeatability = 0.0;           // rad, of a rotary joint
  double outlierShare = 0.0;                   // of the contacts
  double outlierSize = 20e-6;                  // m, standard deviation of an outlier
  double studentDof = 0.0;                     // degrees of freedom of the noise; 0: normal
  double missingVelocityShare = 0.0;           // of the contacts: velocity not recorded
  double reference = 0.1e-6;                   // m, of an interferometer or tracker
  double referenceAngular = 0.2 * kArcsecond;  // rad, of an autocollimator
  double laser = 0.4e-6;                       // m, of a laser reading
  double laserDropoutShare = 0.0;              // of the laser readings
  double temperature = 0.02;                   // K
};

/// A one-dimensional laser probe; without it the probe touches.
struct LaserSettings {
  bool present = false;
  double rangeLower = -5e-3, rangeUpper = 5e-3;  // m
  double maxIncidence = 60.0 * kDegree;          // rad
};

/// How the artifact lies on the machine, and how well it is made.
struct PlacementSettings {
  double shift = 50e-6;          // m, when the pose is free
  double turn = 0.03 * kDegree;  // rad, when the pose is free
  double freeCentres = 50e-6;    // m, features whose position is free
};

/// Room, heat and sensors.
struct ThermalSettings {
  Ambient ambient;
  std::vector<HeatSchedule> heat;
  std::vector<std::string> sensors = {"bed", "frame", "motor",
                                      "air"};  // names of bodies; they name the topics too
  double sensorLag = 15.0;                     // s
  double logPeriod = 10.0;                     // s
};

/// The simulated instrument, beside what is wrong with it.
struct InstrumentSettings {
  NoiseSettings noise;
  LaserSettings laser;
  PlacementSettings placement;
  ThermalSettings thermal;
  std::vector<TrueCovariate> covariates;
  Roughness rough;
  std::vector<std::string> errors;  // sources that every such instrument has, written as for --hide

  /// Reads the key `instrument` of a plan file (text), or the defaults where it is missing.
  /// @throw InputError naming source, line and key.
  static InstrumentSettings parse(const std::string& planYaml, const std::string& source);
  /// The heat balances that follow from the settings.
  ThermalModel thermalModel() const;
};

}  // namespace mm
