#include "effects/laser_incidence.h"

#include "effects/catalogue_effect.h"
#include "effects/quantity.h"

namespace mm {
namespace {

class LaserIncidence : public CatalogueEffect {
 public:
  explicit LaserIncidence(SpecReader& read) : CatalogueEffect(read, Stage::kProbe) {
    if (!read.domain().laser) read.fail("the session has no readings of a laser probe (reading_mm)");
    parameters_ = {parameter("offset", kUnitMicrometre, 1e-5, 1e-2)};
  }

  void evaluate(const State& state, const double* p, ErrorSink& sink) const override {
    if (state.feature < 0) return;
    if (state.featureRadius == 0.0 && state.surfaceNormal.squaredNorm() == 0.0)
      return;                                                     // a point has no surface
    const bool known = state.surfaceNormal.squaredNorm() > 0.25;  // false for NaN
    const double cosine = -state.orientation.col(2).dot(state.surfaceNormal);
    sink.add(layout_.reading(), 0, p[0], known ? 1.0 - cosine : kUnknown);
  }

  std::string cause() const override {
    return "On an inclined surface the laser spot is elongated and its centroid shifts: the error of the "
           "reading depends on the angle of incidence.";
  }
  std::string remedy() const override {
    return "Keep the beam within 20 degrees of the surface normal, or leave the correction on.";
  }
  std::string shownBy() const override {
    return "One ball measured at angles of incidence from 0 to about 50 degrees.";
  }
};

}  // namespace

EffectType laserIncidenceType() {
  return effectType<LaserIncidence>("laser_incidence", {}, [](const Domain& domain) {
    std::vector<EffectSpec> specs;
    if (domain.laser) specs.emplace_back("laser_incidence");
    return specs;
  });
}

}  // namespace mm
