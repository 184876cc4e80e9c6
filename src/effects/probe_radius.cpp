#include "effects/probe_radius.h"

#include "effects/catalogue_effect.h"
#include "effects/quantity.h"

namespace mm {
namespace {

class ProbeRadius : public CatalogueEffect {
 public:
  explicit ProbeRadius(SpecReader& read) : CatalogueEffect(read, Stage::kProbe) {
    parameters_ = {errorParameter("radius", JointKind::kLinear)};
  }

  void evaluate(const State&, const double* p, ErrorSink& sink) const override {
    sink.add(layout_.distance(), 0, p[0], 1.0);
  }

  std::string cause() const override {
    return "The effective radius of the tip is not the stated one: the entry is wrong, the tip is worn, or "
           "the stylus bends before the probe triggers (pre-travel).";
  }
  std::string remedy() const override {
    return "Qualify the tip on a ball of known radius and enter the effective radius; check the tip for wear "
           "and dirt.";
  }
  std::string shownBy() const override {
    return "Contacts from opposite sides on a ball of known radius, or the distance of two faces.";
  }
};

}  // namespace

EffectType probeRadiusType() {
  return effectType<ProbeRadius>("probe_radius", {}, [](const Domain& domain) {
    std::vector<EffectSpec> specs;
    if (!domain.laser && !ballNames(domain).empty()) specs.emplace_back("probe_radius");
    return specs;
  });
}

}  // namespace mm
