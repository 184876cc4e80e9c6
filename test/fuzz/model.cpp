// Model files, and the effects that they name, formulas too.
#include "model/model.h"

#include "fuzz_support.h"
#include "model/model_spec.h"

namespace {

mm::Domain domainOf(const mm::Machine& machine) {
  mm::Domain d;
  for (const mm::Joint& joint : machine.joints()) {
    d.joints.push_back(joint);
    d.lower.push_back(-0.01);
    d.upper.push_back(0.01);
    d.positions.push_back({-0.01, 0.0, 0.01});
  }
  d.sensors = {"bed", "air"};
  d.sensorLower = {19.0, 19.0};
  d.sensorUpper = {23.0, 23.0};
  d.covariates = {"humidity"};
  d.covariateLower = {30.0};
  d.covariateUpper = {60.0};
  d.features = {"b0", "b1"};
  d.featureRadius = {4e-3, 4e-3};
  d.duration = 3600.0;
  return d;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const mm::Machine machine = mm::Machine::load("five_axis");
  static const mm::Domain domain = domainOf(machine);
  mm::ModelSpec spec;
  if (!mm::fuzz::takes([&] { spec = mm::parseModelSpec(mm::fuzz::textOf(data, size), "model.yaml"); }))
    return 0;
  for (const mm::EffectSpec& effect : spec.effects)
    mm::fuzz::takes([&] {
      const mm::Model model(machine, domain, {effect});
      if (model.start().size() != model.parameterCount())
        mm::fuzz::broken("as many start values as parameters");
    });
  return 0;
}
