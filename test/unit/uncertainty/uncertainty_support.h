#pragma once
#include <memory>
#include <string>

#include "compensation_support.h"
#include "model/model_spec.h"
#include "uncertainty/task_uncertainty.h"

namespace mm::test {

/// A calibration of the machine three_axis with these effects, all values and covariances zero, no noise.
inline Calibration bareCalibration(const std::vector<std::string>& effects) {
  std::vector<EffectSpec> specs;
  for (const std::string& e : effects) specs.push_back(parseEffectSpec(e, "effect"));
  Calibration c = calibrationOf(Machine::load("three_axis"), specs);
  c.domain.tipLower = Eigen::Vector3d::Constant(-0.020);
  c.domain.tipUpper = Eigen::Vector3d::Constant(0.020);
  c.covariance.setZero();
  c.repeatabilityFrom = "declared";
  return c;
}

/// White noise of so many m, and nothing unexplained.
inline void setNoise(Calibration& c, double repeatability) {
  c.repeatability = c.rms = c.heldOutRms = repeatability;
}

inline std::unique_ptr<MeasurementTask> taskOf(const std::string& text, const Calibration& c,
                                               int points = 0) {
  const Model model(Machine(c.urdf, c.machineName), c.domain, c.effects, c.networks);
  TaskOptions options;
  options.points = points;
  return makeTask(text, options, model);
}

inline TaskUncertainty uncertaintyFor(const std::string& text, const Calibration& c,
                                      const TaskConditions& conditions = {}, std::size_t trials = 40000,
                                      std::uint64_t seed = 1) {
  const std::unique_ptr<MeasurementTask> task = taskOf(text, c);
  MonteCarloOptions options;
  options.trials = trials;
  options.seed = seed;
  return taskUncertainty(*task, VirtualMachine(c, *task, conditions), options);
}

inline const QuantityUncertainty& quantity(const TaskUncertainty& u, const std::string& name) {
  for (const QuantityUncertainty& q : u.quantities)
    if (q.quantity.name == name) return q;
  throw std::logic_error("test: no quantity " + name);
}

inline double shareOf(const QuantityUncertainty& q, const std::string& source) {
  for (const UncertaintyShare& s : q.budget)
    if (s.source == source) return s.share;
  return 0.0;
}

}  // namespace mm::test
